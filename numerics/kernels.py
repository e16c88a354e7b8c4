"""The decorator of numeric kernels: Python functions that numba compiles, and keeps compiled on the disk."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numerics.optional import without

with without("scipy", "scipy.linalg", "coverage", "yaml"):  # 0.19 of 0.5 s up to a first kernel
    import numba.np.arraymath  # noqa: F401  which looks for SciPy's linear algebra once
    from numba import njit

Function = TypeVar("Function", bound=Callable[..., Any])


def kernel(**options: Any) -> Callable[[Function], Function]:
    """Decorator of a kernel; the options are `numba.njit`'s. To divide by zero is no error, as in NumPy.

    Kernels let go of the interpreter's lock while they run, so that two cores can (`numerics.two_cores`).

    What is compiled at the first call for arguments of some kinds is taken from the disk by every later
    process (`numerics.stale_kernels` says when it must not be).
    """

    def decorated(function: Function) -> Function:
        return cast(Function, njit(cache=True, error_model="numpy", nogil=True, **options)(function))

    return decorated
