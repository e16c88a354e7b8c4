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


def parts_of(sides: Sides, levels: Floats) -> Sides | None:
    """What each light gives to the sides of N edgels: sides in as many channels as there are lights.

    Parameters
    ----------
    sides
        In C channels.
    levels
        float64 (C, L), level of each lamp in each channel, as a share of its full one. Another light, the
        sun, is on in all.

    Returns
    -------
    Sides of the L + 1 lights, less the lamps that are never on; None where they cannot be told apart.
    """
    lamps = levels[:, levels.any(axis=0)]
    lights = np.hstack([lamps, np.ones((len(levels), 1))])
    if len(lights) < lights.shape[1] or np.linalg.matrix_rank(lights) < lights.shape[1]:
        return None
    share = np.linalg.pinv(lights)
    if np.linalg.norm(share, axis=1).max() > MOST_NOISE:
        return None
    near = np.tensordot(share.astype(np.float32), sides.near, axes=1)
    noise = np.sqrt(np.square(share).astype(np.float32) @ np.square(sides.noise))
    known = np.broadcast_to(sides.known.all(axis=0), noise.shape)
    return Sides(near, near, noise, known, sides.dark)
