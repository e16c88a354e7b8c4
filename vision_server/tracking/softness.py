"""How soft a target's lines are, kept from one frame to the next while next to nothing moves."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from numerics.arrays import Flags, Floats, Ints
from vision_server.pose.line_scales import line_scales
from vision_server.pose.observation import PoseProblem
from vision_server.pose.sampling import spacing_for

# No vertex of a still target moves farther. The blur of a shutter that is open all the time over so many
# pixels has a standard deviation of 0.9 px; what is softer than 1.4 px is looked at with a wider filter.
STILL_PX = 3.0
KEPT_FRAMES = 8  # until it is measured again, as focus and light change slowly; chosen by hand


@dataclass(frozen=True, eq=False)
class Softness:
    """Of a target's lines in one frame.

    Attributes
    ----------
    scale : (1, L), see `line_scales`.
    spacing_px : of samples.
    frames : for how many more it may be kept; 0 unless it is `kept`.
    pixels : (V, 2), where the model's vertices were.
    seen : (L,), which lines were visible.
    """

    scale: Ints
    spacing_px: float
    frames: int = 0
    pixels: Floats = field(default_factory=lambda: np.full((1, 2), np.inf))
    seen: Flags = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))

    @classmethod
    def measured(cls, problem: PoseProblem, pose: Pose) -> Softness:
        """Around a pose."""
        return cls(line_scales(problem, pose), spacing_for(problem.model, problem.camera, pose))

    def holds(self, model: Model, camera: Camera, pose: Pose, line: Ints | None = None) -> bool:
        """Whether it is that of the next frame, where the target has this pose and lines (N,) are visible."""
        if self.frames == 0 or (line is not None and not self.seen[line].all()):
            return False
        return self._are_near(camera.project(pose.apply(model.vertices)))

    def kept(self, model: Model, camera: Camera, pose: Pose, line: Ints, before: Softness | None) -> Softness:
        """For the next frame, after one with this pose, of which lines (N,) are visible.

        What was measured while the target moved from where the last frame left it, ``before``, is not kept.
        """
        pixels, frames = camera.project(pose.apply(model.vertices)), self.frames - 1
        if self is not before:
            frames = KEPT_FRAMES if before is not None and before._are_near(pixels) else 0
        seen = np.zeros(len(model.lines), dtype=np.bool_)
        seen[line] = True
        return Softness(self.scale, self.spacing_px, frames, pixels, seen)

    def _are_near(self, pixels: Floats) -> bool:
        return bool(np.abs(pixels - self.pixels).max() < STILL_PX)  # not where one is behind the camera
