"""Stacks of scenes by POV-Ray: they load, and they show the target where the file says it is."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks import povray, ray_traced_stacks
from benchmarks.machined_parts import ROUND, surface_of
from benchmarks.patches import of_faces, patches
from geometry.model import Model, find_target, load_model
from geometry.pose import Pose
from stack.read import BasisStack, load_stack


def test_a_curved_face_is_one_patch_and_flat_ones_are_their_own() -> None:
    cube = load_model(find_target("cube"))
    assert (patches(cube) == cube.triangle_face).all()
    assert (of_faces(cube) == np.arange(6)).all()
    cylinder = Model.of_surface("cylinder", surface_of(ROUND["cylinder"](48)))
    assert patches(cylinder).max() == 2
    assert len(set(of_faces(cylinder).tolist())) == 3


@pytest.mark.slow
@pytest.mark.skipif(not povray.available(), reason="POV-Ray (Debian package povray) is not installed")
def test_the_target_is_lit_where_its_pose_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ray_traced_stacks, "SAMPLES", 1)
    file = find_target("fixture")
    ray_traced_stacks.drawn_stack(file, 1, 5, tmp_path)
    stack = load_stack(tmp_path)
    assert isinstance(stack, BasisStack)
    target = stack.table.target
    assert target.true_pose is not None
    assert target.seed_pose is not None
    pose = Pose.of(target.true_pose)
    model = load_model(file)
    pixels = ray_traced_stacks.CAMERA.project(pose.apply(model.vertices))
    covered = np.zeros((480, 640), np.uint8)
    for triangle in model.triangles:
        cv2.fillConvexPoly(covered, np.rint(pixels[triangle]).astype(np.int32), 1)
    lit = np.max(stack.radiances, axis=0) > 0.004
    around = cv2.dilate(covered, np.ones((5, 5), np.uint8)) == 1
    assert not lit[~around].any()
    assert lit[covered == 1].mean() > 0.9
    assert not np.allclose(target.seed_pose.translation, target.true_pose.translation)
