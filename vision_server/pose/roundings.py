"""What rounded edges change along a model's lines, and on which side of these a target ends."""

from __future__ import annotations

import math

import numpy as np

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from geometry.roundings import FLAT_FACES, dot, sharp_and_convex, shift_at
from geometry.visibility import Samples
from numerics.arrays import Flags, Floats, Ints
from numerics.kernels import kernel

# Where the edge of a rounded crease is seen: beside one of the two lines in which the faces end, at so much
# of the way from the middle, and its sd; seldom on the middle. Read off two ray-traced films.
TANGENT_SHARE, TANGENT_SD_SHARE, MIDDLE_CHANCE = 0.8, 0.25, 0.1


def roundings(model: Model, camera: Camera, pose: Pose, samples: Samples) -> Floats:
    """How far edges lie along their normals where the model's convex edges are rounded, px per m of radius.

    See `geometry.roundings`.

    Returns
    -------
    (2, N): the shift, and how far a crease may be from there to either side; 0 for lines of open, smooth or
    hollow places.
    """
    return np.asarray(_edges(model, camera, pose, samples)[:2])


def slack_px(model: Model, camera: Camera, pose: Pose, samples: Samples) -> Floats:
    """How far from where samples are, to either side, the rounding of a crease is, (N,) px."""
    if model.edge_radius_m <= 0.0:
        return np.zeros(len(samples.line))
    return np.asarray(model.edge_radius_m * roundings(model, camera, pose, samples)[1])


@kernel()
def onto_roundings(line: Ints, offset: Floats, slack: Floats, start_sd_px: float) -> Floats:
    """Move edges of rounded creases by where on the rounding they seem to be, and say how surely, (N,) px.

    That is one of its ends or its middle: of a mixture of three normals the mean, and what it leaves open.

    Parameters
    ----------
    offset : (C, N), of edge points, px, NaN for none; changed in place.
    slack : (N,), see `slack_px`.
    start_sd_px : how far a line may be from its place by the pose that it is looked at from.
    """
    unsure = np.zeros(len(slack))
    places = np.array([-TANGENT_SHARE, 0.0, TANGENT_SHARE])
    start = 0
    while start < len(line):
        end = start
        while end < len(line) and line[end] == line[start]:
            end += 1
        width = slack[start:end].mean()
        seen = offset[:, start:end].copy().ravel()
        seen = seen[np.isfinite(seen)]
        if width > 0.0 and len(seen) > 0:
            off = (np.median(seen) - width * places) ** 2
            off /= (TANGENT_SD_SHARE * width) ** 2 + start_sd_px**2
            chance = np.exp(-0.5 * (off - off.min()))
            chance *= np.array([1.0 - MIDDLE_CHANCE, 2.0 * MIDDLE_CHANCE, 1.0 - MIDDLE_CHANCE])
            chance /= chance.sum()
            mean = (chance * places).sum()
            share = math.sqrt(TANGENT_SD_SHARE**2 + (chance * places**2).sum() - mean**2)
            offset[:, start:end] -= mean * slack[start:end]
            unsure[start:end] = share * slack[start:end]
        start = end
    return unsure


def outward_of(model: Model, camera: Camera, pose: Pose, samples: Samples) -> Floats:
    """On which side of its line the target ends, (N,): 1 ahead along the normal, -1 behind, 0 of no outline.

    A line between two faces is an outline where one of them is turned away; those of smooth or hollow places
    are left out.
    """
    outward: Floats = _edges(model, camera, pose, samples)[2]
    return outward


def _edges(model: Model, camera: Camera, pose: Pose, samples: Samples) -> Floats:
    """All of `roundings` and `outward_of` at each sample, (3, N)."""
    if not model.faces:
        return np.zeros((3, len(samples.line)))
    normals, faces = model.face_normals @ pose.matrix.T, model.line_faces[samples.line]
    points, along = pose.apply(samples.points), samples.direction @ pose.matrix.T
    focal, rounds = samples.normal * [camera.fx, camera.fy], sharp_and_convex(model)[samples.line]
    return _at_edges(normals[faces[:, 0]], normals[faces[:, 1]], rounds, points, along, focal)


@kernel()
def _at_edges(
    one: Floats, two: Floats, rounds: Flags, points: Floats, along: Floats, focal: Floats
) -> Floats:
    """See `_edges`.

    Parameters
    ----------
    one, two : (N, 3), normals of the two faces beside a sample's line, camera frame.
    rounds : (N,), whether that is a sharp convex edge between them.
    points, along : (N, 3), the sample, m, and the unit vector along its line, camera frame.
    focal : (N, 2), its normal in the image times the focal lengths, px.
    """
    out = np.zeros((3, len(points)))
    for i in range(len(points)):
        n, m, point = one[i], two[i], points[i]
        cosine, facing_n, facing_m = dot(n, m), dot(n, point), dot(m, point)
        both, across = n + m, np.cross(point, along[i])
        if rounds[i] and facing_n * facing_m < 0.0:
            out[2, i] = np.sign(dot(across, both)) * np.sign(_in_image(across, point, focal[i]))
        if not rounds[i] or 1.0 + cosine <= FLAT_FACES:
            continue
        if facing_n < 0.0 and facing_m < 0.0:
            out[1, i] = abs(_in_image(0.5 * (n - m), point, focal[i]))
        shift = shift_at(n, m, point, along[i])
        out[0, i] = _in_image(shift, point, focal[i])
    return out


@kernel()
def _in_image(shift: Floats, point: Floats, focal: Floats) -> float:
    """How far a shift (3,) of a point moves it in the image along the normal that ``focal`` is, px."""
    x, y = shift[0] - shift[2] * point[0] / point[2], shift[1] - shift[2] * point[1] / point[2]
    return float((x * focal[0] + y * focal[1]) / point[2])
