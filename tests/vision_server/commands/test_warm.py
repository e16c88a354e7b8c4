"""`python -m vision_server warm`: what it starts ends with it."""

import os
import select
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from numerics.two_cores import cores

pytestmark = pytest.mark.slow

DEADLINE_S = 60.0


def children(pid: int) -> list[int]:
    return [int(word) for word in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


@pytest.mark.skipif(cores() == 1, reason="on one core there is no second process")
def test_ctrl_c_ends_both_processes_without_a_word(root: Path, tmp_path: Path) -> None:
    with subprocess.Popen(
        [sys.executable, "-m", "vision_server", "warm"], cwd=root, start_new_session=True,
        env=os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    ) as running:  # fmt: skip
        until = time.monotonic() + DEADLINE_S
        while not (second := children(running.pid)) and time.monotonic() < until:
            time.sleep(0.01)
        watch = os.pidfd_open(second[0])
        time.sleep(1.0)  # into its kernels
        os.killpg(running.pid, signal.SIGINT)
        assert running.communicate(timeout=DEADLINE_S) == (b"", b"")
    assert running.returncode == 130
    assert select.select([watch], [], [], DEADLINE_S)[0]
    os.close(watch)
