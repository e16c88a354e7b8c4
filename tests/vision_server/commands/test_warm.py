"""`python -m vision_server warm`: it calls every kernel, and what it starts ends with it."""

import os
import select
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from numerics.two_cores import cores
from tests.commands import started

pytestmark = pytest.mark.slow

DEADLINE_S = 60.0
NEVER_CALLED = """
import os, sys
from numba.core.dispatcher import Dispatcher
from vision_server.commands.warm import refine, warm_up
warm_up()
refine(os.getppid())
kernels = {
    kernel: word
    for name, module in list(sys.modules.items())
    for word, kernel in vars(module).items()
    if isinstance(kernel, Dispatcher) and kernel.__module__ == name and "numba" not in name
}
by_others = {name for kernel in kernels for name in kernel.py_func.__code__.co_names}
never = [word for kernel, word in kernels.items() if not kernel.signatures and word not in by_others]
print(len(kernels), *never)
"""


def children(pid: int) -> list[int]:
    return [int(word) for word in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def test_it_calls_every_kernel_that_no_other_one_calls(root: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", NEVER_CALLED], cwd=root, capture_output=True, text=True, check=True
    )
    count, *never_called = done.stdout.split()
    assert int(count) > 200
    assert never_called == []


@pytest.mark.skipif(cores() == 1, reason="on one core there is no second process")
def test_ctrl_c_ends_both_processes_without_a_word(root: Path, tmp_path: Path) -> None:
    with started(
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
