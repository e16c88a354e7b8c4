"""From where a target is expected to where it is: a few refinement passes around one pose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from vision_server.channels.depth import Pixels
from vision_server.pose.covariance import uncertainty
from vision_server.pose.line_scales import line_scales
from vision_server.pose.refinement import EXACT_REACH_PX, refine
from vision_server.pose.sampling import spacing_for
from vision_server.pose.support import PoseSupport, support_of
from vision_server.pose.trust import TAILS, belief, quality
from vision_server.tracking.beside import beside_px2
from vision_server.tracking.fitting import Fit, Habits, fitted
from vision_server.tracking.frame import NAME, Tone, problem_of, window

Floats = NDArray[np.float64]

# Chosen by hand where nothing else is said.
NEAR_REACHES_PX = (6.0,)  # where the motion was foreseen
SETTLED_PX = 0.3  # a step that moves no line farther was looked at from near enough
PASSES = 3  # at most, until it has settled
FAR = ((4, (7.0, 5.0)), (2, (5.0,)))  # sizes and reaches there, where it was not: 28 px at full size
MARGIN_PX = 40.0  # of the window around the target: these 28 px, and the filters' reach


@dataclass(frozen=True, eq=False)
class Found:
    """A pose that a frame was refined to, and what the frame says of it."""

    fit: Fit
    support: PoseSupport

    @property
    def pose(self) -> Pose:
        """camera_T_target."""
        return self.fit.pose

    @property
    def covariance(self) -> Floats:
        """(6, 6), of a left-multiplied step."""
        return self.fit.covariance

    @cached_property
    def quality(self) -> float:
        """Of the support."""
        return quality(self.support)

    @cached_property
    def uncertainty(self) -> float:
        """Largest standard deviation, 0.01 of 1 % of the range or 1 degree; it has its tails already."""
        return uncertainty(self.covariance, self.pose.translation)

    def belief(self, ambiguity: float) -> float:
        """Probability that this is where the target is, however exactly, see `trust.belief`."""
        return belief(self.support, ambiguity, self.uncertainty / TAILS)


@dataclass(frozen=True, eq=False)
class Sight:
    """What looks at frames: model, camera and tone curve."""

    model: Model
    camera: Camera
    tone: Tone

    def near(self, pixels: Pixels, expected: Pose, habits: Habits) -> Found | None:
        """The pose a few pixels around the one expected; None where nothing holds it."""
        seen = window(pixels, self.model, self.camera, expected, MARGIN_PX)
        if seen is None:
            return None
        problem = problem_of(seen, self.model, self.tone)
        problem = replace(problem, scale=line_scales(problem, expected))
        spacing = spacing_for(self.model, seen.camera, expected)
        first = refine(problem, expected, NEAR_REACHES_PX, spacing)
        if first is None:
            return None
        fit, pose, beside = None, first.pose, beside_px2(problem, first.pose)
        for _ in range(PASSES):
            fit = fitted(problem, pose, EXACT_REACH_PX, spacing, habits, beside)
            if fit is None:
                return None
            pose = fit.pose
            if fit.moved_px < SETTLED_PX:
                break
        return None if fit is None else Found(fit, support_of(fit.observation, [NAME]))

    def far(self, pixels: Pixels, expected: Sequence[Pose], habits: Habits) -> list[Found]:
        """The same some 30 px around each of the poses, by way of smaller pictures; best first."""
        found = []
        for start in expected:
            seen, pose = window(pixels, self.model, self.camera, start, MARGIN_PX), start
            if seen is None:
                continue
            for factor, reaches in FAR:
                solution = refine(problem_of(seen.smaller(factor), self.model, self.tone), pose, reaches)
                if solution is None:
                    break
                pose = solution.pose
            if (one := self.near(pixels, pose, habits)) is not None:
                found.append(one)
        return sorted(found, key=lambda one: -one.quality)
