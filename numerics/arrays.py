"""What arrays hold, for annotations; their shapes are told where they are taken and given."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]
Field = NDArray[np.float32]  # a value for each pixel
Grey = NDArray[np.uint8]  # pictures
Reals = NDArray[np.float64] | NDArray[np.float32]  # where either will do
