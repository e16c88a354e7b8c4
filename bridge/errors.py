"""The small family of errors that cross a process boundary.

Every error has a ``code`` for programs, a ``message`` that says what and where, and a ``hint`` that says what
to do. A server turns each of them into an error reply; the other side gets the three parts back.
"""

from typing import ClassVar

EXIT_BAD_INPUT = 2
"""Exit status of a command that was given something it cannot work with."""
EXIT_NO_POSE = 3
"""Exit status of a command that did what it was asked to, and found no pose."""
EXIT_DEVICE = 4
"""Exit status of a command whose device or server failed for good."""


class LightsAndCameraError(Exception):
    """Base of the family.

    Parameters
    ----------
    message
        What went wrong and where, in one plain sentence.
    hint
        What to do about it; may be empty.
    """

    code: str = "error"
    exit_status: ClassVar[int] = EXIT_DEVICE

    def __init__(self, message: str, hint: str = "") -> None:
        super().__init__(message, hint)
        self.message = message
        self.hint = hint

    def __str__(self) -> str:
        return f"{self.message} {self.hint}".strip()


class BadInput(LightsAndCameraError):  # noqa: N818
    """A file, an option or a value that cannot be used."""

    code = "bad_input"
    exit_status = EXIT_BAD_INPUT


class DeviceError(LightsAndCameraError):
    """A camera, a light or a recorded stack did not do what was asked."""

    code = "device_error"


class DeviceBusy(DeviceError):  # noqa: N818
    """Another program has the camera or the lights."""


class Unsupported(LightsAndCameraError):  # noqa: N818
    """The device is sound, but has no such operation or setting."""

    code = "unsupported"


class ProtocolError(LightsAndCameraError):
    """A message that breaks the wire protocol; ``code`` says in which way.

    ``request_id`` is the id of the offending request where it could be read.
    """

    def __init__(self, code: str, message: str, hint: str = "", request_id: str | None = None) -> None:
        super().__init__(message, hint)
        self.code = code
        self.request_id = request_id


class ServerError(LightsAndCameraError):
    """An error reply, as the client sees it; ``code`` is the server's."""

    def __init__(self, code: str, message: str, hint: str = "") -> None:
        super().__init__(message, hint)
        self.code = code


class BridgeRefused(LightsAndCameraError):  # noqa: N818
    """A server ends the connection in its handshake."""

    code = "refused"

    def __init__(self, endpoint: str) -> None:
        super().__init__(
            f"The server at {endpoint} does not let this client in.",
            "Has each of the two the key that the other expects (--keys)? Is it a server of this protocol?",
        )


class BridgeTimeout(LightsAndCameraError):  # noqa: N818
    """A server did not answer within the deadline."""

    code = "timeout"

    def __init__(self, endpoint: str, op: str, seconds: float) -> None:
        super().__init__(
            f"The server at {endpoint} did not answer {op!r} within {seconds:g} s.",
            "Does it run, and listen there?",
        )
        self.endpoint = endpoint
        self.op = op
        self.seconds = seconds


class BridgeAbsent(LightsAndCameraError):  # noqa: N818
    """Nobody is at an endpoint, or nobody any more."""

    code = "absent"

    def __init__(self, endpoint: str, seconds: float) -> None:
        super().__init__(
            f"Nobody has listened at {endpoint} for {seconds:g} s.",
            "Is the path right, and does the server run?",
        )
