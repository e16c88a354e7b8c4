"""Building a library of kernels (`numerics.kernels`): machine code that is there without numba."""

from __future__ import annotations

import json
import os
import sys
import tempfile
import warnings
from collections.abc import Callable, Iterable
from importlib import import_module
from pathlib import Path
from typing import Any

from numerics.kernels import (
    FOLDER,
    ROOT,
    Kernel,
    Library,
    begin_library,
    is_current,
    library_file,
    processor_features,
    read_manifest,
    stamp,
)

# Half of what a processor of today can do is not in every one: what the level of the architecture that
# compilers call x86-64-v3 has beyond the first, as Linux names it.
LEVEL = "x86-64-v3"
LEVEL_FEATURES = ("avx2", "bmi1", "bmi2", "f16c", "fma", "abm", "movbe")


def build_library(name: str, exercise: Callable[[], None]) -> None:
    """Build a library of the kernels that `exercise` calls, for arguments of the kinds it calls them with.

    To be called before anything is imported that has kernels; a library that is up to date stays. Numba's own
    cache is filled as well.

    Parameters
    ----------
    exercise : imports what has kernels and runs it.
    """
    manifest = read_manifest(name)
    if manifest is not None and library_file(name).is_file() and is_current(manifest):
        return
    if manifest is not None:
        _forget(manifest["sources"])
    library = begin_library()
    exercise()
    FOLDER.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=FOLDER) as folder:
        try:
            manifest = _built(name, library, Path(folder))
        except Exception as error:  # whatever a compiler can say
            reason = f"{type(error).__name__}: {error}"
            print(f"{name}: no library of kernels, it will start more slowly: {reason}", file=sys.stderr)
            return
        written = Path(folder) / "manifest.json"
        written.write_text(json.dumps(manifest, indent=1), encoding="utf-8")
        library_file(name).with_suffix(".json").unlink(missing_ok=True)  # never one beside another's library
        os.replace(Path(folder) / library_file(name).name, library_file(name))
        os.replace(written, library_file(name).with_suffix(".json"))


def _forget(sources: Iterable[str]) -> None:
    """Remove what numba keeps of the kernels in these files.

    It looks at a kernel's own file only, and would go on using one whose callees in other files have changed.
    """
    for source in sources:
        path = ROOT / source
        folder = FOLDER if "NUMBA_CACHE_DIR" in os.environ else path.parent / "__pycache__"
        for kept in folder.rglob(f"{path.stem}.*.nb[ci]"):
            kept.unlink(missing_ok=True)


def _built(name: str, library: Library, folder: Path) -> dict[str, Any]:
    """Compile into a folder; the manifest."""
    numba: Any = import_module("numba")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", numba.NumbaPendingDeprecationWarning)
        pycc: Any = import_module("numba.pycc")
        pycc_compiler: Any = import_module("numba.pycc.compiler")
    compiler = pycc.CC(f"{name}_kernels", source_module=sys.modules[__name__])
    compiler.output_dir = str(folder)
    compiler.output_file = library_file(name).name
    leveled = numba.config.CPU_NAME is None and processor_features().issuperset(LEVEL_FEATURES)
    compiler.target_cpu = LEVEL if leveled else ""
    symbols: dict[str, dict[str, str]] = {}
    exported: dict[Any, str] = {}
    for kernel, calls in library.calls.items():
        for kinds, args in calls.items():
            types = tuple(numba.typeof(value) for value in args)
            if (kernel, types) not in exported:
                symbol = exported[kernel, types] = f"k{len(exported)}"
                signature = kernel.dispatcher.overloads[types].signature
                compiler.export(symbol, signature)(_entry(kernel, len(types)))
            symbols.setdefault(kernel.name, {})[kinds] = exported[kernel, types]
    flags, pycc_compiler.Flags = pycc_compiler.Flags, _flags  # it has no option for this
    try:
        compiler.compile()
    finally:
        pycc_compiler.Flags = flags
    sources = sorted({Path(kernel.py_func.__code__.co_filename).resolve() for kernel in library.kernels})
    return {
        "features": list(LEVEL_FEATURES) if leveled else [],
        "sources": {os.path.relpath(source, ROOT): stamp(source) for source in sources},
        "symbols": symbols,
    }


def _flags() -> Any:
    """How entries are compiled: as all kernels may, they let other threads run."""
    flags = import_module("numba.core.compiler").Flags()
    flags.release_gil = True
    return flags


def _entry(kernel: Kernel, count: int) -> Callable[..., Any]:
    """A function of so many arguments that calls a kernel, which keeps its own options thereby."""
    names = ", ".join(f"a{number}" for number in range(count))
    entry: Callable[..., Any] = eval(f"lambda {names}: kernel({names})", {"kernel": kernel.dispatcher})
    return entry
