"""Each light's own part of what the channels show, where the lights' levels are known; it tells shadows.

Intensities add up: a channel shows the sun, and of each lamp what its level gives. With as many channels as
lights, and levels that are not the same all over again, both sides of an edgel have a part of each light. At
a shadow each part is the same on both sides, but those of the lights that are blocked: they are nothing on
one of them. At a crease they are not, and no part is.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vision_server.edges.sides import Sides

Floats = NDArray[np.float64]

MOST_NOISE = 6.0  # of a part, in that of single channels: more lights that are hardly told apart


def lights_of(levels: Floats) -> Floats:
    """How far each light is on in each channel, float64 (C, L + 1).

    Parameters
    ----------
    levels
        float64 (C, L), level of each lamp in each channel, as a share of its full one. Another light, the
        sun, is on in all: the last column. Lamps that are never on are left out.
    """
    return np.hstack([levels[:, levels.any(axis=0)], np.ones((len(levels), 1))])


def parts_of(sides: Sides, lights: Floats) -> Sides | None:
    """What each light gives to the sides of N edgels: sides in as many channels as there are lights.

    Parameters
    ----------
    sides
        In C channels.
    lights
        float64 (C, L), as `lights_of` gives them.

    Returns
    -------
    Sides of the L lights; None where they cannot be told apart.
    """
    if len(lights) < lights.shape[1]:
        return None
    share = np.linalg.pinv(lights)
    if (
        not np.allclose(share @ lights, np.eye(len(share)))
        or np.linalg.norm(share, axis=1).max() > MOST_NOISE
    ):
        return None
    near = np.tensordot(share.astype(np.float32), sides.near, axes=1)
    noise = np.sqrt(np.square(share).astype(np.float32) @ np.square(sides.noise))
    known = np.broadcast_to(sides.known.all(axis=0), noise.shape)
    return sides._replace(near=near, brightest=near, noise=noise, known=known)
