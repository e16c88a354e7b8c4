"""Blooming: charge that a full well cannot hold spills over to its neighbours in the column."""

import numpy as np

from numerics.arrays import Field
from numerics.kernels import kernel


@kernel()
def bloomed(charge: Field, well: float, share: float) -> Field:
    """Charge after overflow along the columns, as in a CCD without a drain or with a weak one.

    Of what a pixel collects beyond its well, `share` spills, half of it upwards and half downwards, into the
    room that the next pixels have left; the rest drains off. What reaches the border is lost. What goes down
    fills first.

    Parameters
    ----------
    charge : (H, W) float32, in any unit.
    well : what a pixel holds, in the same unit.
    share : 0 to 1.

    Returns
    -------
    (H, W) float32, nowhere above `well`.
    """
    rows, columns = charge.shape
    out = np.minimum(charge, np.float32(well))
    if share <= 0.0:
        return out
    for step in (1, -1):
        first = 0 if step == 1 else rows - 1
        carried = np.zeros(columns, np.float32)
        for k in range(rows):
            y = first + step * k
            for x in range(columns):
                taken = min(carried[x], np.float32(well) - out[y, x])
                out[y, x] += taken
                carried[x] += np.float32(0.5 * share) * max(charge[y, x] - np.float32(well), 0.0) - taken
    return out
