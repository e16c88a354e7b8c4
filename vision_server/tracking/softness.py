"""How soft a target's lines are, kept from one frame to the next while it moves as it did."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from numerics.arrays import Flags, Floats, Ints
from vision_server.pose.line_scales import line_scales
from vision_server.pose.observation import PoseProblem
from vision_server.pose.sampling import spacing_for

# From one frame to the next a vertex moves by so much more or less than when it was measured, at most. The
# blur of a shutter that is open all the time over so many pixels has a standard deviation of 0.9 px; what is
# softer than 1.4 px is looked at with a wider filter.
STEADY_PX = 3.0
KNOWN_SHARE = 0.8  # of the samples, on lines that were measured (by hand); others are as soft as half of them
KEPT_FRAMES = 8  # until it is measured again, as focus and light change slowly; chosen by hand


@dataclass(frozen=True, eq=False)
class Softness:
    """Of a target's lines in one frame.

    Attributes
    ----------
    scale : (1, L), see `line_scales`.
    spacing_px : of samples.
    frames : for how many more it may be kept; 0 unless it is `kept`.
    seen : (L,), which lines were visible in the frame in which it was measured.
    pixels : (V, 2), where the model's vertices were in the last frame.
    first, step : (V, 2), the same in that frame, and how far they had moved since the one before it.
    """

    scale: Ints
    spacing_px: float
    frames: int = 0
    seen: Flags = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))
    pixels: Floats = field(default_factory=lambda: np.full((1, 2), np.inf))
    first: Floats = field(default_factory=lambda: np.full((1, 2), np.inf))
    step: Floats = field(default_factory=lambda: np.full((1, 2), np.inf))

    @classmethod
    def measured(cls, problem: PoseProblem, pose: Pose) -> Softness:
        """Around a pose."""
        return cls(line_scales(problem, pose), spacing_for(problem.model, problem.camera, pose))

    def holds(self, model: Model, camera: Camera, pose: Pose, line: Ints | None = None) -> bool:
        """Whether it is that of the next frame, where the target has this pose and lines (N,) are visible."""
        if self.frames == 0 or (line is not None and self.seen[line].mean() < KNOWN_SHARE):
            return False
        return self._is_steady(camera.project(pose.apply(model.vertices)))

    def kept(self, model: Model, camera: Camera, pose: Pose, line: Ints, before: Softness | None) -> Softness:
        """For the next frame, after one with this pose, of which lines (N,) are visible.

        What was measured in this frame is kept if the last one left it where the target was ``before``.
        """
        pixels = camera.project(pose.apply(model.vertices))
        if self is before:
            return replace(self, frames=self.frames - 1, pixels=pixels)
        seen = np.zeros(len(model.lines), dtype=np.bool_)
        seen[line] = True
        if before is None:
            return replace(self, frames=0, seen=seen, pixels=pixels)
        step = pixels - before.pixels
        return replace(self, frames=KEPT_FRAMES, seen=seen, pixels=pixels, first=pixels, step=step)

    @cached_property
    def _shape(self) -> tuple[Floats, float, float]:
        """When it was measured: vertices from their middle, how far at most, and the longest step, px."""
        shape = _from_middle(self.first)
        return shape, _longest(shape), _longest(self.step)

    def _is_steady(self, pixels: Floats) -> bool:
        """Whether the vertices have moved as they did, and lines have not turned against the way they go."""
        shape, radius_px, step_px = self._shape
        across_px = step_px * _longest(_from_middle(pixels) - shape) / radius_px
        more_px = np.abs(pixels - self.pixels - self.step).max()
        return bool(more_px < STEADY_PX and across_px < STEADY_PX)  # not where one is behind the camera


def _from_middle(pixels: Floats) -> Floats:
    return np.asarray(pixels - pixels.mean(axis=0))


def _longest(vectors: Floats) -> float:
    return math.sqrt((vectors**2).sum(axis=1).max())
