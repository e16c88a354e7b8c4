"""Kernels from a library do what numba does, and without numba."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

KERNELS = """
from typing import NamedTuple

import numpy as np
from numerics.kernels import kernel


class Line(NamedTuple):
    slope: np.ndarray
    height: float


@kernel(inline="always")
def square(x):
    return x * x


@kernel(error_model="numpy")
def inverse(x):
    return 1.0 / x


@kernel(nogil=True)
def values(line, points, doubled):
    out = np.empty(len(points))
    for i in range(len(points)):
        out[i] = inverse(square(line.slope[0] * points[i] + line.height)) * (2 if doubled else 1)
    return out, len(points)


@kernel()
def second(points):
    return points[1]


@kernel(nogil=True)
def is_told(flag, seen, limit):
    for i in range(limit):
        seen[i & 7] = i  # might be the flag, for all a compiler knows: it is looked at each time
        if flag[0] != 0:
            return True
    return False


def exercise():
    is_told(np.ones(1, np.int64), np.zeros(8, np.int64), 1)
    line = Line(np.array([2.0]), -2.0)
    values(line, np.arange(3.0), True)
    second(np.arange(8.0)[::2])
    second(np.arange(4.0))
"""

BUILD = """
from numerics.kernel_library import build_library

def exercise():
    import sample
    sample.exercise()

build_library("sample", exercise)
"""

USE = """
import sys
import numpy as np
from numerics.kernels import prepare_kernels, use_library

use_library("sample")
import sample

prepare_kernels()
"""


@pytest.fixture(scope="module")
def sample(root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a module of kernels and the library built from it."""
    folder = tmp_path_factory.mktemp("kernels")
    (folder / "sample.py").write_text(KERNELS, encoding="utf-8")
    run(root, folder, BUILD)
    return folder


def run(root: Path, folder: Path, program: str) -> str:
    paths = os.pathsep.join([str(root), str(folder)])
    done = subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, "PYTHONPATH": paths, "NUMBA_CACHE_DIR": str(folder / "cache")},
        capture_output=True, text=True, timeout=240, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stderr


def without_numba(root: Path, folder: Path) -> bool:
    """Whether a call that the library has does without numba; its values are right in any case."""
    out = folder / "loaded"
    run(
        root,
        folder,
        USE
        + "line = sample.Line(np.array([2.0]), -2.0)\n"
        + "found, count = sample.values(line, np.arange(3.0), True)\n"
        + "assert count == 3 and found.tolist() == [0.5, np.inf, 0.5], found\n"
        + f"open({str(out)!r}, 'w').write(str('numba' in sys.modules))\n",
    )
    return out.read_text(encoding="utf-8") == "False"


def test_what_the_library_has_runs_without_numba(root: Path, sample: Path) -> None:
    assert without_numba(root, sample)


def test_arrays_that_lie_otherwise_in_memory_are_told_apart(root: Path, sample: Path) -> None:
    run(
        root,
        sample,
        USE
        + "points = np.arange(8.0)\n"
        + "assert sample.second(points) == 1.0 and sample.second(points[::2]) == 2.0\n"
        + "assert 'numba' not in sys.modules\n"
        + "assert sample.second(points[::-1]) == 6.0\n",
    )


def test_other_threads_run_beside_a_kernel(root: Path, sample: Path) -> None:
    run(
        root,
        sample,
        USE
        + "import threading, time\n"
        + "flag, seen, told = np.zeros(1, np.int64), np.zeros(8, np.int64), []\n"
        + "waiting = threading.Thread(target=lambda: told.append(sample.is_told(flag, seen, 2**36)))\n"
        + "waiting.start()\n"
        + "while not seen.any():\n"
        + "    time.sleep(0.001)\n"
        + "flag[0] = 1\n"
        + "waiting.join()\n"
        + "assert told == [True] and 'numba' not in sys.modules\n",
    )


def test_what_the_library_lacks_is_numbas(root: Path, sample: Path) -> None:
    run(
        root,
        sample,
        USE
        + "line = sample.Line(np.array([2.0], np.float32), 0.0)\n"
        + "found, _ = sample.values(line, np.array([1.0, 2.0], np.float32), False)\n"
        + "assert found.tolist() == [0.25, 0.0625], found\n"
        + "assert sample.second(np.array([1, 2])) == 2\n"
        + "assert 'numba' in sys.modules\n",
    )


def test_a_library_of_other_sources_is_left_alone_until_it_is_built_again(root: Path, sample: Path) -> None:
    source = sample / "sample.py"
    source.write_text(KERNELS + "\n", encoding="utf-8")
    assert not without_numba(root, sample)
    run(root, sample, BUILD)
    assert without_numba(root, sample)


def test_a_kernel_whose_callee_in_another_file_has_changed_is_built_anew(root: Path, tmp_path: Path) -> None:
    callee = "from numerics.kernels import kernel\n\n@kernel()\ndef tuned(x):\n    return x + {}.0\n"
    caller = "from callee import tuned\n" + callee.replace("tuned(x)", "called(x)").replace(
        "x + {}.0", "tuned(x)"
    )
    (tmp_path / "caller.py").write_text(caller, encoding="utf-8")
    exercise = "def exercise():\n    import caller\n    caller.called(1.0)\n"
    build = f"from numerics.kernel_library import build_library\n{exercise}build_library('pair', exercise)\n"
    use = "from numerics.kernels import use_library\nuse_library('pair')\nimport sys, caller\n"
    for added in (1, 2):
        (tmp_path / "callee.py").write_text(callee.format(added), encoding="utf-8")
        run(root, tmp_path, build)
        run(
            root,
            tmp_path,
            use + f"assert caller.called(1.0) == {added + 1}.0 and 'numba' not in sys.modules\n",
        )


def test_a_library_that_cannot_be_loaded_is_left_alone(root: Path, sample: Path) -> None:
    (library,) = (sample / "cache").glob("sample-kernels*.so")
    content = library.read_bytes()
    library.write_bytes(b"no library")
    assert not without_numba(root, sample)
    library.write_bytes(content)


def test_without_a_compiler_there_is_no_library_but_a_word(root: Path, tmp_path: Path) -> None:
    (tmp_path / "sample.py").write_text(KERNELS, encoding="utf-8")
    said = run(root, tmp_path, "import os\nos.environ['CC'] = os.environ['CXX'] = '/nowhere/cc'\n" + BUILD)
    assert "no library of kernels" in said
    assert not without_numba(root, tmp_path)
