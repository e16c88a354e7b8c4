"""Freed memory that stays with the process."""

from __future__ import annotations

import ctypes
import subprocess
import sys
from pathlib import Path

import pytest

FAULTS = """
import resource
import numpy as np
from numerics.memory import keep_freed_memory

{first}

def touched():
    for array in [np.empty(2**22, np.uint8) for _ in range(8)]:
        array[:] = 1

touched()
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range(5):
    touched()
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""


@pytest.mark.skipif(not hasattr(ctypes.CDLL(None), "mallopt"), reason="not glibc")
def test_what_was_freed_comes_back_without_page_faults(root: Path) -> None:
    kept, given_back = (
        int(
            subprocess.run(
                [sys.executable, "-c", FAULTS.format(first=first)],
                cwd=root, capture_output=True, text=True, timeout=60, check=True,
            ).stdout
        )
        for first in ("keep_freed_memory()", "")
    )  # fmt: skip
    assert kept < 100 < given_back
