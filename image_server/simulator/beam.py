"""Beams: how a light's intensity falls away from where it is aimed, as a table over the angle."""

import math

import numpy as np
from numpy.typing import NDArray

from image_server.simulator.scenario import Light
from numerics.kernels import kernel

Floats = NDArray[np.float64]

STEPS_PER_DEG = 4
ROWS = 180 * STEPS_PER_DEG + 1


def beam_table(light: Light) -> Floats:
    """Relative intensity (ROWS,) of a light at angles from 0 to 180 degrees; 1 to all sides has no beam.

    A lamp with `half_intensity_deg` h shines as cos(angle)^m with m = log 0.5 / log cos h, the usual model
    of an LED (Lambert for h = 60 degrees).
    """
    degrees = np.arange(ROWS) / STEPS_PER_DEG
    if light.beam is not None:
        angles, intensities = np.array(light.beam).T
        return np.asarray(np.interp(degrees, angles, intensities, right=0.0))
    if light.half_intensity_deg is None:
        return np.ones(ROWS)
    power = math.log(0.5) / math.log(math.cos(math.radians(light.half_intensity_deg)))
    cosine = np.cos(np.radians(degrees))
    return np.where(cosine > 0, np.maximum(cosine, 1e-30) ** power, 0.0)


@kernel()
def intensity(table: Floats, cosine: float) -> float:
    """Relative intensity at an angle from the aim, given its cosine: straight lines between the rows."""
    place = math.degrees(math.acos(min(max(cosine, -1.0), 1.0))) * STEPS_PER_DEG
    row = min(int(place), ROWS - 2)
    share = place - row
    out: float = (1.0 - share) * table[row] + share * table[row + 1]
    return out
