"""Removing compiled kernels that are older than something they were compiled from.

Numba compiles a kernel together with the kernels it calls, but looks only at its own file when it takes it
from the disk: one whose callee in another file has changed since would still run with the old one.
"""

from __future__ import annotations

import ast
import os
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ("geometry", "numerics", "stack", "image_server", "vision_server")


def remove_stale_kernels(root: Path = ROOT, packages: tuple[str, ...] = PACKAGES) -> list[Path]:
    """Remove what numba keeps of each kernel that is older than a file its own file imports, at any remove.

    Parameters
    ----------
    root, packages
        Folder of the packages, and their names; imports of others are not followed.

    Returns
    -------
    The removed files.
    """
    removed = []
    for package in packages:
        for source in (root / package).rglob("*.py"):
            compiled = list(_compiled(source))
            if compiled:
                newest = max(path.stat().st_mtime for path in _sources(source, root, packages))
                old = [path for path in compiled if path.stat().st_mtime < newest]
                for path in old:
                    path.unlink(missing_ok=True)
                removed += old
    return removed


def _compiled(source: Path) -> Iterator[Path]:
    """Files that numba keeps for a source: index and machine code of each of its kernels."""
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    folder = Path(chosen) if chosen else source.parent / "__pycache__"
    return folder.rglob(f"{source.stem}.*.nb[ci]")


def _sources(source: Path, root: Path, packages: tuple[str, ...]) -> set[Path]:
    """A file and all that it imports, directly or through others."""
    reached: set[Path] = set()
    waiting = [source]
    while waiting:
        path = waiting.pop()
        if path not in reached:
            reached.add(path)
            waiting += _imported(path, root, packages)
    return reached


@cache
def _imported(source: Path, root: Path, packages: tuple[str, ...]) -> list[Path]:
    names = set()
    for node in ast.walk(ast.parse(source.read_bytes())):
        if isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
        elif isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
    files = (root / (name.replace(".", "/") + ".py") for name in names if name.split(".")[0] in packages)
    return [file for file in files if file.is_file()]
