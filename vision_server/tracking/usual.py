"""What frames of a light usually show of a target: lamps that switch do not all show the same lines."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

import numpy as np

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from numerics.arrays import Flags, Floats
from vision_server.channels.depth import Pixels
from vision_server.tracking.acceptance import keeps
from vision_server.trust.probability import quality
from vision_server.trust.support import PoseSupport

# By hand, of the quality that is usual in its light: a frame with less than the first share is looked at
# again, one with less than the second is not believed.
AS_BEFORE_QUALITY, LIKE_BEFORE_QUALITY = 0.5, 0.25
LATEST_FRAME_SHARE = 0.1  # of the latest frame in what is usual: it is that of some ten frames (by hand)
REMEMBERED_FRAMES = 8  # believed frames that are remembered, of whose lights one may be this frame's
# A frame is in light like another one's if its faces are off from that one's, squared, by less than the first
# share of what they are off from the last one's; the motion changes them by less than the second share.
ALIKE_LIGHT, NOTICED_LIGHT = 0.3, 0.08


class Seen(NamedTuple):
    """A frame that was believed."""

    faces: Floats  # (F,), brightness of the model's faces, NaN where they are out of sight
    quality: float  # that frames in its light have
    whole: Flags | None  # (L,), lines that were seen whole; None where it was not sure


class Usual:
    """Of one target; a frame's light is told by how bright the faces are."""

    def __init__(self, model: Model, camera: Camera) -> None:
        self._model, self._camera = model, camera
        self._middles = np.array([model.vertices[face].mean(axis=0) for face in model.faces]).reshape(-1, 3)
        self._last: deque[Seen] = deque(maxlen=REMEMBERED_FRAMES)
        self._doubted: list[Seen] = []
        self._faces = np.full(len(self._middles), np.nan)
        self._ago = 1  # which of the last is in light like this frame's

    @property
    def quality(self) -> float:
        """Of believed frames in light like this frame's; 0 before any."""
        return self._last[-self._ago].quality if self._last else 0.0

    @property
    def whole(self) -> Flags | None:
        """Lines (L,) that the last believed frame in light like this one's showed whole, if that was sure."""
        return self._last[-self._ago].whole if self._last else None

    def shows(self, support: PoseSupport) -> bool:
        """Whether a frame shows what those of its light do, so that it needs no look farther around."""
        kept = self.whole is None or keeps(support, self.whole)
        return kept and quality(support) >= AS_BEFORE_QUALITY * self.quality

    def is_like_before(self, quality: float) -> bool:
        """Whether a pose of this quality may be the target, as other frames in this light show it."""
        return quality >= LIKE_BEFORE_QUALITY * self.quality

    @property
    def is_other(self) -> bool:
        """Whether frames before were doubted, for their quality alone, in light unlike this one's."""
        if not self._doubted or not self._last:
            return False
        off = _apart(self._faces, self._last[-self._ago].faces)
        return all(self._is_nearer(off, _apart(self._faces, one.faces)) for one in self._doubted)

    def meets(self, pixels: Pixels, pose: Pose) -> None:
        """A new frame (H, W), in which the target is about here."""
        self._faces, self._ago = self._brightness(pixels, pose), 1
        before = _apart(self._faces, self._last[-1].faces) if self._last else 0.0
        if self._is_nearer(0.0, before):  # not the light of the last frame, perhaps
            off = [_apart(self._faces, one.faces) for one in self._last]
            nearest = int(np.argmin(off))
            self._ago = len(off) - nearest if self._is_nearer(off[nearest], before) else 1

    def believed(self, quality: float, whole: Flags | None) -> None:
        """That the target was seen so well in this frame; what was doubted for less was right then."""
        before = self.quality if self._last else quality
        usual = quality + (before - quality) * (1.0 - LATEST_FRAME_SHARE) ** self._ago
        self._last.extend(self._doubted)
        self._last.append(Seen(self._faces, usual, whole))
        self._doubted, self._ago = [], 1

    def doubted(self, quality: float) -> None:
        """That nothing but its ``quality`` speaks against this frame."""
        self._doubted.append(Seen(self._faces, quality, None))

    def forget_doubts(self) -> None:
        """That more speaks against this frame, and against those before that were doubted."""
        self._doubted = []

    def _is_nearer(self, off: float, before: float) -> bool:
        """Whether faces are off from those of one frame by clearly less than from those of the one before."""
        seen = self._faces[np.isfinite(self._faces)]
        return len(seen) > 0 and off < ALIKE_LIGHT * (before - (NOTICED_LIGHT * float(seen.mean())) ** 2)

    def _brightness(self, pixels: Pixels, pose: Pose) -> Floats:
        """Grey in the middles of faces that are turned to the camera, (F,)."""
        points, found = pose.apply(self._middles), np.full(len(self._middles), np.nan)
        facing = ((self._model.face_normals @ pose.matrix.T) * points).sum(axis=1) < 0.0
        seen = np.flatnonzero(facing & (points[:, 2] > 0.0))
        column, row = np.rint(self._camera.project(points[seen])).astype(int).T
        inside = (column >= 0) & (column < pixels.shape[1]) & (row >= 0) & (row < pixels.shape[0])
        found[seen[inside]] = pixels[row[inside], column[inside]]
        return found


def _apart(one: Floats, other: Floats) -> float:
    """Mean squared difference of two brightnesses of faces (F,); infinite where no face is in both."""
    off = one - other
    off = off[np.isfinite(off)]
    return float(off @ off) / len(off) if len(off) else np.inf
