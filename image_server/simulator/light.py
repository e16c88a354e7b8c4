"""Light: where it comes from, how strong it is, and how a lamp's beam falls away from where it is aimed.

Radiances are those of a white Lambert surface; 1 clips at the reference exposure and gain 1.
"""

import math
from itertools import pairwise
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from bridge.errors import BadInput
from image_server.simulator.sky import Sky
from numerics.kernels import kernel
from stack.tables import Table

Floats = NDArray[np.float64]
NotNegative = Annotated[float, Meta(ge=0)]
HalfTurn = Annotated[float, Meta(ge=0, le=180)]
Vector3 = tuple[float, float, float]

REFERENCE_DISTANCE_M = 0.6  # the middle of the usual ranges; chosen by hand
LIGHT_AT_REFERENCE = 0.5
"""Radiance of a surface turned to one full light at that distance; chosen by hand, for a stop of room."""
LIGHT_STRENGTH = LIGHT_AT_REFERENCE * REFERENCE_DISTANCE_M**2
"""Radiance of a surface turned to a light 1 m away, in the middle of its beam."""
SUN_STRENGTH = 0.5
"""Radiance of a surface turned to the sun at `ambient_scale` 1: as bright as one lamp at its reference."""
STEPS_PER_DEG = 4  # of a beam's table; chosen by hand, finer than any datasheet's curve
ROWS = 180 * STEPS_PER_DEG + 1


class Light(Table, frozen=True):
    """One of `[[lights]]`: a point that shines with the square of the distance.

    Attributes
    ----------
    position
        Camera frame, metres.
    aim
        Where the middle of its beam points, camera frame.
    half_intensity_deg
        A lamp whose intensity falls as a power of the cosine from `aim` and is half at this angle, as
        manufacturers of LEDs state it. None: the same to all sides.
    beam
        Measured instead: pairs of angle from `aim` (degrees, growing) and relative intensity, joined by
        straight lines, 0 beyond the last.
    """

    name: str
    position: Vector3
    levels: Annotated[int, Meta(ge=1, le=65536)] = 8
    power: NotNegative = 1.0
    aim: Vector3 = (0.0, 0.0, 1.0)
    half_intensity_deg: Annotated[float, Meta(ge=1, lt=90)] | None = None
    beam: Annotated[tuple[tuple[HalfTurn, NotNegative], ...], Meta(min_length=2)] | None = None


DEFAULT_LIGHTS = (
    Light(name="left", position=(-0.35, 0.0, 0.0)),
    Light(name="right", position=(0.35, 0.0, 0.0)),
    Light(name="top", position=(0.0, -0.35, 0.0)),
)


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


def check_beam(light: Light, file: Path) -> None:
    """Raise BadInput for a beam that is said twice or whose angles do not grow."""
    where = f"{file}: [[lights]] {light.name!r}"
    if light.beam is None:
        return
    if light.half_intensity_deg is not None:
        raise BadInput(f"{where} has half_intensity_deg and beam.", "Keep the one that was measured.")
    angles = [angle for angle, _ in light.beam]
    if any(later <= earlier for earlier, later in pairwise(angles)):
        raise BadInput(f"{where}: the angles of its beam do not grow.", "Write them from small to large.")


@kernel()
def intensity(table: Floats, cosine: float) -> float:
    """Relative intensity at an angle from the aim, given its cosine: straight lines between the rows."""
    place = math.degrees(math.acos(min(max(cosine, -1.0), 1.0))) * STEPS_PER_DEG
    row = min(int(place), ROWS - 2)
    share = place - row
    out: float = (1.0 - share) * table[row] + share * table[row + 1]
    return out
