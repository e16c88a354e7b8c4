"""A target as its lights show it: Lambert's law, and the shadows that the target casts on itself."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.faces_in_front import faces_in_front
from geometry.model import Model
from geometry.pose import Pose
from numerics.arrays import Field, Flags, Floats
from vision_server.prediction.response import lambert, towards_camera
from vision_server.prediction.small_pictures import SMALLER

# Chosen by hand.
SEEN_PX = 320  # across what a light sees of the target: two and more to a pixel of a smaller image
OWN_SURFACE = 0.03  # of the target's diameter: what is so near before a point does not shade it


def lit_pictures(
    model: Model,
    camera: Camera,
    pose: Pose,
    positions: Sequence[Floats | None],
    lights: Sequence[Floats],
    face: NDArray[np.int32],
) -> list[Field]:
    """A picture (H, W) of the target for each image, under the outputs (L,) that its lights have.

    None where a light's position (3,) m, camera frame, is not known, or of a model without faces. ``face`` is
    what is seen of the target, see `faces_seen`.
    """
    known = [position for position in positions if position is not None]
    if not model.faces or not (face >= 0).any() or not known or len(known) < len(positions):
        return []
    lit = np.array(lights)
    used = np.flatnonzero(lit.any(axis=0)).tolist()
    each = lit_by_each(model, camera, pose, [known[light] for light in used], face)
    most = max((float(picture.max()) for picture in each), default=0.0)
    out = np.zeros((len(lit), *face.shape), dtype=np.float32)
    for light, picture in zip(used, each, strict=True):
        out += lit[:, light, None, None].astype(np.float32) * (picture / max(most, 1e-12))
    return list(out)


def lit_by_each(
    model: Model, camera: Camera, pose: Pose, positions: Sequence[Floats], face: NDArray[np.int32]
) -> list[Field]:
    """A picture (H, W) of the target under each light alone, up to one factor; arguments as above."""
    at = np.nonzero(face >= 0)
    middles = pose.apply(np.array([model.vertices[polygon].mean(axis=0) for polygon in model.faces]))
    normals = towards_camera(model.face_normals @ pose.matrix.T, middles)
    seen = face[at]
    pixels = np.asarray((np.stack(at[::-1], axis=1) + 0.5) * SMALLER - 0.5, dtype=np.float64)
    straight = (camera.undistort_points(pixels) - [camera.cx, camera.cy]) / [camera.fx, camera.fy]
    rays = np.column_stack([straight, np.ones(len(straight))])
    depth = (normals * middles).sum(axis=1)[seen] / np.minimum((rays * normals[seen]).sum(axis=1), -1e-3)
    points = rays * depth[:, None]
    out = []
    for position in positions:
        given = lambert(points, normals[seen], position)
        given = given * ~_shaded(model, pose, position, points, middles, normals)
        out.append(np.zeros(face.shape, dtype=np.float32))
        out[-1][at] = given
    return out


def _shaded(
    model: Model, pose: Pose, light: Floats, points: Floats, middles: Floats, normals: Floats
) -> Flags:
    """Which points (N, 3) have another part of the target before a light (3,): its own view is drawn."""
    towards = pose.apply(model.middle[None])[0] - light
    axes = np.linalg.svd(towards[None])[2]  # the first along the view, the others across it
    axes[0] *= np.sign(axes[0] @ towards)
    vertices = (pose.apply(model.vertices) - light) @ axes.T
    if (vertices[:, 0] <= 0.0).any():
        return np.zeros(len(points), dtype=np.bool_)
    across = vertices[:, 1:] / vertices[:, :1]
    low, high = across.min(axis=0), across.max(axis=0)
    scale = (SEEN_PX - 1) / max(float((high - low).max()), 1e-12)
    nearest = faces_in_front(
        SEEN_PX, SEEN_PX, (across - low) * scale, 1.0 / vertices[:, 0], model.triangles, model.triangle_face,
        np.ones(len(model.faces), dtype=np.bool_),
    )  # fmt: skip
    aside = (points - light) @ axes.T
    column, row = np.clip(
        np.rint((aside[:, 1:] / aside[:, :1] - low) * scale).astype(np.int64), 0, SEEN_PX - 1
    ).T
    before = nearest[row, column]
    plane = (normals * (middles - light)).sum(axis=1)[before]
    met = (normals[before] * (points - light)).sum(axis=1)
    share = plane / np.where(np.abs(met) > 1e-12, met, np.inf)  # of the way to the point
    gap = (1.0 - share) * np.linalg.norm(points - light, axis=1)
    return np.asarray((before >= 0) & (share > 0.0) & (gap > OWN_SURFACE * model.diameter))
