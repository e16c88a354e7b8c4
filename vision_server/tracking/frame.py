"""One frame as tracking sees it: what is around the target, full, half or quarter size, a `PoseProblem`."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from bridge.errors import BadInput
from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from numerics.arrays import Field, Floats
from vision_server.channels.depth import PIXEL_TYPES, Pixels, deepened, linear_table
from vision_server.channels.gradients import Frame, GradientChannel, Picture
from vision_server.channels.noise import grey_noise
from vision_server.pose.observation import PoseProblem

LEAST_WINDOW_PX = 24  # side of a window that is looked at (by hand)
PREPARED_AROUND_PX = 8.0  # around the pixels that a look needs, which the next looks need, too
FRAME_NAME = "frame"  # of the one channel that tracking looks at


@dataclass(frozen=True, eq=False)
class Window:
    """Part of a frame, and the camera that would have taken just this."""

    pixels: Pixels
    camera: Camera

    def smaller(self, factor: int) -> Window:
        """The same at 1/factor of its size, each pixel the mean of those it covers."""
        height, width = (side - side % factor for side in self.pixels.shape)
        whole = self.pixels[:height, :width]
        shape = (width // factor, height // factor)
        pixels = np.asarray(cv2.resize(whole, shape, interpolation=cv2.INTER_AREA), dtype=self.pixels.dtype)
        return Window(pixels, self.camera.part((0, 0, width, height)).scaled(1.0 / factor))


def check_size(pixels: Pixels, camera: Camera, number: int) -> None:
    """Refuse a frame that the camera did not take.

    Raises
    ------
    BadInput : another size or type.
    """
    if pixels.dtype not in PIXEL_TYPES or pixels.shape != (camera.height, camera.width):
        shape = f"{'x'.join(map(str, pixels.shape[1::-1]))} px of {pixels.dtype}"
        raise BadInput(
            f"Frame {number} has {shape}, the camera {camera.width}x{camera.height}.",
            "Give grey frames of the camera's size.",
        )


def window(pixels: Pixels, model: Model, camera: Camera, pose: Pose, margin_px: float) -> Window | None:
    """The part of a frame (H, W) around a target at a pose; None where it is out of sight."""
    points = pose.apply(model.vertices)
    seen = camera.project(points[points[:, 2] > 0.0])
    if len(seen) < len(points):  # partly behind the camera: it may be anywhere
        return Window(pixels, camera)
    low = np.maximum(np.floor(seen.min(axis=0) - margin_px), 0).astype(int)
    high = np.minimum(np.ceil(seen.max(axis=0) + margin_px) + 1, [camera.width, camera.height]).astype(int)
    if min(high - low) < LEAST_WINDOW_PX:
        return None
    left, top, right, bottom = map(int, np.concatenate([low, high]))
    part = np.ascontiguousarray(pixels[top:bottom, left:right])
    return Window(part, camera.part((left, top, right, bottom)))


def problem_of(seen: Window, model: Model, tone: Tone) -> PoseProblem:
    """What a pose is refined on in a window, all lines taken for sharp."""
    pixels = seen.pixels
    noise = (grey_noise(pixels) * tone.slope).astype(np.float32)
    level = deepened(pixels) if pixels.dtype == np.float32 else pixels
    picture, frame = Picture(pixels, tone.gamma, tone.linear), Frame.of(pixels.shape, level, noise)
    channel = GradientChannel(FRAME_NAME, picture, frame, PREPARED_AROUND_PX)
    return PoseProblem.at_scale([channel], model, seen.camera, 0, tone.sd_px)


@dataclass(frozen=True, eq=False)
class Tone:
    """The tone curve of the frames.

    Attributes
    ----------
    gamma : linear = grey^gamma.
    sd_px : how well it is known, see refinement.
    linear, slope : (256,) float32, linear intensity of each grey, 0..255; float64, how it grows with grey.
    """

    gamma: float
    sd_px: float
    linear: Field
    slope: Floats

    @classmethod
    def of(cls, gamma: float, sd_px: float) -> Tone:
        """From the exponent."""
        linear = linear_table(gamma).astype(np.float32)
        return cls(gamma, sd_px, linear, np.gradient(linear.astype(np.float64)))
