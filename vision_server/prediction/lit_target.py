"""A target as its lights show it: Lambert's law, and the shadows that the target casts on itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.faces_in_front import faces_in_front
from geometry.model import Model
from geometry.pose import Pose
from numerics.arrays import Field, Flags, Floats, Ints
from vision_server.prediction.response import lambert, towards_camera
from vision_server.prediction.small_pictures import SMALLER, faces_seen

# Chosen by hand.
SEEN_PX = 320  # across what a light sees of the target: two and more to a pixel of a smaller image
OWN_SURFACE = 0.03  # of the target's diameter: what is so near before a point does not shade it


@dataclass(frozen=True)
class LitTarget:
    """A target at its pose and where its lights stand, (3,) m in the camera's frame, None where not known."""

    model: Model
    camera: Camera
    pose: Pose
    positions: Sequence[Floats | None] = ()

    @cached_property
    def face(self) -> NDArray[np.int32]:
        """What is seen of it, see `faces_seen`."""
        return faces_seen(self.model, self.camera, self.pose)

    @cached_property
    def middles(self) -> Floats:
        """Of its faces, (F, 3) m in the camera's frame."""
        corners = [self.model.vertices[polygon].mean(axis=0) for polygon in self.model.faces]
        return self.pose.apply(np.array(corners).reshape(-1, 3))

    @cached_property
    def normals(self) -> Floats:
        """Of its faces, (F, 3) in the camera's frame, towards it."""
        return towards_camera(self.model.face_normals @ self.pose.matrix.T, self.middles)

    @property
    def located(self) -> Flags:
        """The lights (L,) whose light on it is known: that stand somewhere known, of a model with faces."""
        return np.array([place is not None and bool(self.model.faces) for place in self.positions], np.bool_)

    @cached_property
    def by_each(self) -> list[Field]:
        """A picture (H, W) of it under each located light alone, up to one factor."""
        if not self.located.any():
            return []
        at = np.nonzero(self.face >= 0)
        seen = self.face[at]
        points = self._points(at, seen)
        out = []
        for position in self.positions:
            if position is not None:
                out.append(np.zeros(self.face.shape, dtype=np.float32))
                given = lambert(points, self.normals[seen], position)
                out[-1][at] = given * ~self._shaded(position, points)
        return out

    def under(self, lights: Sequence[Floats]) -> list[Field]:
        """A picture (H, W) of it for each image, under the outputs (L,) that its lights have.

        None at all where a light is not located, or where nothing of it is seen.
        """
        if not len(self.positions) or not self.located.all() or not (self.face >= 0).any():
            return []
        outputs = np.array(lights, dtype=np.float32)
        used = outputs.any(axis=0)
        pictures = np.array(self.by_each)[used]
        return list(np.tensordot(outputs[:, used], pictures / pictures.max(initial=1e-12), axes=1))

    def _points(self, at: tuple[Ints, ...], seen: NDArray[np.int32]) -> Floats:
        """Where the rays of these smaller pixels meet the faces that they see, (N, 3)."""
        pixels = np.asarray((np.stack(at[::-1], axis=1) + 0.5) * SMALLER - 0.5, dtype=np.float64)
        camera, normals = self.camera, self.normals[seen]
        straight = (camera.undistort_points(pixels) - [camera.cx, camera.cy]) / [camera.fx, camera.fy]
        rays = np.column_stack([straight, np.ones(len(straight))])
        away = (normals * self.middles[seen]).sum(axis=1)
        return np.asarray(rays * (away / np.minimum((rays * normals).sum(axis=1), -1e-3))[:, None])

    def _shaded(self, light: Floats, points: Floats) -> Flags:
        """Which points (N, 3) have another part of it before a light (3,): the light's own view is drawn."""
        model, pose = self.model, self.pose
        towards = pose.apply(model.middle[None])[0] - light
        axes = np.linalg.svd(towards[None])[2]  # the first along the view, the others across it
        axes[0] *= np.sign(axes[0] @ towards)
        vertices = (pose.apply(model.vertices) - light) @ axes.T
        if (vertices[:, 0] <= 0.0).any():
            return np.zeros(len(points), dtype=np.bool_)
        across = vertices[:, 1:] / vertices[:, :1]
        low, high = across.min(axis=0), across.max(axis=0)
        scale = (SEEN_PX - 1) / max(float((high - low).max()), 1e-12)
        view = (across - low) * scale
        every = np.ones(len(model.faces), dtype=np.bool_)
        nearest = faces_in_front(
            SEEN_PX, SEEN_PX, view, 1.0 / vertices[:, 0], model.triangles, model.triangle_face, every
        )
        aside = (points - light) @ axes.T
        column, row = np.clip(
            np.rint((aside[:, 1:] / aside[:, :1] - low) * scale).astype(np.int64), 0, SEEN_PX - 1
        ).T
        before = nearest[row, column]
        plane = (self.normals * (self.middles - light)).sum(axis=1)[before]
        met = (self.normals[before] * (points - light)).sum(axis=1)
        share = plane / np.where(np.abs(met) > 1e-12, met, np.inf)  # of the way to the point
        gap = (1.0 - share) * np.linalg.norm(points - light, axis=1)
        return np.asarray((before >= 0) & (share > 0.0) & (gap > OWN_SURFACE * model.diameter))
