"""The tables of a stack are bounded as the messages that tell of them."""

from pathlib import Path

import pytest

from bridge.errors import BadInput
from stack.format import CameraTable
from stack.tables import as_table

CAMERA = {"width": 32, "height": 24, "fx": 40.0, "fy": 40.0, "cx": 15.5, "cy": 11.5}


@pytest.mark.parametrize("key", ["shutters_s", "apertures"])
@pytest.mark.parametrize("value", [1e300, 1e-300])
def test_a_setting_that_no_message_holds_is_refused(key: str, value: float) -> None:
    """`describe` told it, and the session called that a defect of its server."""
    with pytest.raises(BadInput, match=rf"stack.toml: expected .* in \[{key} 1\]"):
        as_table({**CAMERA, key: [value]}, CameraTable, Path("stack.toml"))
