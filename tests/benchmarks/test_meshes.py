"""What is counted of other people's meshes."""

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh

from benchmarks.meshes import main, off_by
from geometry.model import load_model
from geometry.pose import RIGHT, Pose
from geometry.rotation import matrix_of


def test_a_pose_is_as_far_off_as_the_part_is_and_not_its_file_s_origin(tmp_path: Path) -> None:
    trimesh.creation.box(bounds=[[0.5, 0.0, 0.0], [0.53, 0.02, 0.01]]).export(tmp_path / "part.stl")
    part = load_model(tmp_path / "part.stl")
    true = Pose(np.zeros(3), np.array([0.0, 0.0, 0.2]) - part.middle)
    turn = Pose.turn_about(np.array([0.0, 0.0, 0.2]), matrix_of(np.array([0.0, np.radians(0.9), 0.0])))
    off = off_by(part, turn.compose(true), true, first_sight=False)
    assert off.within(*RIGHT) and off.translation_m < 1e-9
    assert not turn.compose(true).error_to(true).within(*RIGHT)


@pytest.mark.slow
def test_each_mesh_is_told_and_counted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    box = trimesh.creation.box((80.0, 60.0, 30.0))
    step = trimesh.creation.box((30.0, 20.0, 20.0))
    step.apply_translation((25.0, 20.0, 25.0))
    (tmp_path / "parts").mkdir()
    trimesh.boolean.union([box, step]).export(tmp_path / "parts" / "block.stl")
    trimesh.creation.cylinder(0.2, 0.3, sections=64).export(tmp_path / "can.obj")
    (tmp_path / "none.stl").write_text("solid nothing\nendsolid nothing\n")
    (tmp_path / "readme.txt").write_text("three meshes")
    main([tmp_path])
    *rows, summary = map(json.loads, capsys.readouterr().out.splitlines())
    assert [row["mesh"] for row in rows] == ["can.obj", "none.stl", "block.stl"]
    assert "refused" in rows[1]
    assert rows[0]["right"] and rows[2]["right"]  # however the can is turned
    assert (summary["meshes"], summary["refused"], summary["right"]) == (3, 1, 2)
    assert summary["wrong_and_trusted"] == 0
