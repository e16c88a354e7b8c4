"""What a session waits for: the servers load no more than they need, and compile nothing."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow


def run(root: Path, program: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=root, capture_output=True, text=True, timeout=240, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize(
    "modules",
    [
        "vision_server.__main__, vision_server.commands.estimate, vision_server.commands.edges",
        "vision_server.commands.serve",
        "image_server.__main__, image_server.replay, image_server.serve.server, geometry.pose",
    ],
)
def test_what_has_no_kernel_does_without_numba(root: Path, modules: str) -> None:
    run(root, f"import sys, {modules}\nassert 'numba' not in sys.modules")


ESTIMATE = """
import sys
from pathlib import Path

import numpy as np
from numba.core import event

from benchmarks.drawn_parts import part_file
from geometry.camera import Camera
from geometry.model import TARGETS, load_model
from geometry.pose import Pose
from tests.vision_server.synthetic import CAMERA, POSE, cuboid, linear_picture, photographed
from vision_server.commands.warm import drawn
from vision_server.image_set import ImageSet
from vision_server.pipeline import PipelineSettings, estimate_pose
from vision_server.trust.other_hand import other_ways

model = load_model(TARGETS / "fixture.cao")
camera = Camera(400, 300, 500.0, 500.0, 199.5, 149.5)
pose = Pose(np.array([0.4, 0.6, 0.2]), np.array([0.0, 0.0, 3.0 * model.diameter]))
with event.install_recorder("numba:compile") as compiled:
    images = ImageSet(camera.width, camera.height)
    images.add("i1", drawn(model, camera, pose, 0.8), 1.0, 1.0)
    images.add("i2", drawn(model, camera, pose, 2.5), 2.0, 1.0)
    bright = 2 * drawn(model, camera, pose, 0.8).astype(int)
    images.add("clipped", np.minimum(bright, 255).astype(np.uint8), 2.0, 1.0)
    near = Pose(pose.rotation_vector + 0.1, pose.translation * 1.02)
    for names in (["i1"], ["i2"], ["i1", "i2"], ["i1", "clipped"]):
        found = estimate_pose(images, names, model, camera, near, PipelineSettings())
        print(found.pose and found.pose.to_dict())
    assert other_ways(load_model(TARGETS / "cube.cao")) == (), "asked where some of its lines are missing"
    plain = cuboid(Path({folder!r}))
    images = ImageSet(CAMERA.width, CAMERA.height)
    images.add("i1", photographed(linear_picture(plain, CAMERA, POSE), noise_sd_grey=4.0), 1.0, 1.0)
    found = estimate_pose(images, ["i1"], plain, CAMERA, POSE, PipelineSettings())
    print(found.pose and found.pose.to_dict())
    wheel = load_model(part_file("wheel", Path({folder!r}), np.random.default_rng((4102, 4))))
    behind = Pose(np.array([-0.5, 0.0, 0.0]), np.array([0.0, 0.0, 3.0 * wheel.diameter]))
    images = ImageSet(camera.width, camera.height)
    images.add("i1", drawn(wheel, camera, behind, 0.8), 1.0, 1.0)
    found = estimate_pose(images, ["i1"], wheel, camera, behind, PipelineSettings())
    assert max(rival.share for rival in found.rivals) > 0.04, "none of its turns was weighed"
    print([module for module in ("scipy.linalg", "scipy.spatial") if module in sys.modules])
for _, what in compiled.buffer:
    if what.is_start:
        print("compiled:", what.data["dispatcher"].py_func, what.data["args"])
"""


def test_an_estimate_finds_every_kernel_that_it_calls_compiled(root: Path, tmp_path: Path) -> None:
    said = run(root, ESTIMATE.format(folder=str(tmp_path)))
    assert said.count("rotation_vector") >= 2, said
    assert "[]" in said, f"SciPy's parts take a tenth of a start: {said}"
    assert "compiled:" not in said, f"run make setup, or have `warm` call what it does not: {said}"
