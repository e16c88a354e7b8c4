"""Places of the few flags that are set in a long row."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from numerics.kernels import kernel

WORDS = 8  # of eight flags, that are looked at together


@kernel(nogil=True, error_model="numpy")
def set_places(flags: NDArray[np.bool_], places: NDArray[np.signedinteger[Any]]) -> int:
    """Write the places of the flags that are set, ascending; how many there are.

    Parameters
    ----------
    flags
        (N,), N a multiple of 8: 64 or eight are passed over at a time where none is set.
    places
        (N,), written from its beginning; what stands behind the last place means nothing.
    """
    words = flags.view(np.uint64)
    count, last = 0, len(words) - WORDS
    word = 0
    while word < len(words):
        if word <= last:
            any_set = np.uint64(0)
            for k in range(word, word + WORDS):
                any_set |= words[k]
            if any_set == 0:
                word += WORDS
                continue
        for _ in range(min(WORDS, len(words) - word)):
            if words[word] != 0:
                for x in range(8 * word, 8 * word + 8):
                    places[count] = x
                    count += flags[x]
            word += 1
    return count
