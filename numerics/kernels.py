"""The decorator of numeric kernels: Python functions that numba compiles, and keeps compiled on the disk."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar, cast

LOOKED_FOR = ("scipy.linalg", "coverage", "yaml")
"""Optional packages that numba imports where they are installed, and that kernels here have no use for."""


@contextmanager
def _without(packages: tuple[str, ...]) -> Iterator[None]:
    """To import one of these that is not loaded yet raises ImportError meanwhile, as if it were missing."""
    modules = cast("dict[str, Any]", sys.modules)
    hidden = [package for package in packages if package not in modules]
    modules.update(dict.fromkeys(hidden))
    try:
        yield
    finally:
        for package in hidden:
            del modules[package]


with _without(LOOKED_FOR):  # 0.19 of 0.5 s up to a first kernel
    import numba.np.arraymath  # noqa: F401  which looks for SciPy's linear algebra once
    from numba import njit

Function = TypeVar("Function", bound=Callable[..., Any])


def kernel(**options: Any) -> Callable[[Function], Function]:
    """Decorator of a kernel; the options are `numba.njit`'s. To divide by zero is no error, as in NumPy.

    What is compiled at the first call for arguments of some kinds is taken from the disk by every later
    process (`numerics.stale_kernels` says when it must not be).
    """

    def decorated(function: Function) -> Function:
        return cast(Function, njit(cache=True, error_model="numpy", **options)(function))

    return decorated
