"""The wireframe that the vision server has drawn is taken where there is one, and is the same."""

from pathlib import Path

import msgspec

from geometry.wireframe import visible_runs
from report.records import PoseRecord, Result, read_result
from report.scene import read_scene
from report.strokes import Strokes, drawn_strokes, strokes_of
from tests.report.run_folders import Bench, RunMaker


def line(bench: Bench, pose: dict[str, list[float]]) -> bytes:
    """One of images/wireframes.jsonl."""
    runs = visible_runs(bench.model, bench.camera, bench.pose)
    told = [{"line": run.line, "points": run.points.round(2).tolist()} for run in runs]
    return msgspec.json.encode({"pose": pose, "runs": told}) + b"\n"


def drawn(folder: Path, result: Result) -> Strokes | None:
    return drawn_strokes(folder, read_scene(folder), result.pose, {0: 1.0})


def test_what_was_drawn_at_the_pose_is_taken_and_is_the_same(bench: Bench, make_run: RunMaker) -> None:
    folder = make_run()
    result = read_result(folder)
    here = strokes_of(read_scene(folder), result.pose, {0: 1.0})
    assert drawn(folder, result) == here  # a folder of an earlier version
    file = folder / "images" / "wireframes.jsonl"
    other = {"rotation_vector": [0.0, 0.0, 0.1], "translation": [0.0, 0.0, 1.0]}
    file.write_bytes(line(bench, other) + line(bench, bench.pose.to_dict()) + line(bench, other)[:40])
    found = drawn(folder, result)
    assert here is not None and found is not None
    assert (found.supported, found.unsupported) == (here.supported, here.unsupported)
    assert found.supported and found.unsupported


def test_a_pose_that_is_not_drawn_yet_has_no_strokes(bench: Bench, make_run: RunMaker) -> None:
    folder = make_run()
    (folder / "images" / "wireframes.jsonl").write_bytes(line(bench, bench.pose.to_dict()))
    moved = msgspec.structs.replace(read_result(folder), pose=PoseRecord([0.0, 0.0, 0.1], [0.0, 0.0, 1.0]))
    assert drawn(folder, moved) is None
    assert drawn(folder, msgspec.structs.replace(moved, pose=None)) is None
