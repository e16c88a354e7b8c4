import json
import math
from pathlib import Path
from typing import Any

import msgspec
import pytest

from bridge import image_messages as i
from bridge import messages as m
from bridge import start_messages as s
from bridge import vision_messages as v
from bridge.commands.results import prolog_results
from tests.bridge.plain_messages import CAMERA, CAPTURED, DESCRIBE, POSE, SETTINGS
from vision_server.matchers import MATCHERS

START: dict[str, Any] = {"image_server": "ipc:///tmp/i"}

GOOD: list[tuple[Any, dict[str, Any]]] = [
    (m.NoArgs, {}),
    (m.Settings, SETTINGS),
    (m.Settings, {**SETTINGS, "focal_length_mm": None, "focus_m": 0.5}),
    (m.PoseMessage, POSE),
    (m.LightDescription, {"name": "sun", "levels": 1}),
    (m.CameraDescription, CAMERA),
    (m.TargetDescription, {"model": "/m/cube.cao"}),
    (m.Describe, DESCRIBE),
    (m.Event, {"event": "sun_changed", "sequence": 1, "args": {"x": [1.0]}}),
    (i.ImageCaptureArgs, {"settings": SETTINGS}),
    (i.ImageCaptureResult, CAPTURED),
    (i.MoveArgs, {"range_m": 0.5}),
    (i.ScoreArgs, {"pose": POSE}),
    (i.PoseErrorMessage, {"rotation_deg": 0, "translation_m": 0, "translation_fraction_of_range": 0}),
    (s.StartArgs, START),
    (s.StartArgs, {"image_server": "ipc:///tmp/a folder/i"}),
    (s.StartArgs, {**START, "matcher": "genetic", "unit": "mm", "seed": 3, "out": "runs/a"}),
    (s.RestoreArgs, {**START, "out": "runs/a", "images": ["i1", "i2"], "discarded": ["i3"]}),
    (v.VisionCaptureArgs, {"image": "i1", "settings": SETTINGS}),
    (v.EstimateArgs, {"images": ["i1", "i2"]}),
    (v.DiscardArgs, {"image": "i1"}),
    (v.ParametersArgs, {"threshold": 0.5, "method": "em", "on": True, "n": 3}),
]

BAD: list[tuple[Any, dict[str, Any], str]] = [
    (m.NoArgs, {"x": 1}, "unknown field"),
    (i.ImageCaptureArgs, {"settings": SETTINGS, "number": 10**9}, "number"),
    (i.RestartArgs, {"captures_taken": 10**9}, "captures_taken"),
    (m.Settings, {**SETTINGS, "iso": 100}, "unknown field"),
    (m.Settings, {**SETTINGS, "lights": [-1]}, "lights"),
    (m.Settings, {**SETTINGS, "lights": [1.5]}, "lights"),
    (m.Settings, {**SETTINGS, "lights": [True]}, "lights"),
    (m.Settings, {**SETTINGS, "shutter_s": 0}, "shutter_s"),
    (m.Settings, {**SETTINGS, "shutter_s": "0.1"}, "shutter_s"),
    (m.Settings, {**SETTINGS, "aperture": -4.0}, "aperture"),
    (m.Settings, {**SETTINGS, "focus_m": 0}, "focus_m"),
    (m.Settings, {"lights": [1], "shutter_s": 0.1}, "aperture"),
    (m.PoseMessage, {**POSE, "translation": [0, 0]}, "translation"),
    (m.LightDescription, {"name": "l", "levels": 0}, "levels"),
    (m.CameraDescription, {**CAMERA, "fx": 0}, "fx"),
    (m.CameraDescription, {**CAMERA, "distortion": [0]}, "distortion"),
    (m.TargetDescription, {"model": ""}, "model"),
    (m.TargetDescription, {"model": "a", "unit": "ft"}, "unit"),
    (m.Describe, {**DESCRIBE, "shutters_s": []}, "shutters_s"),
    (m.Describe, {**DESCRIBE, "true_pose": POSE}, "unknown field"),
    (m.Event, {"event": "earthquake", "sequence": 1}, "event"),
    (m.Event, {"event": "sun_changed", "sequence": 0}, "sequence"),
    (m.Event, {"v": 2, "event": "sun_changed", "sequence": 1}, "v"),
    (m.PoseMessage, {**POSE, "translation": [0, 0, 1e300]}, "translation"),
    (m.PoseMessage, {**POSE, "translation": [0, 0, 10**30]}, "translation"),
    (m.PoseMessage, {**POSE, "rotation_vector": [-(10**400), 0, 0]}, "rotation_vector"),
    (i.RestartArgs, {"captures_taken": 10**18}, "captures_taken"),
    (i.ImageCaptureArgs, {}, "settings"),
    (i.ImageCaptureResult, {**CAPTURED, "sha256": "zz"}, "sha256"),
    (i.MoveArgs, {"range_m": 0}, "range_m"),
    (i.ScoreArgs, {"pose": None}, "pose"),
    (s.StartArgs, {"image_server": "nowhere"}, "image_server"),
    (s.StartArgs, {**START, "matcher": "lucky"}, "matcher"),
    (s.StartArgs, {**START, "seed": -1}, "seed"),
    (s.RestoreArgs, START, "out"),
    (v.VisionCaptureArgs, {"image": "../etc", "settings": SETTINGS}, "image"),
    (v.VisionCaptureArgs, {"image": "", "settings": SETTINGS}, "image"),
    (v.EstimateArgs, {"images": []}, "images"),
    (v.EstimateArgs, {"images": ["i1"] * 257}, "images"),
    (v.DiscardArgs, {"image": "a b"}, "image"),
    (v.DiscardArgs, {"image": "i1\n"}, "image"),
    (s.StartArgs, {**START, "out": "runs/a\0b"}, "out"),
    (s.StartArgs, {"image_server": "ipc:///a\0b"}, "image_server"),
    (s.StartArgs, {"image_server": "inproc://a"}, "image_server"),
    (v.ParametersArgs, {"x": [1]}, "got `array`"),
]


@pytest.mark.parametrize(("kind", "value"), GOOD)
def test_a_valid_message_survives_the_wire(kind: Any, value: dict[str, Any]) -> None:
    decoded = msgspec.json.decode(msgspec.json.encode(value), type=kind)
    assert msgspec.json.decode(msgspec.json.encode(decoded), type=kind) == decoded
    again = msgspec.to_builtins(decoded)
    for key, given in value.items():
        assert msgspec.json.encode(again[key]) == msgspec.json.encode(
            msgspec.to_builtins(getattr(decoded, key) if hasattr(decoded, key) else given)
        )


@pytest.mark.parametrize(("kind", "value", "complaint"), BAD)
def test_a_bad_message_is_refused_and_the_field_named(
    kind: Any, value: dict[str, Any], complaint: str
) -> None:
    with pytest.raises(msgspec.ValidationError, match=complaint):
        msgspec.json.decode(json.dumps(value).encode(), type=kind)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_numbers_that_are_not_finite_are_refused_from_python_too(bad: float) -> None:
    with pytest.raises(ValueError, match=r"translation\[2\]"):
        m.PoseMessage(rotation_vector=(0.0, 0.0, 0.0), translation=(0.0, 0.0, bad))
    with pytest.raises(msgspec.ValidationError, match="shutter_s"):
        msgspec.convert({**SETTINGS, "shutter_s": bad}, m.Settings)
    with pytest.raises(ValueError, match=r"args\.a\[0\]"):
        m.Event(event="sun_changed", sequence=1, args={"a": [bad]})


def test_settings_can_be_compared_and_kept_in_sets() -> None:
    one = msgspec.convert(SETTINGS, m.Settings)
    assert {one, msgspec.convert(SETTINGS, m.Settings)} == {one}


def test_every_operation_of_the_protocol_has_a_type() -> None:
    assert set(i.IMAGE_OPERATIONS) == {
        "hello",
        "describe",
        "capture",
        "health",
        "restart",
        "move",
        "score",
        "shutdown",
    }
    assert set(v.VISION_OPERATIONS) == {
        "hello",
        "start",
        "capture",
        "estimate",
        "discard",
        "best",
        "parameters",
        "restore",
        "add",
        "appraise",
        "predict",
        "track",
        "check",
        "end",
        "health",
        "shutdown",
    }


def test_the_types_that_the_controller_checks_replies_by_are_these(root: Path) -> None:
    assert (root / "bridge" / "prolog" / "results.pl").read_text() == prolog_results()


def test_the_matchers_that_are_named_are_those_there_are() -> None:
    assert set(s.MATCHER_NAMES) == set(MATCHERS)
