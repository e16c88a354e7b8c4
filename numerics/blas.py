"""Linear algebra on one thread: its matrices here are small, and several threads wait for each other."""

from __future__ import annotations

import os

VARIABLES = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")  # the libraries that NumPy and SciPy come with


def use_one_blas_thread() -> None:
    """Have linear algebra use one thread, unless the environment says how many; before NumPy is loaded.

    After each product or eigenvalue OpenBLAS's threads go on looking for work for a while, on the cores that
    kernels need. Of two hard sessions side by side on two cores each takes 2.5 s so, and 4.1 s with as many
    threads as cores (mean of 16, `informed`). Where NumPy is loaded, its threads are, and nothing changes.
    """
    for variable in VARIABLES:
        os.environ.setdefault(variable, "1")
