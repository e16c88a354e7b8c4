"""What is known of light after an image that was not as foreseen, and of a model by several."""

import math
from typing import Any

import numpy as np
import pytest

from bridge.client import Client
from bridge.errors import BadInput
from bridge.messages import Settings
from bridge.start_messages import CauseTold, StartArgs
from geometry.pose import Pose
from image_server.simulator.simulator import Simulator
from tests.vision_server.serve.running import SETTINGS, Running, asked
from vision_server.matching.match import Anywhere
from vision_server.prediction.causes import Cause
from vision_server.prediction.response import LitImage
from vision_server.serve import surprises
from vision_server.serve.opening import open_task
from vision_server.serve.prediction import outputs
from vision_server.serve.surprises import images_of_scene, restore
from vision_server.serve.task import REMEMBERED, Happened, PoseTask
from vision_server.trust import judgement
from vision_server.trust.probability import Misfit

FULL = Settings(lights=(7, 7, 7), shutter_s=1 / 60, aperture=4.0)


@pytest.fixture
def task(simulator: Simulator) -> PoseTask:
    """Four images of the cube's simulator."""
    opened = open_task(StartArgs(), simulator.describe())
    for image in ("i1", "i2", "i3", "i4"):
        opened.add(image, simulator.capture(FULL).pixels, FULL)
    return opened


def lit(task: PoseTask, image: str | None) -> list[bool]:
    return np.greater(outputs(task, FULL, image), 0.0).tolist()


def test_a_dead_light_is_dead_from_its_image_on_also_when_that_goes(task: PoseTask) -> None:
    task.learn(Happened("light_dead", (0,), frozenset({"i1", "i2"})))
    task.discard("i3")
    assert [lit(task, image)[0] for image in ("i1", "i2", "i4", None)] == [True, True, False, False]
    task.discard("i4")
    assert [lit(task, image)[0] for image in ("i1", "i2", None)] == [True, True, False]
    task.add("i5", np.zeros((task.camera.height, task.camera.width), np.uint8), FULL)
    assert [lit(task, image)[0] for image in ("i2", "i5")] == [True, False]


@pytest.mark.parametrize("cause", ["sun_changed", "in_the_way"])
def test_images_of_another_sun_or_without_an_arm_are_no_evidence_when_the_first_with_it_goes(
    task: PoseTask, cause: str
) -> None:
    task.learn(Happened(cause, (), frozenset({"i1", "i2"})))
    assert images_of_scene(task) == ["i3", "i4"]
    task.discard("i3")
    assert images_of_scene(task) == ["i4"]


@pytest.mark.parametrize("event", ["target_moved", "sun_changed"])
def test_an_image_is_not_held_against_those_from_before_what_was_published_with_it(
    task: PoseTask, simulator: Simulator, event: str
) -> None:
    """Another one under the settings of four others would be a surprise."""
    pixels = simulator.capture(Settings(lights=(0, 0, 7), shutter_s=1 / 60, aperture=4.0)).pixels
    task.add("i5", pixels, FULL)
    assert surprises.surprise_of(task, "i5") != (None, None)
    task.doubted = None
    task.add("i6", pixels, FULL)
    task.hear([event], "i6")
    assert images_of_scene(task) == ["i6"]
    assert surprises.surprise_of(task, "i6") == (None, None)


def test_discarded_images_are_remembered_once_something_was_foreseen(task: PoseTask) -> None:
    task.discard("i1")
    assert images_of_scene(task) == ["i2", "i3", "i4"]
    task.expect(None)
    task.discard("i3")
    assert images_of_scene(task) == ["i2", "i3", "i4"]
    assert list(task.images.images) == ["i2", "i4"]
    for number in range(5, 6 + REMEMBERED):
        task.add(f"i{number}", np.zeros((task.camera.height, task.camera.width), np.uint8), FULL)
        task.discard(f"i{number}")
    assert images_of_scene(task) == ["i2", "i4", *(f"i{number}" for number in range(6, 6 + REMEMBERED))]
    assert set(task.lit) == set(images_of_scene(task)) - {"i2", "i4"}


def test_a_light_that_died_is_named_by_test_images_that_were_discarded(
    task: PoseTask, simulator: Simulator
) -> None:
    without = Settings(lights=(0, 7, 7), shutter_s=1 / 60, aperture=4.0)
    alone = Settings(lights=(7, 0, 0), shutter_s=1 / 60, aperture=4.0)
    dark = Settings(lights=(0, 0, 0), shutter_s=1 / 60, aperture=4.0)
    said = []
    for name, asked_for, given in (("i5", FULL, without), ("i6", without, without), ("i7", alone, dark)):
        task.foresees, task.expected = True, simulator.true_pose
        task.add(name, simulator.capture(given).pixels, asked_for)
        said.append(surprises.surprise_of(task, name).cause)
        task.discard(name)
    name = task.describe.lights[0].name
    assert CauseTold(cause="light_dead", lights=(name,), since="i5") in said


def test_what_flickers_is_held_against_the_others_as_bright_as_the_image_that_it_repeats(
    task: PoseTask, simulator: Simulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    read: list[list[LitImage]] = []

    def reads(*given: Any) -> tuple[None, None]:
        read.append(given[-1])
        return None, None

    monkeypatch.setattr(surprises, "read", reads)
    monkeypatch.setattr(surprises, "likely_causes", lambda *_: [])
    monkeypatch.setattr(surprises, "target_moved", lambda *_: False)
    steady = simulator.capture(FULL).pixels
    task.add("i5", np.rint(0.9 * np.minimum(steady, 250.0)).astype(np.uint8), FULL)
    task.expected = simulator.true_pose
    assert surprises.surprise_of(task, "i5") == (None, None)
    (images,) = read
    assert images[-1].exposure / images[0].exposure == pytest.approx(0.9, abs=0.01)
    assert [one.exposure for one in images[:-1]] == [images[0].exposure] * 4


def test_what_was_doubted_first_is_not_forgotten_for_a_later_doubt(
    task: PoseTask, monkeypatch: pytest.MonkeyPatch
) -> None:
    doubts = iter([Cause("light_dead", (0,), 1, 9.0), Cause("sun_changed", (), 3, 9.0), None])
    monkeypatch.setattr(surprises, "verdict", lambda _: (None, next(doubts)))
    monkeypatch.setattr(surprises, "causes", lambda *_: [])
    monkeypatch.setattr(surprises, "target_moved", lambda *_: False)
    task.expected = Pose(np.zeros(3), np.array([0.0, 0.0, 1.0]))
    told = [surprises.surprise_of(task, "i4").doubt for _ in range(3)]
    assert [doubt and (doubt.cause, doubt.since) for doubt in told] == [
        ("light_dead", "i2"),
        ("sun_changed", "i2"),
        None,
    ]
    assert task.doubted is None


def test_something_in_the_way_is_sure_where_an_image_from_before_the_doubt_is_repeated(
    task: PoseTask, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(surprises, "verdict", lambda _: (None, None))
    monkeypatch.setattr(surprises, "causes", lambda *_: [])
    monkeypatch.setattr(surprises, "target_moved", lambda *_: False)
    behind = np.array(task.images.images["i1"].pixels)
    behind[:, behind.shape[1] // 2 - 30 : behind.shape[1] // 2 + 30] = 40
    task.add("i5", behind, FULL)
    other = Settings(lights=(7, 7, 0), shutter_s=1 / 60, aperture=4.0)
    for since, settings, told in (("i3", other, None), ("i3", FULL, "i3")):
        task.expected = Pose(np.zeros(3), np.array([0.0, 0.0, 1.0]))
        task.doubted, task.applied["i5"] = since, settings
        cause = surprises.surprise_of(task, "i5").cause
        assert (cause and cause.cause, cause and cause.since) == (told and "in_the_way", told)


@pytest.mark.parametrize("given", ["a seed pose", "nothing"])
def test_pictures_of_the_same_settings_tell_without_a_forecast(
    simulator: Simulator, task: PoseTask, given: str
) -> None:
    if given == "nothing":
        task.seed_pose = Anywhere()
    behind = np.array(task.images.images["i1"].pixels)
    behind[:, behind.shape[1] // 2 - 30 : behind.shape[1] // 2 + 30] = 40
    dark = simulator.capture(Settings(lights=(0, 7, 7), shutter_s=1 / 60, aperture=4.0)).pixels
    said = []
    for name, pixels in (("same", simulator.capture(FULL).pixels), ("relit", dark)):
        task.add(name, pixels, FULL)
        assert task.to_be_judged(name)
        said.append(surprises.surprise_of(task, name))
    assert said[0] == (None, None)
    assert said[1].doubt is not None and said[1].doubt.since == "relit"
    task.discard("relit")
    task.doubted = None
    task.add("arm", behind, FULL)
    assert surprises.surprise_of(task, "arm").cause == CauseTold(cause="in_the_way", since="arm")


def test_an_image_of_other_settings_without_a_forecast_tells_nothing(task: PoseTask) -> None:
    other = Settings(lights=(7, 7, 0), shutter_s=1 / 60, aperture=4.0)
    task.add("i5", np.zeros((task.camera.height, task.camera.width), np.uint8), other)
    assert not task.to_be_judged("i5")
    assert task.to_be_judged("i4")


def test_where_an_image_repeats_one_in_other_light_the_light_has_changed_and_nothing_is_in_the_way(
    task: PoseTask, simulator: Simulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    weighed = [Cause("in_the_way", (), 3, 50.0, True), Cause("sun_changed", (), 3, 5.0, True)]
    monkeypatch.setattr(surprises, "likely_causes", lambda *_: weighed)
    monkeypatch.setattr(surprises, "target_moved", lambda *_: False)
    dark = Settings(lights=(1, 1, 1), shutter_s=1 / 60, aperture=4.0)
    for name, given, cause in (("i5", FULL, "in_the_way"), ("i6", dark, "sun_changed")):
        task.add(name, simulator.capture(given).pixels, FULL)
        task.expected, task.doubted = simulator.true_pose, "i4"
        told = surprises.surprise_of(task, name).cause
        assert told is not None
        assert told.cause == cause
        task.happened.clear()


@pytest.mark.parametrize("weighed", [[], [Cause("light_dead", (1,), 4, -3.0)]])
def test_an_image_in_other_light_is_doubted_however_little_can_be_weighed(
    task: PoseTask, simulator: Simulator, monkeypatch: pytest.MonkeyPatch, weighed: list[Cause]
) -> None:
    monkeypatch.setattr(surprises, "causes", lambda *_: weighed)
    monkeypatch.setattr(surprises, "target_moved", lambda *_: False)
    dark = Settings(lights=(7, 0, 7), shutter_s=1 / 60, aperture=4.0)
    task.add("i5", simulator.capture(dark).pixels, FULL)
    task.expected = simulator.true_pose
    told = surprises.surprise_of(task, "i5")
    assert told.cause is None
    assert told.doubt is not None
    assert told.doubt.cause == (weighed[0].name if weighed else "sun_changed")


def test_new_edges_are_a_doubt_of_what_is_in_the_way_until_something_is_doubted(
    task: PoseTask, simulator: Simulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(surprises, "verdict", lambda _: (None, None))
    monkeypatch.setattr(surprises, "target_moved", lambda *_: False)
    pose = simulator.true_pose
    other, third = (Settings(lights=lit, shutter_s=1 / 60, aperture=4.0) for lit in ((7, 7, 0), (0, 7, 7)))
    behind = np.array(simulator.capture(third).pixels)
    behind[:, behind.shape[1] // 2 - 30 : behind.shape[1] // 2 + 30] = 40
    told = []
    for name, settings, pixels in (
        ("i5", other, simulator.capture(other).pixels),
        ("i6", third, behind),
        ("i7", third, behind),
    ):
        task.expected = pose
        task.add(name, pixels, settings)
        doubt = surprises.surprise_of(task, name).doubt
        told.append(doubt and (doubt.cause, doubt.since))
    assert told == [None, ("in_the_way", "i6"), None]


def test_what_another_task_has_named_is_known(task: PoseTask) -> None:
    lights = [light.name for light in task.describe.lights]
    kept = ("i1", "i2", "i3", "i4")
    restore(task, CauseTold(cause="lights_swapped", lights=(lights[0], lights[2]), since="i2"), kept)
    task.add("i5", np.zeros((task.camera.height, task.camera.width), np.uint8), FULL)
    one = Settings(lights=(7, 0, 0), shutter_s=1 / 60, aperture=4.0)
    assert np.greater(outputs(task, one, "i1"), 0.0).tolist() == [True, False, False]
    assert np.greater(outputs(task, one, "i5"), 0.0).tolist() == [False, False, True]
    with pytest.raises(BadInput, match="no light torch"):
        restore(task, CauseTold(cause="light_dead", lights=("torch",)), kept)
    with pytest.raises(BadInput, match="since i9"):
        restore(task, CauseTold(cause="sun_changed", since="i9"), kept)


def test_what_is_told_before_the_images_come_back_is_of_the_next_one(simulator: Simulator) -> None:
    task = open_task(StartArgs(), simulator.describe())
    lights = [light.name for light in task.describe.lights]
    restore(task, CauseTold(cause="light_dead", lights=(lights[0],)), ("i1", "i2"))
    for image in ("i1", "i2", "i3"):
        task.add(image, simulator.capture(FULL).pixels, FULL)
    assert [lit(task, image)[0] for image in ("i1", "i2", "i3", None)] == [True, True, False, False]


def test_a_model_is_judged_by_two_images_and_more(
    vision: Client, images: Running, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(judgement, "misfit", lambda _: Misfit(20.0, 0.0, (-0.02, 0.01, 0.01, 0.0, 0.0, 0.0)))
    asked(vision, "start", image_server=images.endpoint)
    for image in ("i1", "i2"):
        asked(vision, "capture", image=image, settings=SETTINGS)
    assert asked(vision, "estimate", images=["i1"])["model_wrong"] is None
    told = asked(vision, "estimate", images=["i1", "i2"])["model_wrong"]
    assert told == {"axis": "x", "share": pytest.approx(math.expm1(0.03))}
