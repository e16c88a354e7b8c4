"""The error that a run folder which cannot be shown raises."""


class ReportError(ValueError):
    """A run folder or picture that cannot be used; the message says what, where and what to do."""
