"""Optional packages that a library looks for, and that nothing here needs of it: to load them takes long."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from threading import get_ident
from typing import Any


class _Absent:
    """Finds no packages of some names, in the thread that made it."""

    def __init__(self, packages: tuple[str, ...]) -> None:
        self._packages, self._thread = packages, get_ident()

    def find_spec(self, name: str, *_: Any) -> None:
        """None: others may find it."""
        if name in self._packages and get_ident() == self._thread:
            raise ModuleNotFoundError(f"No module named {name!r}: it is hidden", name=name)


@contextmanager
def without(*packages: str) -> Iterator[None]:
    """To import one of these raises ImportError meanwhile, as if it were missing.

    It does so in this thread, and where the package is not loaded yet.
    """
    absent: Any = _Absent(packages)
    sys.meta_path.insert(0, absent)
    try:
        yield
    finally:
        sys.meta_path.remove(absent)
