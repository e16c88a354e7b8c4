"""The decorator of numeric kernels: Python functions that numba compiles, and keeps compiled on the disk."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

Function = TypeVar("Function", bound=Callable[..., Any])


def kernel(**options: Any) -> Callable[[Function], Function]:
    """Decorator of a kernel; the options are `numba.njit`'s.

    What is compiled at the first call for arguments of some kinds is taken from the disk by every later
    process (`numerics.stale_kernels` says when it must not be).
    """

    def decorated(function: Function) -> Function:
        return cast(Function, njit(cache=True, **options)(function))

    return decorated
