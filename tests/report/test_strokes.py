"""The wireframe that the vision server has drawn is taken where there is one, and is the same."""

from pathlib import Path

import msgspec
import numpy as np

from bridge.messages import PoseMessage
from bridge.result_file import Result, read_result
from geometry.drawn_wireframes import WIREFRAMES, wireframe_line
from geometry.pose import Pose
from geometry.wireframe import visible_runs
from report.scene import read_scene
from report.strokes import Strokes, strokes_of
from tests.report.run_folders import Bench, RunMaker


def line(bench: Bench, pose: Pose) -> bytes:
    """What is seen at the bench's pose, told of this one."""
    return wireframe_line(pose, visible_runs(bench.model, bench.camera, bench.pose))


def drawn(folder: Path, result: Result) -> Strokes | None:
    return strokes_of(read_scene(folder), result.pose, {0: 1.0})


def test_what_was_drawn_at_the_pose_is_taken_and_is_the_same(bench: Bench, make_run: RunMaker) -> None:
    folder = make_run()
    result = read_result(folder)
    here = drawn(folder, result)  # as in a folder of an earlier version
    file = folder / "images" / WIREFRAMES
    other = Pose(np.array([0.0, 0.0, 0.1]), np.array([0.0, 0.0, 1.0]))
    file.write_bytes(line(bench, other) + line(bench, bench.pose) + line(bench, other)[:40])
    found = drawn(folder, result)
    assert here is not None and found is not None
    assert (found.supported, found.unsupported) == (here.supported, here.unsupported)
    assert found.supported and found.unsupported


def test_a_pose_that_is_not_drawn_yet_is_drawn_here(bench: Bench, make_run: RunMaker) -> None:
    folder = make_run()
    pose = PoseMessage(rotation_vector=(0.0, 0.0, 0.1), translation=(0.0, 0.0, 1.0))
    moved = msgspec.structs.replace(read_result(folder), pose=pose)
    here = drawn(folder, moved)
    (folder / "images" / WIREFRAMES).write_bytes(line(bench, bench.pose))
    assert here is not None and drawn(folder, moved) == here
    assert strokes_of(read_scene(folder), moved.pose, None, at_once=True) is None
    assert drawn(folder, msgspec.structs.replace(moved, pose=None)) is None
