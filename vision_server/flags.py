"""Places of the few flags that are set in a long row."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.kernels import kernel


@kernel(nogil=True, error_model="numpy")
def set_places(flags: NDArray[np.bool_], places: NDArray[np.signedinteger[Any]]) -> int:
    """Write the places of the flags that are set, ascending; how many there are.

    Parameters
    ----------
    flags
        (N,), N a multiple of 8: eight are passed over at a time where none is set.
    places
        (N,), written from its beginning; what stands behind the last place means nothing.
    """
    words = flags.view(np.uint64)
    count = 0
    for word in range(len(words)):
        if words[word] != 0:
            for x in range(8 * word, 8 * word + 8):
                places[count] = x
                count += flags[x]
    return count
