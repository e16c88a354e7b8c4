"""Which of a row are marked, in kernels: eight marks at a time, as most rows have few, without branches."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from numerics.arrays import Flags
from numerics.kernels import kernel


class Marks(NamedTuple):
    """Marks of a row, and room to list them.

    Attributes
    ----------
    marked
        bool (N,), to be set; as long as the row or up to 7 longer, where it stays False.
    eights
        uint64 (N // 8,), the same eight at a time.
    numbers
        int32 (N + 8,), output of `list_marks`.
    """

    marked: Flags
    eights: NDArray[np.uint64]
    numbers: NDArray[np.int32]


@kernel()
def no_marks(count: int) -> Marks:
    """For a row of so many."""
    marked = np.zeros((count + 7) // 8 * 8, np.bool_)
    return Marks(marked, marked.view(np.uint64), np.empty(len(marked) + 8, np.int32))


@kernel(inline="always")
def list_marks(marks: Marks) -> int:
    """List the numbers of what is marked, ascending; how many there are."""
    marked, eights, numbers = marks
    count = 0
    for k in range(len(eights)):
        if eights[k] != 0:
            for i in range(8 * k, 8 * k + 8):  # no branches: they would be guesses
                numbers[count] = i
                count += marked[i]
    return count
