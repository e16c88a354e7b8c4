"""A session's task without a seed pose: what narrows the search, what is in view, and what is told of it."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from bridge.errors import BadInput
from bridge.messages import Describe, PoseMessage, Settings, TargetDescription
from bridge.start_messages import StartArgs
from geometry.model import find_target
from geometry.pose import Pose
from stack.tables import read_toml
from vision_server.matching.match import Anywhere
from vision_server.serve.opening import GIVEN_FRAMES, given_values, open_task
from vision_server.serve.task import PoseTask
from vision_server.trust.judgement import Estimate

CAMERA = "[camera]\nwidth = 64\nheight = 48\nfx = 80.0\nfy = 80.0\ncx = 31.5\ncy = 23.5\n"
SEED = PoseMessage(rotation_vector=(0.0, 0.0, 0.0), translation=(0.0, 0.0, 1.0))
AHEAD = Pose(np.zeros(3), np.array([0.0, 0.0, 3.0]))


def opened(tmp_path: Path, told: str = "", **target: object) -> PoseTask:
    file = tmp_path / "camera.toml"
    file.write_text(CAMERA + told)
    known = TargetDescription(model=str(find_target("cube")), **target)  # type: ignore[arg-type]
    describe: Describe = msgspec.structs.replace(GIVEN_FRAMES, target=known)
    return open_task(StartArgs(camera_file=str(file)), describe)


def test_what_is_known_narrows_the_search(tmp_path: Path) -> None:
    assert opened(tmp_path).seed_pose == Anywhere()
    described = opened(tmp_path, range_m=(0.5, 2.0), view=(0.0, 0.0, 1.0))
    assert described.seed_pose == described.anywhere == Anywhere((0.5, 2.0), (0.0, 0.0, 1.0))
    assert opened(tmp_path, "[target]\nrange_m = [1, 3]", range_m=(0.5, 2.0)).seed_pose == Anywhere(
        (1.0, 3.0)
    )
    assert isinstance(opened(tmp_path, seed_pose=SEED).seed_pose, Pose)
    with pytest.raises(BadInput, match="range_m"):
        opened(tmp_path, range_m=(2.0, 0.5))
    for file in ("[target]\nrange_m = [400, 800]", ""):  # millimetres
        with pytest.raises(BadInput, match=r"range_m = \[400, 800\]: the model is .* and would be 0\.\d+ to"):
            opened(tmp_path, file, range_m=(400.0, 800.0))


def test_a_camera_file_is_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    read: list[Path] = []

    def seen(path: Path, what: str) -> object:
        read.append(path)
        return read_toml(path, what)

    monkeypatch.setattr("vision_server.serve.inputs.read_toml", seen)
    task = opened(tmp_path, "[target]\nrange_m = [1, 3]\ntolerance_m = 1e-4")
    assert (task.anywhere, task.settings.tolerance_m) == (Anywhere((1.0, 3.0)), 1e-4)
    assert read == [tmp_path / "camera.toml"]


def test_what_lines_of_the_part_may_be_off_is_told_by_a_file_or_the_description(tmp_path: Path) -> None:
    untold = opened(tmp_path)
    assert untold.settings.tolerance_m == 0.0
    assert untold.settings.untold_tolerance_m == pytest.approx(0.0005 * untold.model.diameter)
    for told in (0.0, 1e-4):
        settings = opened(tmp_path, tolerance_m=told).settings
        assert (settings.tolerance_m, settings.untold_tolerance_m) == (told, 0.0)
    asked = untold.set_parameters({"tolerance_m": 1e-4})
    assert (asked["tolerance_m"], asked["untold_tolerance_m"]) == (1e-4, 0.0)
    file = "[target]\ntolerance_m = 2e-4"
    assert opened(tmp_path, file, tolerance_m=1e-4).settings.tolerance_m == 2e-4
    for bad in ("-1e-4", "1.0", "nan", "true", "'1 mm'"):
        with pytest.raises(BadInput, match=r"tolerance_m .* number"):
            opened(tmp_path, f"[target]\ntolerance_m = {bad}")
    with pytest.raises(BadInput, match="image server's target"):
        opened(tmp_path, tolerance_m=1.0)  # a part that is as far off as it is large
    task = opened(tmp_path, tolerance_m=1e-4)
    assert task.set_parameters({})["tolerance_m"] == 1e-4
    with pytest.raises(BadInput, match="tolerance_m"):
        task.set_parameters({"tolerance_m": 1.0})
    assert task.settings.tolerance_m == 1e-4


def test_how_round_edges_are_is_told_by_the_camera_s_file(tmp_path: Path) -> None:
    assert opened(tmp_path).edge_radius_m is None
    assert opened(tmp_path, "[target]\nedge_radius_m = 2e-3").edge_radius_m == 2e-3
    for bad in ("-1e-4", "10.0", "nan", "true", "'1 mm'"):
        with pytest.raises(BadInput, match=r"edge_radius_m .* number"):
            opened(tmp_path, f"[target]\nedge_radius_m = {bad}")


def test_a_tolerance_goes_with_the_recorded_folder(tmp_path: Path) -> None:
    known = TargetDescription(model=str(find_target("cube")), seed_pose=SEED, tolerance_m=1e-4)
    (tmp_path / "camera.toml").write_text(CAMERA)
    described = msgspec.structs.replace(GIVEN_FRAMES, target=known)
    camera, out = str(tmp_path / "camera.toml"), str(tmp_path / "out")
    task = open_task(StartArgs(camera_file=camera, seed_pose=SEED, out=out), given_values(
        StartArgs(seed_pose=SEED), described))  # fmt: skip
    task.add("i1", np.zeros((48, 64), np.uint8), Settings(lights=(), shutter_s=1 / 60, aperture=4.0))
    assert task.recorder is not None
    task.recorder.close()
    assert "tolerance_m = 0.0001" in (tmp_path / "out" / "images" / "stack.toml").read_text()


def test_what_the_images_show_counts_until_there_is_a_pose(tmp_path: Path) -> None:
    task = opened(tmp_path)
    pixels = np.zeros((48, 64), np.uint8)
    pixels[:3, :3] = 255  # far from where the target will be
    applied = Settings(lights=(), shutter_s=1 / 60, aperture=4.0)
    shown = task.add("i1", pixels, applied)
    assert shown["saturated_fraction"] > shown["frame"]["saturated_fraction"] > 0
    task.note(Estimate(pose=AHEAD, score=0.3))
    assert task.add("i2", pixels, applied)["saturated_fraction"] > 0  # a pose that is rather wrong
    task.note(Estimate(pose=AHEAD, score=0.9))
    assert task.add("i3", pixels, applied)["saturated_fraction"] == 0


def test_the_parameter_says_anywhere_and_takes_it(tmp_path: Path) -> None:
    task = opened(tmp_path, range_m=(0.5, 2.0))
    told = task.set_parameters({})
    assert told["seed_pose"] == "anywhere"
    task.set_parameters({"seed_pose": AHEAD.to_dict()})
    assert isinstance(task.seed_pose, Pose)
    task.set_parameters(told)
    assert task.seed_pose == Anywhere((0.5, 2.0))
    task.set_parameters({"seed_pose": {"best_at_range_m": 1.0}})  # an approach that has no pose yet
    assert task.seed_pose == Anywhere((0.5, 2.0))


def test_first_sight_passes_over_the_seed_pose_that_is_known() -> None:
    known = TargetDescription(model=str(find_target("cube")), seed_pose=SEED)
    describe = msgspec.structs.replace(GIVEN_FRAMES, target=known)
    shown = given_values(StartArgs(first_sight=True), describe).target
    assert shown is not None
    assert shown.seed_pose is None
    with pytest.raises(BadInput, match="first_sight"):
        given_values(StartArgs(first_sight=True, seed_pose=SEED), describe)


def test_the_genetic_matcher_says_that_it_needs_one(tmp_path: Path) -> None:
    task = opened(tmp_path)
    task.set_parameters({"matcher": "genetic"})
    task.add("i1", np.zeros((48, 64), np.uint8), Settings(lights=(), shutter_s=1 / 60, aperture=4.0))
    with pytest.raises(BadInput, match="seed pose"):
        task.estimate(["i1"])


def test_who_gave_a_seed_pose_that_cannot_be_is_told(tmp_path: Path) -> None:
    behind = PoseMessage(rotation_vector=(0.0, 0.0, 0.0), translation=(0.0, 0.0, 0.0))
    with pytest.raises(BadInput, match="The image server's seed pose: the target is behind"):
        opened(tmp_path, seed_pose=behind)
    args = StartArgs(
        camera_file=str(tmp_path / "camera.toml"), model=str(find_target("cube")), seed_pose=behind
    )
    with pytest.raises(BadInput, match="Argument seed_pose: the target is behind"):
        open_task(args, given_values(args, GIVEN_FRAMES))
