"""Kernels are taken from the disk without the part of them that only a further compilation reads.

Numba keeps a kernel as machine code and, for kernels that are compiled later and call it, as LLVM's bitcode.
Of each that it takes from the disk it reads both, and asks for the name of every function in the bitcode,
which is more than half of loading. Here the bitcode is read when another kernel is compiled with it.
"""

from __future__ import annotations

from typing import Any

from llvmlite import binding
from numba.core import codegen


class _Library(codegen.JITCodeLibrary):
    """A compiled kernel; one that comes from the disk keeps its bitcode as bytes until it is needed."""

    _bitcode: bytes | None = None

    @classmethod
    def _unserialize(cls, generator: Any, state: tuple[str, str, Any]) -> Any:
        """The kernel that was kept as `state`, as in Numba but for the bitcode."""
        numba: Any = super()
        name, kind, data = state
        if kind != "object":
            return numba._unserialize(generator, state)
        library = generator.create_library(name)
        machine_code, library._bitcode = data
        library.enable_object_caching()
        library._set_compiled_object(machine_code)
        library._finalize_final_module()
        return library

    def _get_module_for_linking(self) -> Any:
        """The kernel as others are compiled with it."""
        numba: Any = super()
        if self._bitcode is not None:
            self._shared_module = binding.parse_bitcode(self._bitcode)
            self._bitcode = None
            engine: Any = self._codegen._engine
            engine._load_defined_symbols(self._shared_module)
        return numba._get_module_for_linking()

    def get_pointer_to_function(self, name: str) -> int:
        """Address of a function of the kernel, 0 where there is none."""
        numba: Any = super()
        if self._bitcode is None:
            return int(numba.get_pointer_to_function(name))
        return int(self._codegen._engine.get_function_address(name))


def read_bitcode_late() -> bool:
    """Have kernels taken from the disk so; False, and nothing is changed, where Numba has no place for it."""
    needed = ("_unserialize", "_set_compiled_object", "_finalize_final_module", "_get_module_for_linking")
    generator: Any = getattr(codegen, "JITCPUCodegen", None)
    known = all(hasattr(codegen.JITCodeLibrary, name) for name in needed)
    if not known or getattr(generator, "_library_class", None) not in (codegen.JITCodeLibrary, _Library):
        return False
    generator._library_class = _Library
    return True
