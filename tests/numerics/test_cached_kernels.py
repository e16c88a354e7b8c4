"""A kernel from the disk does what it did when it was compiled; its bitcode is read when one needs it."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numba import njit
from numba.core import codegen

from numerics.cached_kernels import read_bitcode_late
from numerics.cholesky import inverse_positive
from numerics.kernels import kernel

MATRIX = np.array([[4.0, 1.0], [1.0, 3.0]])


def from_disk() -> tuple[Any, Any]:
    """A kernel and its library as another process finds them."""
    plain = inverse_positive.py_func  # type: ignore[attr-defined]
    kernel()(plain)(MATRIX)  # on the disk by now
    found: Any = kernel()(plain)
    np.testing.assert_array_equal(found(MATRIX), inverse_positive(MATRIX))
    assert sum(found.stats.cache_hits.values()) == 1
    (overload,) = found.overloads.values()
    return found, overload.library


def test_it_does_the_same_and_no_bitcode_is_read() -> None:
    _, library = from_disk()
    assert library._bitcode and library._shared_module is None


def test_a_kernel_that_is_compiled_with_it_has_it_read() -> None:
    found, library = from_disk()

    @njit
    def twice(matrix: Any) -> Any:
        return 2.0 * found(matrix)

    np.testing.assert_array_equal(twice(MATRIX), 2.0 * inverse_positive(MATRIX))
    assert library._bitcode is None and library._shared_module is not None


def test_a_function_that_it_has_not_has_no_address() -> None:
    _, library = from_disk()
    assert library.get_pointer_to_function("nowhere") == 0
    library._get_module_for_linking()
    assert library.get_pointer_to_function("nowhere") == 0


def test_another_numba_is_left_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    assert read_bitcode_late()
    own = codegen.JITCPUCodegen._library_class
    monkeypatch.setattr(codegen, "JITCPUCodegen", SimpleNamespace(_library_class=object))
    assert not read_bitcode_late() and codegen.JITCPUCodegen._library_class is object
    monkeypatch.undo()
    assert codegen.JITCPUCodegen._library_class is own
