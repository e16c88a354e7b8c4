"""Answers of servers of other releases, and of others' servers."""

from typing import Any

import msgspec
import numpy as np
import pytest

from bridge.arrays import array_sha256
from bridge.envelope import decode_reply
from bridge.errors import DeviceError
from bridge.image_messages import ImageCaptureResult
from bridge.messages import Describe, Settings
from bridge.received import received, received_frame
from tests.bridge.plain_messages import CAPTURED, DESCRIBE, SETTINGS

FRAME = np.arange(12, dtype=np.uint16).reshape(3, 4)


def test_keys_that_are_not_known_are_let_be_at_any_depth() -> None:
    target = {**DESCRIBE["target"], "colour": "grey"}
    lights = [{**light, "wavelength_nm": 850} for light in DESCRIBE["lights"]]
    told = received({**DESCRIBE, "maker": "ACME", "lights": lights, "target": target}, Describe)
    assert told == msgspec.convert(DESCRIBE, Describe)
    event = {"event": "light_fault", "args": {"light": "left", "lamp_h": 900}, "room": 3}
    frame = {**CAPTURED, "temperature_c": 31.5, "applied": {**SETTINGS, "iso": 100}, "events": [event]}
    header = received(frame, ImageCaptureResult)
    assert header.applied == msgspec.convert(SETTINGS, Settings)
    assert header.events[0].args == {"light": "left", "lamp_h": 900}
    assert decode_reply(b'{"v": 1, "id": "a/1", "ok": true, "result": {}, "took_s": 0.1}').result == {}


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"sha256": "zz"}, "sha256"),
        ({"applied": {"lights": [0], "aperture": 4.0, "shuter_s": 0.1}}, "required field `shutter_s`"),
        ({"events": [{"event": "light_fault"}]}, r"light_fault: .*required field `light`.*events\[0\]"),
        ({"events": [{"event": "light_fault", "args": {"light": 3}}]}, r"`\$.light`.*events\[0\]"),
        ({"events": [{"event": "target_moved", "args": {"range_m": "near"}}]}, "range_m"),
        ({"events": 3}, "events"),
        ({"requested": None}, "requested"),
    ],
)
def test_what_is_known_must_be_right(changes: dict[str, Any], complaint: str) -> None:
    with pytest.raises(msgspec.ValidationError, match=complaint):
        received({**CAPTURED, **changes}, ImageCaptureResult)


def test_a_frame_is_the_one_of_its_header() -> None:
    header = msgspec.convert({**CAPTURED, "sha256": array_sha256(FRAME)}, ImageCaptureResult)
    assert received_frame(header, [FRAME], "ipc:///i") is FRAME
    with pytest.raises(DeviceError, match="ipc:///i sent a frame whose sha256 is not that of its header"):
        received_frame(header, [FRAME[::-1]], "ipc:///i")
    for arrays in ([], [FRAME, FRAME], [FRAME.astype(float)], [FRAME[0]]):
        with pytest.raises(DeviceError, match="no grey frame"):
            received_frame(header, arrays, "ipc:///i")
