"""Each light's own part of what the channels show, where the lights' levels are known; it tells shadows.

Intensities add up: a channel shows the sun, and of each lamp what its level gives. With as many channels as
lights, and levels that are not the same all over again, both sides of an edgel have a part of each light. At
a shadow each part is the same on both sides, but those of the lights that are blocked: they are nothing on
one of them. At a crease they are not, and no part is.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from numerics.arrays import Field, Flags, Floats
from numerics.kernels import kernel
from numerics.logarithm import ZERO
from vision_server.kinds.sides import Sides

SAME = 1e-6  # rounding
MOST_NOISE = 6.0  # of a part, in that of single channels: more lights that are hardly told apart


class KnownLights(NamedTuple):
    """What lights there are and how far each is on.

    Attributes
    ----------
    on
        float64 (C, L), in each channel, as a share of the full one; the last one is the sun, if there is one.
    share
        float32 (L, C), of what the channels show, what each light gives; None where they cannot be told
        apart.
    are_all
        Whether there are no others: of those that were learnt there may be.
    """

    on: Floats
    share: Field | None
    are_all: bool = True

    @property
    def are_alone(self) -> bool:
        """Whether each is on in one channel and none but it is on there."""
        return self.on.shape[0] == self.on.shape[1] and bool((np.count_nonzero(self.on, axis=0) == 1).all())

    @property
    def are_alone_in_the_sun(self) -> bool:
        """The same beside the sun, which is on in all channels."""
        return self._replace(on=self.on[:, :-1]).are_alone and bool((self.on[:, -1] == 1.0).all())


def known_lights(levels: Floats) -> KnownLights:
    """The lamps that are ever on, and the sun, which is on in all channels.

    Parameters
    ----------
    levels
        float64 (C, K), level of each lamp in each channel, as a share of its full one.
    """
    return lights_of(np.hstack([levels[:, levels.any(axis=0)], np.ones((len(levels), 1))]))


def lights_of(on: Floats) -> KnownLights:
    """Lights that are on in C channels as far as (C, L) says."""
    if len(on) < on.shape[1]:
        return KnownLights(on, None)
    try:  # many times as quick where there are as many
        share = np.linalg.inv(on) if len(on) == on.shape[1] else np.linalg.pinv(on)
    except np.linalg.LinAlgError:
        return KnownLights(on, None)
    apart = np.abs(share @ on - np.eye(len(share))).max() < SAME
    apart &= np.linalg.norm(share, axis=1).max() <= MOST_NOISE
    return KnownLights(on, share.astype(np.float32) if apart else None)


def parts_of(sides: Sides, lights: KnownLights) -> Sides | None:
    """What each light gives to the sides of N edgels: sides in as many channels as there are lights.

    Parameters
    ----------
    sides
        In C channels.

    Returns
    -------
    Sides of the L lights; None where they cannot be told apart.
    """
    share = lights.share
    if share is None:
        return None
    many, count = len(share), sides.noise.shape[1]
    near, noise = np.empty((many, 2, count), np.float32), np.empty((many, count), np.float32)
    known = np.empty((many, count), np.bool_)
    _parts(share, sides, near, noise, known)
    return Sides(near, near, noise, known, sides.axis, sides.dark, sides.sharpness)


@kernel(fastmath={"reassoc", "contract", "nsz"})
def _parts(share: Field, of: Sides, near: Field, noise: Field, known: Flags) -> None:
    """As `parts_of`; the last three are outputs."""
    channels, count = of.noise.shape
    for light in range(len(share)):
        for side in range(2):
            given = near[light, side]
            given[:] = ZERO
            for channel in range(channels):
                part = share[light, channel]
                for i in range(count):
                    given[i] += part * of.near[channel, side, i]
        of_noise, of_known = noise[light], known[light]
        of_noise[:], of_known[:] = ZERO, True
        for channel in range(channels):
            part = share[light, channel] * share[light, channel]
            for i in range(count):
                of_noise[i] += part * of.noise[channel, i] * of.noise[channel, i]
            for i in range(count):
                of_known[i] &= of.known[channel, i]
        for i in range(count):
            of_noise[i] = np.sqrt(of_noise[i])


def apparent_parts(sides: Sides) -> Sides:
    """What stands for the lights' parts where their levels are not known, as of C + 1 lights.

    What each channel shows more than the darkest does, and what that shows, as if by the sun.
    """
    least = sides.near.min(axis=0, keepdims=True)
    near = np.concatenate([sides.near - least, least])
    noise = np.concatenate([sides.noise, sides.noise.max(axis=0, keepdims=True)])
    known = np.broadcast_to(sides.known.all(axis=0), noise.shape)
    return sides._replace(near=near, brightest=near, noise=noise, known=known)
