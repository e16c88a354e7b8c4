"""Whether the target, tilted a little, explains a frame as well as the pose that it was followed to.

A thin plate has two edges on each side, and poses a few degrees apart take the one or the other; what is
slender or flat shows nearly the same tilted to and fro. Each such pose fits to hundredths of a pixel, nothing
in its fit says that there is another, and a target that was followed to the wrong one drifts away with it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from geometry.pose import Pose
from vision_server.pose.refinement import refine
from vision_server.pose.support import support_at
from vision_server.pose.trust import RIVAL_NATS
from vision_server.tracking.following import TURNS, Found, turned_about

Floats = NDArray[np.float64]

# Chosen by hand, on 28 films: of 2000 sure frames within 1 degree and 1 % of the truth 1 % have another pose.
ELSEWHERE = (1.5, 0.01)  # degrees, share of the range: half of what a sure pose may be off ...
BEYOND = 16.8  # ... and in squared units of its covariance: 1 % of a normal is farther
REACHES_PX = (6.0, 3.0)
EXACT = 0.002  # uncertainty, see `Found`: what is known better than 0.2 degrees and 0.2 % was the right one
# Since it was last looked for, which costs half of a frame: how far a sure target has turned, and frames.
TURNED_DEG, MOST_FRAMES = 3.0, 8
KEPT = 5  # looks that find no other pose, until there is none: from some sides the right one hardly shows


class Tilt:
    """Of one followed target."""

    def __init__(self) -> None:
        self._left, self._since = 0, 0
        self._looked: Pose | None = None  # the last pose beside which another one was looked for

    @property
    def is_likely(self) -> bool:
        """Whether another pose explains what was seen, in this frame or some before."""
        return self._left > 0

    def asked(self, found: Found, sure: bool, at_once: bool) -> Found:
        """Look for another pose than one that would be ``sure``, at times, ``at_once``, or if one is likely.

        Returns
        -------
        The pose, with a covariance that allows for the other one if there is one.
        """
        if not sure and not self.is_likely:
            return found
        self._since += 1
        if not (at_once or self.is_likely or self._since >= MOST_FRAMES or self._has_turned(found.pose)):
            return found
        exact = found.uncertainty < EXACT
        other = None if exact else max(_others(found), key=lambda one: one[1], default=None)
        self._left = max(self._left - 1, 0) if other is None else KEPT
        self._since, self._looked = 0, found.pose
        return found if other is None else _allowing(found, *other)

    def _has_turned(self, pose: Pose) -> bool:
        return self._looked is None or pose.error_to(self._looked).rotation_deg > TURNED_DEG


def _others(found: Found) -> Iterator[tuple[Pose, float]]:
    """Poses near the found one that explain its frame as well, or better, and their log odds against it."""
    spacing, precision = found.softness.spacing_px, np.asarray(np.linalg.inv(found.covariance), np.float64)
    for turn in TURNS:
        pose = turned_about(found.pose, found.problem.model.middle, turn)
        for reach in REACHES_PX:
            solution = refine(found.problem, pose, (reach,), spacing)
            if solution is None or not _is_another(solution.pose, found.pose, precision):
                break
            pose = solution.pose
        else:
            support = support_at(found.problem, pose, spacing)
            if support is not None and support.evidence > found.support.evidence - RIVAL_NATS:
                yield pose, (support.evidence - found.support.evidence) / RIVAL_NATS


def _is_another(one: Pose, other: Pose, precision: Floats) -> bool:
    """Whether a pose is elsewhere than another one, of this precision (6, 6)."""
    step = one.step_from(other)
    return not one.error_to(other).within(*ELSEWHERE) and float(step @ precision @ step) > BEYOND


def _allowing(found: Found, other: Pose, log_odds: float) -> Found:
    """The found pose, less exact by what the other one is off from it, by the chance that it is that."""
    step = other.step_from(found.pose)
    covariance = found.covariance + np.outer(step, step) / (1.0 + math.exp(-log_odds))
    return replace(found, fit=replace(found.fit, covariance=covariance))
