"""The vision server on real sockets, with a simulated image server behind it."""

from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from bridge import mock_physics
from bridge.client import Client
from bridge.errors import ServerError
from bridge.image_messages import IMAGE_OPERATIONS
from bridge.messages import Settings, TargetDescription
from bridge.mocks import MockImageServer
from bridge.start_messages import CauseTold
from bridge.vision_messages import VISION_OPERATIONS, VisionCaptureResult
from geometry.pose import Pose
from image_server.simulator.simulator import Simulator
from tests.vision_server.serve.running import SETTINGS, Running, asked


def test_a_session_from_start_to_best(
    vision: Client, images: Running, simulator: Simulator, tmp_path: Path
) -> None:
    started = asked(vision, "start", image_server=images.endpoint, seed=3, out=str(tmp_path))
    told = started["model"]
    assert (told["name"], told["lines"], told["faces"], told["doubt"]) == ("cube", 12, 6, None)
    assert told["diameter_m"] == pytest.approx(0.2 * 3**0.5)
    assert 100 < told["picture_px"] < 600
    assert [light["name"] for light in started["describe"]["lights"]] == ["left", "right", "top"]
    assert asked(vision, "best")["pose"] is None
    captured = asked(vision, "capture", image="i1", settings=SETTINGS)
    assert captured["verified"]
    assert captured["applied"]["lights"] == SETTINGS["lights"]
    statistics = captured["statistics"]
    assert 0 <= statistics["p05"] <= statistics["p50"] <= statistics["p95"] <= 1
    assert statistics["frame"]["dark_fraction"] > statistics["dark_fraction"]
    assert statistics["blur_px"] is None or statistics["blur_px"] < 2
    assert captured["seconds"]["capture"] > 0
    estimate = asked(vision, "estimate", images=["i1"])
    pose = Pose.from_dict(estimate["pose"])
    assert pose.error_to(simulator.true_pose).within(1.0, 0.01)
    assert np.array(estimate["covariance"]).shape == (6, 6)
    assert {line["image"] for line in estimate["lines"]} <= {"i1", None}
    assert asked(vision, "estimate", images=["i1"]) == estimate
    assert asked(vision, "best")["pose"] == estimate["pose"]
    assert asked(vision, "discard", image="i1")["images"] == []
    with pytest.raises(ServerError, match="i1"):
        asked(vision, "estimate", images=["i1"])
    with pytest.raises(ServerError, match="i1"):
        asked(vision, "capture", image="i1", settings=SETTINGS)


def test_gains_are_foreseen_once_there_is_a_pose(vision: Client, images: Running) -> None:
    asked(vision, "start", image_server=images.endpoint)
    dark = SETTINGS | {"lights": [0, 0, 0], "shutter_s": 1 / 240}
    assert asked(vision, "predict", settings=[SETTINGS]) == {"gains": None, "found": []}
    asked(vision, "capture", image="i1", settings=SETTINGS)
    assert asked(vision, "predict", settings=[SETTINGS]) == {"gains": None, "found": []}
    asked(vision, "estimate", images=["i1"])
    foreseen = asked(vision, "predict", settings=[dark, SETTINGS | {"lights": [7, 0, 7]}])["gains"]
    assert foreseen[1]["bits"] > foreseen[0]["bits"] >= 0.0
    assert 0 <= foreseen[1]["line"] < 12
    assert asked(vision, "predict", settings=[dark, SETTINGS | {"lights": [7, 0, 7]}])["gains"] == foreseen
    with pytest.raises(ServerError, match="No image i7 in the set"):
        asked(vision, "discard", image="i7")
    searched = asked(
        vision, "predict", settings=[dark, SETTINGS | {"lights": [7, 0, 7]}], images=["i1"], search=8
    )
    found = searched["found"]
    assert searched["gains"] == foreseen
    assert len(found) == 8
    assert found[0]["bits"] == max(one["bits"] for one in found) >= foreseen[1]["bits"]
    assert all(one["settings"]["lights"][1] == 0 for one in found)  # off in all that were given
    with pytest.raises(ServerError, match="i7"):
        vision.request("predict", {"settings": [SETTINGS], "images": ["i7"]})
    with pytest.raises(ServerError, match="Expected `array` of length >= 1"):
        vision.request("predict", {"settings": []})
    with pytest.raises(ServerError, match="2 light levels"):
        vision.request("predict", {"settings": [SETTINGS | {"lights": [5, 5]}]})
    with pytest.raises(ServerError, match="in the middle of the target"):
        asked(
            vision, "check", pose={"rotation_vector": [0, 0, 0], "translation": [0, 0, 1e-300]}, images=["i1"]
        )
    asked(vision, "discard", image="i1")  # the best estimate stays, without an image
    assert asked(vision, "predict", settings=[SETTINGS]) == {"gains": None, "found": []}


def test_a_target_that_moved_is_told_with_the_image_where_something_was_foreseen(
    vision: Client, images: Running, simulator: Simulator
) -> None:
    asked(vision, "start", image_server=images.endpoint)
    told = [asked(vision, "capture", image=image, settings=SETTINGS)["surprise"] for image in ("i1", "i2")]
    assert told == [None, None]
    pixels = simulator.capture(msgspec.convert(SETTINGS, Settings)).pixels
    shifted = np.roll(pixels, (5, 6), (0, 1))

    def surprise(image: str, frame: np.ndarray) -> CauseTold | None:
        told, _ = vision.request("add", {"image": image, "settings": SETTINGS}, arrays=[frame])
        return msgspec.convert(told, VisionCaptureResult).surprise

    asked(vision, "estimate", images=["i1", "i2"])
    assert surprise("i3", shifted) is None  # nothing was foreseen
    asked(vision, "discard", image="i3")
    asked(vision, "predict", settings=[SETTINGS], images=["i1", "i2"])
    assert surprise("i4", pixels) is None
    assert surprise("i5", shifted) == CauseTold(cause="target_moved", since="i5")
    assert asked(vision, "best")["pose"] is None
    assert surprise("i6", shifted) is None  # it is where it was when i5 was taken


@pytest.mark.slow
def test_a_light_that_died_unannounced_is_named_and_nothing_is_foreseen_of_it(
    vision: Client, images: Running, simulator: Simulator
) -> None:
    asked(vision, "start", image_server=images.endpoint)
    levels = ((7, 7, 7), (0, 7, 3), (7, 0, 0), (3, 3, 7))
    taken = [SETTINGS | {"lights": list(lights), "shutter_s": 1 / 240} for lights in levels]
    for number, settings in enumerate(taken):
        told = asked(vision, "capture", image=f"i{number}", settings=settings)
        assert (told["surprise"], told["doubt"]) == (None, None)
        asked(vision, "estimate", images=[f"i{one}" for one in range(number + 1)])
        before = asked(vision, "predict", settings=[SETTINGS | {"lights": [7, 0, 0]}])["gains"][0]

    def dark_left(image: str, lights: list[int]) -> VisionCaptureResult:
        settings = SETTINGS | {"lights": lights, "shutter_s": 1 / 240}
        without = msgspec.convert(settings | {"lights": [0, *lights[1:]]}, Settings)
        frame = simulator.capture(without).pixels
        told, _ = vision.request("add", {"image": image, "settings": settings}, arrays=[frame])
        return msgspec.convert(told, VisionCaptureResult)

    answers = [dark_left("i5", [7, 1, 1]), dark_left("i6", [7, 7, 7])]
    doubts = [one.doubt for one in answers if one.doubt is not None]
    assert [(doubt.cause, doubt.lights) for doubt in doubts] in ([], [("light_dead", ("left",))])
    named = [one.surprise for one in answers if one.surprise is not None]
    assert [(one.cause, one.lights) for one in named] == [("light_dead", ("left",))]
    after = asked(vision, "predict", settings=[SETTINGS | {"lights": [7, 0, 0]}])["gains"][0]
    assert after["bits"] < before["bits"]  # it is as dark as without a light


def test_fused_images_are_one_image_to_the_estimate(vision: Client, images: Running) -> None:
    asked(vision, "start", image_server=images.endpoint)
    for image, shutter in (("i1", 1 / 240), ("i2", 1 / 60)):
        asked(vision, "capture", image=image, settings=SETTINGS | {"shutter_s": shutter})
    apart = asked(vision, "estimate", images=["i1", "i2"])
    assert asked(vision, "parameters", fusion=True)["fusion"] is True
    fused = asked(vision, "estimate", images=["i1", "i2"])
    assert {line["image"] for line in fused["lines"] if line["support"]} == {"i2"}
    assert fused["pose"] != apart["pose"]
    with pytest.raises(ServerError, match="true or false"):
        asked(vision, "parameters", fusion="yes")
    wants = [asked(vision, "appraise", image=image)["gamma"] for image in ("i1", "i2")]
    assert wants[0] < wants[1]  # the shorter exposure wants more light
    with pytest.raises(ServerError, match="i7"):
        asked(vision, "appraise", image="i7")


def test_parameters_are_checked_and_the_seed_pose_follows(vision: Client, images: Running) -> None:
    asked(vision, "start", image_server=images.endpoint)
    known = asked(vision, "parameters")
    assert {
        "matcher", "rotation_range_deg", "translation_range_px", "generations", "population",
        "edge_contrast_grey", "refinement_scale_px", "seed_pose", "tolerance_m",
        "untold_tolerance_m",
    } <= set(known)  # fmt: skip
    assert asked(vision, "parameters", generations=20, matcher="genetic")["generations"] == 20
    for bad in (
        {"generation": 3}, {"generations": 0}, {"generations": 2.5}, {"matcher": "luck"},
        {"population": True},
        {"refinement_scale_px": 3.0}, {"seed_pose": "worst"}, {"seed_pose": {"best_at_range_m": -1}},
        {"seed_pose": {"rotation_vector": [0, 0, 0], "translation": [0, 0, -1]}},
        {"seed_pose": {"rotation_vector": [0, 0, 0], "translation": [0, 0, 1e-300]}},
        {"seed_pose": {"best_at_range_m": 1e-300}},
    ):  # fmt: skip
        with pytest.raises(ServerError):
            asked(vision, "parameters", **bad)
    assert asked(vision, "parameters")["generations"] == 20
    with pytest.raises(ServerError, match="estimate"):
        asked(vision, "parameters", seed_pose="best")
    asked(vision, "capture", image="i1", settings=SETTINGS)
    seed = asked(vision, "parameters", seed_pose={"best_at_range_m": 0.5})["seed_pose"]
    assert float(np.linalg.norm(seed["translation"])) == pytest.approx(0.5)
    with pytest.raises(ServerError, match="i1"):
        asked(vision, "estimate", images=["i1"])
    asked(vision, "discard", image="i1")


def test_what_is_answered_is_what_the_types_say(vision: Client, images: Running, tmp_path: Path) -> None:
    """Results of both servers, each operation once."""
    given = {
        "start": {"image_server": images.endpoint, "out": str(tmp_path)},
        "capture": {"image": "i1", "settings": SETTINGS},
        "estimate": {"images": ["i1"]},
        "best": {},
        "predict": {"settings": [SETTINGS]},
        "appraise": {"image": "i1"},
        "parameters": {},
        "discard": {"image": "i1"},
        "restore": {"image_server": images.endpoint, "out": str(tmp_path), "images": ["i1"]},
        "health": {},
        "hello": {},
        "end": {},
    }
    for op, args in given.items():
        msgspec.convert(asked(vision, op, **args), VISION_OPERATIONS[op].result)
    pose = {"rotation_vector": [0, 0, 0], "translation": [0, 0, 1]}
    asked_of_images: dict[str, dict[str, Any]] = {
        "describe": {},
        "capture": {"settings": SETTINGS},
        "health": {},
        "hello": {},
        "score": {"pose": pose},
    }
    with Client(images.endpoint, timeout_s=60) as client:
        for op, args in asked_of_images.items():
            msgspec.convert(asked(client, op, **args), IMAGE_OPERATIONS[op].result)


def test_a_refused_capture_leaves_the_set_as_it_was(vision: Client, images: Running) -> None:
    asked(vision, "start", image_server=images.endpoint)
    with pytest.raises(ServerError):
        asked(vision, "capture", image="i1", settings={**SETTINGS, "lights": [99, 0, 0]})
    asked(vision, "capture", image="i1", settings=SETTINGS)


def test_a_frame_that_is_not_the_one_of_its_header_is_refused(vision: Client, root: Path) -> None:
    with MockImageServer() as images:
        images.description = msgspec.structs.replace(
            images.description,
            target=TargetDescription(
                model=str(root / "targets" / "cube.cao"), seed_pose=mock_physics.TRUE_POSE
            ),
        )
        vision.request("start", {"image_server": images.endpoint})
        settings = {"lights": [7, 7, 7], "shutter_s": 1 / 60, "aperture": 4.0}
        images.answer("capture", {"sha256": "0" * 64}, {"events": [{"event": "light_fault"}]}, {})
        for name, complaint in (("i1", "sha256 is not that of its header"), ("i2", "light_fault: .*`light`")):
            with pytest.raises(ServerError, match=complaint):
                vision.request("capture", {"image": name, "settings": settings})
        assert vision.request("capture", {"image": "i3", "settings": settings})[0]["image"] == "i3"
