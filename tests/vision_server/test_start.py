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
        "image_server.replay, image_server.server, geometry.pose",
    ],
)
def test_what_has_no_kernel_does_without_numba(root: Path, modules: str) -> None:
    run(root, f"import sys, {modules}\nassert 'numba' not in sys.modules")


def test_kernels_are_ready_without_scipy_which_is_there_afterwards(root: Path) -> None:
    run(
        root,
        "import sys\n"
        "import numpy as np\n"
        "from geometry.kernels import prepare_kernels\n"
        "from vision_server.noise import grey_noise\n"
        "prepare_kernels()\n"
        "assert np.isfinite(grey_noise(np.zeros((9, 9), np.uint8))).all()\n"
        "assert 'scipy.linalg' not in sys.modules\n"
        "import scipy.linalg.cython_blas\n",
    )
