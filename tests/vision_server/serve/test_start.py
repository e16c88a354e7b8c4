"""What a session waits for: the servers load no more than they need."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest


def run(root: Path, program: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=root, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    "modules",
    [
        "vision_server.__main__, vision_server.commands.estimate, vision_server.commands.edges",
        "vision_server.commands.serve",
        "image_server.replay, image_server.serve.server, geometry.pose",
    ],
)
def test_what_has_no_kernel_does_without_numba(root: Path, modules: str) -> None:
    run(root, f"import sys, {modules}\nassert 'numba' not in sys.modules")


def test_kernels_are_ready_without_scipy_which_is_there_afterwards(root: Path) -> None:
    run(
        root,
        "import sys\n"
        "import numpy as np\n"
        "from numerics.kernels import prepare_kernels\n"
        "from vision_server.channels.noise import grey_noise\n"
        "prepare_kernels()\n"
        "assert np.isfinite(grey_noise(np.zeros((9, 9), np.uint8))).all()\n"
        "assert 'scipy.linalg' not in sys.modules\n"
        "import scipy.linalg.cython_blas\n",
    )


ESTIMATE = """
import sys
from pathlib import Path

import numpy as np
from numerics.kernels import prepare_kernels, use_library

use_library({library!r})
from geometry.camera import Camera
from geometry.model import TARGETS, load_model
from geometry.pose import Pose
from tests.vision_server.synthetic import CAMERA, POSE, cuboid, linear_picture, photographed
from vision_server.commands.warm import drawn
from vision_server.image_set import ImageSet
from vision_server.pipeline import PipelineSettings, estimate_pose

prepare_kernels()
model = load_model(TARGETS / "fixture.cao")
camera = Camera(400, 300, 500.0, 500.0, 199.5, 149.5)
pose = Pose(np.array([0.4, 0.6, 0.2]), np.array([0.0, 0.0, 3.0 * model.diameter]))
images = ImageSet(camera.width, camera.height)
images.add("i1", drawn(model, camera, pose, 0.8), 1.0, 1.0)
images.add("i2", drawn(model, camera, pose, 2.5), 2.0, 1.0)
near = Pose(pose.rotation_vector + 0.1, pose.translation * 1.02)
for names in (["i1"], ["i2"], ["i1", "i2"]):
    found = estimate_pose(images, names, model, camera, near, PipelineSettings())
    print(found.rms_px, found.score, found.pose and found.pose.to_dict(), found.covariance)
plain = cuboid(Path({folder!r}))
images = ImageSet(CAMERA.width, CAMERA.height)
images.add("i1", photographed(linear_picture(plain, CAMERA, POSE), noise_sd_grey=4.0), 1.0, 1.0)
found = estimate_pose(images, ["i1"], plain, CAMERA, POSE, PipelineSettings())
print(found.pose and found.pose.to_dict(), found.covariance)
print(*sorted({{"numba", "scipy.linalg"}} & set(sys.modules)), file=sys.stderr)
"""


def test_an_estimate_with_the_library_of_kernels_is_numbas_bit_for_bit(root: Path, tmp_path: Path) -> None:
    done = [
        subprocess.run(
            [sys.executable, "-c", ESTIMATE.format(library=library, folder=str(tmp_path))],
            cwd=root, capture_output=True, text=True, timeout=240, check=True,
        )
        for library in ("vision_server", "none")
    ]  # fmt: skip
    assert done[0].stderr.strip() == "", (
        "run make setup: no library, or it lacks some; or a kernel needs BLAS"
    )
    assert "numba" in done[1].stderr
    assert done[0].stdout == done[1].stdout
    assert done[0].stdout.count("rotation_vector") >= 2, done[0].stdout
