import pytest

from bridge import errors as e

CASES = [
    (e.LightsAndCameraError("m", "h"), "error", e.EXIT_DEVICE),
    (e.BadInput("m", "h"), "bad_input", e.EXIT_BAD_INPUT),
    (e.DeviceError("m", "h"), "device_error", e.EXIT_DEVICE),
    (e.Unsupported("m", "h"), "unsupported", e.EXIT_DEVICE),
    (e.ProtocolError("bad_frames", "m", "h"), "bad_frames", e.EXIT_DEVICE),
    (e.ServerError("whatever", "m", "h"), "whatever", e.EXIT_DEVICE),
]


@pytest.mark.parametrize(("error", "code", "status"), CASES, ids=lambda case: type(case).__name__)
def test_an_error_carries_code_message_and_hint(
    error: e.LightsAndCameraError, code: str, status: int
) -> None:
    assert (error.code, error.message, error.hint, error.exit_status) == (code, "m", "h", status)
    assert str(error) == "m h"


def test_a_timeout_says_who_and_how_long() -> None:
    error = e.BridgeTimeout("ipc:///tmp/x", "capture", 2.5)
    assert "ipc:///tmp/x" in str(error)
    assert "'capture'" in str(error)
    assert "2.5 s" in str(error)
    assert error.code == "timeout"


def test_no_hint_leaves_no_space() -> None:
    assert str(e.BadInput("m")) == "m"
