"""The error that bad geometry raises."""


class GeometryError(ValueError):
    """A pose, camera or model that cannot be used; the message says what, where and what to do."""
