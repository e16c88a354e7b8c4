"""Linear algebra on one thread."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from numerics.blas import VARIABLES

THREADS = """
import os
from numerics.blas import use_one_blas_thread
use_one_blas_thread()
import numpy as np
np.linalg.eigh(np.ones((300, 300)))
print(len(os.listdir("/proc/self/task")))
"""
IN_TIME = "import sys, {module}.__main__; print('numpy' in sys.modules)"


def _output(code: str, root: Path) -> subprocess.CompletedProcess[str]:
    environment = {name: value for name, value in os.environ.items() if name not in VARIABLES}
    return subprocess.run(
        [sys.executable, "-c", code],
        cwd=root, env=environment, capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="not Linux")
def test_linear_algebra_starts_no_threads(root: Path) -> None:
    done = _output(THREADS, root)
    assert done.stdout == "1\n", done.stderr


@pytest.mark.parametrize("module", ["vision_server", "experiments"])
def test_commands_say_it_before_numpy_is_loaded(root: Path, module: str) -> None:
    assert _output(IN_TIME.format(module=module), root).stdout == "False\n"


def test_benchmarks_measure_as_the_servers_work(root: Path) -> None:
    alone = "import os, sys, benchmarks; print(os.environ['OPENBLAS_NUM_THREADS'], 'numpy' in sys.modules)"
    assert _output(alone, root).stdout == "1 False\n"
