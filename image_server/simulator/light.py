"""Light: where it comes from, how strong it is, and how a lamp's beam falls away from where it is aimed.

Radiances are those of a white Lambert surface; 1 clips at the reference exposure and gain 1.
"""

import math
from typing import NamedTuple

import numpy as np

from image_server.simulator.scenario_tables import Light
from image_server.simulator.sky import Sky
from numerics.arrays import Floats
from numerics.kernels import kernel

REFERENCE_DISTANCE_M = 0.6  # the middle of the usual ranges; chosen by hand
LIGHT_AT_REFERENCE = 0.5
"""Radiance of a surface turned to one full light at that distance; chosen by hand, for a stop of room."""
LIGHT_STRENGTH = LIGHT_AT_REFERENCE * REFERENCE_DISTANCE_M**2
"""Radiance of a surface turned to a light 1 m away, in the middle of its beam."""
SUN_STRENGTH = 0.5
"""Radiance of a surface turned to the sun at `ambient_scale` 1: as bright as one lamp at its reference."""
STEPS_PER_DEG = 4  # of a beam's table; chosen by hand, finer than any datasheet's curve
ROWS = 180 * STEPS_PER_DEG + 1


class Illumination(NamedTuple):
    """Where light comes from, camera frame.

    Attributes
    ----------
    lights : (L, 3) float64 positions, metres.
    aims : (L, 3) float64 unit vectors along the middles of their beams.
    beams : (L, ROWS) float64, their profiles.
    sky : the sun, and what else shines from afar.
    """

    lights: Floats
    aims: Floats
    beams: Floats
    sky: Sky


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
