"""Numeric kernels: plain Python functions that run compiled.

Numba compiles a kernel when it is first called and keeps the machine code on the disk. Importing numba and
taking each kernel from there needs half a second, for which a session would wait. A program that says
`use_library` at its start takes its kernels from one shared library instead, which `warm` has built
(`numerics.kernel_library`), and numba only for what that lacks. A library that was built from other sources,
or for another processor, is left alone.
"""

from __future__ import annotations

import gc
import json
import os
import sys
from collections.abc import Callable
from functools import cached_property
from importlib.machinery import EXTENSION_SUFFIXES, ExtensionFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np

if TYPE_CHECKING:
    from types import ModuleType

BLAS = "scipy.linalg.cython_blas"
ROOT = Path(__file__).resolve().parent.parent
FOLDER = Path(os.environ.get("NUMBA_CACHE_DIR") or Path(__file__).resolve().parent / "__pycache__")
C_ORDER, F_ORDER, ALIGNED, WRITEABLE = 0x1, 0x2, 0x100, 0x400  # bits of ndarray.flags.num

Native = Callable[..., Any]
Function = TypeVar("Function", bound=Native)


class Library:
    """Compiled kernels by name and by the kinds of their arguments.

    Parameters
    ----------
    module : the shared library; None while what it shall hold is found out.
    symbols : for each kernel, the symbol in it for each kind of arguments.
    """

    def __init__(self, module: ModuleType | None, symbols: dict[str, dict[str, str]]) -> None:
        self._module = module
        self._symbols = symbols
        self.kernels: list[Kernel] = []
        self.calls: dict[Kernel, dict[str, tuple[Any, ...]]] = {}

    def function(self, kernel: Kernel, args: tuple[Any, ...]) -> Native:
        """What runs a kernel for arguments of these kinds: from the library, else numba's dispatcher."""
        kinds = described(args)
        symbol = self._symbols.get(kernel.name, {}).get(kinds)
        if symbol is not None:
            native: Native = getattr(self._module, symbol)
            return native
        self.calls.setdefault(kernel, {})[kinds] = args
        dispatcher: Native = kernel.dispatcher
        return dispatcher


_library: Library | None = None


class Kernel:
    """A kernel of a program that uses a library. Kernels that numba compiles may call it like its own."""

    def __init__(self, function: Native, options: dict[str, Any], library: Library) -> None:
        self.py_func = function
        self.name = f"{function.__module__}.{function.__qualname__}"
        self._options = options
        self._library = library
        self._known: dict[Any, Native] = {}
        library.kernels.append(self)

    def __call__(self, *args: Any) -> Any:
        """Run it compiled."""
        kinds = tuple([_kind(value) for value in args])
        function = self._known.get(kinds)
        if function is None:
            function = self._known[kinds] = self._library.function(self, args)
        return function(*args)

    @cached_property
    def dispatcher(self) -> Any:
        """The same function compiled by numba when it is called."""
        return _compiled(self.py_func, self._options)

    @property
    def _numba_type_(self) -> Any:  # what numba asks a value for
        return self.dispatcher._numba_type_

    @property
    def targetoptions(self) -> dict[str, Any]:
        """What numba asks a function for that is to be inlined."""
        options: dict[str, Any] = self.dispatcher.targetoptions
        return options


def kernel(**options: Any) -> Callable[[Function], Function]:
    """Decorator of a kernel; the options are `numba.njit`'s."""

    def decorated(function: Function) -> Function:
        if _library is None:
            return cast(Function, _compiled(function, options))
        return cast(Function, Kernel(function, options, _library))

    return decorated


def _compiled(function: Native, options: dict[str, Any]) -> Any:
    from numba import njit

    return njit(cache=True, **options)(function)


def use_library(name: str) -> None:
    """Take the kernels that are defined from now on from a library, if there is one that is up to date.

    Called before anything is imported that has kernels. What is loaded then stays, and need not be looked
    through for garbage until `prepare_kernels`.
    """
    global _library  # noqa: PLW0603  # which kernels a process runs is decided once, before they are defined
    gc.disable()
    manifest = read_manifest(name)
    if manifest is not None and is_current(manifest):
        module = loaded(name)
        if module is not None:
            _library = Library(module, manifest["symbols"])


def begin_library() -> Library:
    """Kernels that are defined from now on tell the library returned how they are called."""
    global _library  # noqa: PLW0603
    _library = Library(None, {})
    return _library


def library_file(name: str) -> Path:
    """Where a library is; its manifest lies beside it."""
    return FOLDER / f"{name}-kernels{EXTENSION_SUFFIXES[0]}"


def read_manifest(name: str) -> dict[str, Any] | None:
    """What is said of a library, None where there is none that can be read."""
    try:
        manifest: dict[str, Any] = json.loads(library_file(name).with_suffix(".json").read_bytes())
    except (OSError, ValueError):
        return None
    return manifest


def is_current(manifest: dict[str, Any]) -> bool:
    """Whether the sources are those a library was built from, and the processor has what it needs."""
    try:
        return all(stamp(ROOT / source) == known for source, known in manifest["sources"].items()) and (
            processor_features().issuperset(manifest["features"])
        )
    except OSError:
        return False


def stamp(source: Path) -> list[int]:
    """What changes when a file is written: size and time."""
    found = source.stat()
    return [found.st_size, found.st_mtime_ns]


def processor_features() -> frozenset[str]:
    """What the processor offers beyond its kind's least, as Linux names it; empty where it does not say."""
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            line = next((line for line in lines if line.startswith("flags")), "")
    except OSError:
        return frozenset()
    return frozenset(line.split())


def loaded(name: str) -> ModuleType | None:
    """The shared library as a module; None for one that cannot be loaded."""
    loader = ExtensionFileLoader(f"{name}_kernels", str(library_file(name)))
    spec = spec_from_loader(loader.name, loader)
    if spec is None:
        return None
    try:
        module = module_from_spec(spec)
        loader.exec_module(module)
    except ImportError:
        return None
    return module


def _kind(value: Any) -> Any:
    """What tells arguments for different machine code apart, quickly."""
    if type(value) is np.ndarray:
        return value.dtype, value.ndim, value.flags.num
    if isinstance(value, tuple):
        return type(value), *[_kind(part) for part in value]
    return type(value)


def described(args: tuple[Any, ...]) -> str:
    """The kinds of arguments in words: as `_kind`, but for what makes no difference to machine code."""
    return " ".join(_described(value) for value in args)


def _described(value: Any) -> str:
    if type(value) is np.ndarray:
        bits = value.flags.num
        order = "C" if bits & C_ORDER else "F" if bits & F_ORDER else "A"
        rest = ("" if bits & WRITEABLE else "!w") + ("" if bits & ALIGNED else "!a")
        return f"{value.dtype.str}{value.ndim}{order}{rest}"
    if isinstance(value, tuple):
        return f"{type(value).__name__}({described(value)})"
    return type(value).__name__


def prepare_kernels() -> None:
    """Have numba load what a first call of a compiled kernel needs, without SciPy's BLAS.

    Numba looks for BLAS, and loads half of SciPy with it, for kernels that call it. None here does, and
    finding none halves the time of the first call. There is nothing to do for a program that uses a library.
    """
    if _library is None:
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
