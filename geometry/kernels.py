"""What a process does to be quickly ready for compiled kernels."""

from __future__ import annotations

import gc
import sys

BLAS = "scipy.linalg.cython_blas"


def begin_loading() -> None:
    """Call before numba is imported: what is loaded stays, and need not be looked through for garbage."""
    gc.disable()


def prepare_kernels() -> None:
    """Have numba load what a first call of a compiled kernel needs, without SciPy's BLAS.

    Numba looks for BLAS, and loads half of SciPy with it, for kernels that call it. None here does, and
    finding none halves the time of the first call.
    """
    from numba.core.registry import cpu_target

    found = sys.modules.get(BLAS)
    if found is None:
        sys.modules[BLAS] = None  # type: ignore[assignment]  # how the import system is told "not there"
    try:
        cpu_target.target_context.refresh()
    finally:
        if found is None:
            del sys.modules[BLAS]
    gc.freeze()
    gc.enable()
