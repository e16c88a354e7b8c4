"""Kernels on the disk are used again, and not when something they were compiled from has changed."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

CALLEE = "from numerics.kernels import kernel\n\n@kernel()\ndef tuned(x):\n    return x + {}.0\n"
BETWEEN = "from sample.callee import tuned\n"
CALLER = (
    "from numerics.kernels import kernel\n"
    "from sample.between import tuned\n\n"
    "@kernel()\ndef called(x):\n    return tuned(x)\n"
)
OTHER = CALLEE.replace("tuned", "other").format(5)
USE = "from sample.caller import called\nfrom sample.other import other\nprint(called(1.0), other(1.0))\n"
REMOVE = (
    "from pathlib import Path\nfrom numerics.stale_kernels import remove_stale_kernels\n"
    "for file in remove_stale_kernels(Path({root!r}), ('sample',)):\n    print(file.name.split('-')[0])\n"
)


@pytest.fixture
def sample(tmp_path: Path) -> Path:
    """A package whose kernel calls one of another file, by way of a third."""
    folder = tmp_path / "sample"
    folder.mkdir()
    for name, text in (
        ("callee", CALLEE.format(1)), ("between", BETWEEN), ("caller", CALLER), ("other", OTHER)
    ):  # fmt: skip
        (folder / f"{name}.py").write_text(text, encoding="utf-8")
    return folder


def run(root: Path, sample: Path, program: str, **environment: str) -> list[str]:
    """What a program prints, without bytecode: a source changed within the second would pass for the old."""
    paths = os.pathsep.join([str(root), str(sample.parent)])
    done = subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, "PYTHONPATH": paths, "PYTHONDONTWRITEBYTECODE": "1", **environment},
        capture_output=True, text=True, timeout=240, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


@pytest.mark.parametrize("elsewhere", [False, True])
def test_a_kernel_whose_callee_in_another_file_has_changed_is_compiled_anew(
    root: Path, sample: Path, tmp_path: Path, elsewhere: bool
) -> None:
    chosen = {"NUMBA_CACHE_DIR": str(tmp_path / "kept")} if elsewhere else {}
    remove = REMOVE.format(root=str(tmp_path))
    assert run(root, sample, USE, **chosen) == ["2.0", "6.0"]
    assert run(root, sample, remove, **chosen) == []
    time.sleep(0.01)
    (sample / "callee.py").write_text(CALLEE.format(2), encoding="utf-8")
    assert run(root, sample, USE, **chosen) == ["2.0", "6.0"], "numba looks at callees itself by now"
    assert set(run(root, sample, remove, **chosen)) == {"callee.tuned", "caller.called"}
    assert run(root, sample, USE, **chosen) == ["3.0", "6.0"]


def test_a_kernel_is_compiled_once(root: Path, sample: Path) -> None:
    count = "from sample.caller import called\ncalled(1.0)\nprint(sum(called.stats.cache_hits.values()))\n"
    assert run(root, sample, count) == ["0"]
    assert run(root, sample, count) == ["1"]
