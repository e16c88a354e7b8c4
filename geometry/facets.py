"""How far the rims and outlines of a round part lie outside of the mesh that stands for it.

The facets of a round part are chords, up to a sagitta inside of it: half a percent of the radius with 32
facets a turn. By how much neighbouring facets are bent against each other tells how far.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from geometry.chains import followers, joined
from geometry.model import Model
from geometry.pose import Pose
from geometry.visibility import Samples
from numerics.arrays import Flags, Floats, Ints

# Chosen by hand.
MOST_BEND_RAD = math.radians(29.9)  # of thirteen facets a turn; twelve make corners, see `mesh.SHARP_DEG`
ALIKE = 2.5  # facets of one curve are as long, and bent as much, as the next ones, up to such a factor
IN_ONE_PLANE = math.cos(math.radians(0.02))
LEAST_BEND_RAD = 1e-4  # less is the rounding of coordinates
TINY = 1e-300


class Roundness(NamedTuple):
    """What L lines' facets stand for.

    Attributes
    ----------
    rise : (L, 3), from the middle of a sharp line to the curve whose chord it is, m; 0 of straight ones.
    radius : (L,), of the smooth surface's bend across a line, m; 0 where the line is of none.
    most : (L,), how far that surface's outline can be outside of the line, m.
    normal : (L, 3), of that surface.
    """

    rise: Floats
    radius: Floats
    most: Floats
    normal: Floats


def beyond_mesh(model: Model, pose: Pose, samples: Samples) -> Floats | None:
    """How far the rims and outlines that the facets stand for lie outside of the mesh.

    Returns
    -------
    (N, 3), from each sample, target frame, m; None where the model has no round part.
    """
    of = roundness_of(model)
    if of is None:
        return None
    line = samples.own
    start, end = (model.vertices[model.lines[line, k]] for k in range(2))
    step, aside = end - start, samples.points - start
    at = np.clip((step * aside).sum(axis=1) / (step**2).sum(axis=1), 0.0, 1.0)
    sight = samples.points + pose.matrix.T @ pose.translation  # from the camera
    # Seen along the line, a surface of radius r that is turned by d against the line of sight has its outline
    # r d^2 / 2 farther out.
    across = (sight**2).sum(axis=1) - (step * sight).sum(axis=1) ** 2 / (step**2).sum(axis=1)
    turned = (of.normal[line] * sight).sum(axis=1) ** 2 / np.maximum(across, TINY)
    outside = np.minimum(0.5 * of.radius[line] * turned, of.most[line])
    return np.asarray((4.0 * at * (1.0 - at))[:, None] * of.rise[line] + outside[:, None] * of.normal[line])


@lru_cache(maxsize=8)
def roundness_of(model: Model) -> Roundness | None:
    """What a model's facets stand for, or None where it has no round part; shared, not to be written to."""
    found = Roundness(_rise_of_rims(model), *_of_surfaces(model))
    return found if found.rise.any() or found.radius.any() else None


def _rise_of_rims(model: Model) -> Floats:
    """The rise (L, 3) of sharp lines that follow each other along a curve of three bends or more to one side.

    An arc that bends by b is b / 8 of its length away from the middle of its chord. The last line of a curve
    goes on as it bends at its other end.
    """
    step = model.vertices[model.lines[:, 1]] - model.vertices[model.lines[:, 0]]
    length = np.linalg.norm(step, axis=1)
    along = step / length[:, None]
    met, turns = _bends_at_ends(model, along, length)
    sizes = np.linalg.norm(turns, axis=2)
    same_side = (turns[:, 0] * turns[:, 1]).sum(axis=1) > 0.5 * sizes.prod(axis=1)
    between: Flags = (met >= 0).all(axis=1) & same_side & (sizes.min(axis=1) > LEAST_BEND_RAD)
    curved: Flags = between & between[met].any(axis=1)
    last = np.asarray((met < 0).any(axis=1))
    counts = (met >= 0) & (curved[:, None] | (curved[met] & last[:, None]))
    bend = (turns * counts[:, :, None]).sum(axis=1) / np.maximum(counts.sum(axis=1), 1)[:, None]
    bend -= (bend * along).sum(axis=1)[:, None] * along
    return np.asarray(-0.125 * length[:, None] * bend)


def _bends_at_ends(model: Model, along: Floats, length: Floats) -> tuple[Ints, Floats]:
    """At both ends of lines, the line (L, 2) that goes on there, or -1, and the turn (L, 2, 3) towards it.

    The turn is the difference of the two unit vectors. A corner, or a line of quite another length, does not
    go on.
    """
    met, turns = np.full((len(along), 2), -1), np.zeros((len(along), 2, 3))
    pairs = followers(model)
    one, other = np.concatenate([pairs, pairs[:, ::-1]]).T
    meeting = model.lines[one][:, :, None] == model.lines[other][:, None, :]
    ratio = length[one] / length[other]
    good = (meeting.sum(axis=(1, 2)) == 1) & (ratio <= ALIKE) & (ratio >= 1.0 / ALIKE)
    one, other, meeting = one[good], other[good], meeting[good]
    side, far = meeting.any(axis=2).argmax(axis=1), meeting.any(axis=1).argmax(axis=1)
    own, onward = along[one] * (2.0 * side - 1.0)[:, None], along[other] * (1.0 - 2.0 * far)[:, None]
    curved = (own * onward).sum(axis=1) >= math.cos(MOST_BEND_RAD)
    met[one[curved], side[curved]] = other[curved]
    turns[one[curved], side[curved]] = (onward - own)[curved]
    return met, turns


def _of_surfaces(model: Model) -> tuple[Floats, Floats, Floats]:
    """Radius (L,), most (L,) and normal (L, 3), see `Roundness`, of lines between a smooth surface's facets.

    A line counts where the surface goes on bending on both of its sides. Facets in one plane are one.
    """
    count = len(model.lines)
    radius, most, normals = np.zeros(count), np.zeros(count), np.zeros((count, 3))
    of = np.flatnonzero(model.smooth & (model.line_faces.min(axis=1, initial=0) >= 0))
    if not len(of):
        return radius, most, normals
    patch, centroids = _patches(model)
    beside = patch[model.line_faces[of]]
    start = model.vertices[model.lines[of, 0]]
    along = model.vertices[model.lines[of, 1]] - start
    along /= np.linalg.norm(along, axis=1)[:, None]
    aside = centroids[beside] - start[:, None]  # (K, 2, 3), from the line into the facets
    aside -= (aside @ along[:, :, None]) * along[:, None]
    width = np.maximum(np.linalg.norm(aside, axis=2), TINY)  # half a facet's
    outwards = -(aside / width[:, :, None]).sum(axis=1)
    size = np.maximum(np.linalg.norm(outwards, axis=1), TINY)
    bend = 2.0 * np.arcsin(np.minimum(0.5 * size, 1.0))
    known = (bend > LEAST_BEND_RAD) & (bend < MOST_BEND_RAD) & (width.max(axis=1) < ALIKE * width.min(axis=1))
    known &= beside[:, 0] != beside[:, 1]
    normal = outwards / size[:, None]
    outer = (normal * model.face_normals[model.line_faces[of, 0]]).sum(axis=1) > 0.0
    known &= _goes_on(2 * beside + outer[:, None], np.where(known, bend, np.inf)).all(axis=1)
    lines, bend = of[known], bend[known]
    radius[lines] = 0.5 * width[known].sum(axis=1) / np.sin(0.5 * bend)
    most[lines], normals[lines] = 0.125 * radius[lines] * bend**2, normal[known]
    return radius, most, normals


def _goes_on(facet: Ints, bend: Floats) -> Flags:
    """Whether each facet (K, 2) beside a line has another line that is bent alike, by ``bend`` (K,)."""
    of, size = facet.ravel(), np.repeat(bend, 2)
    order = np.lexsort((size, of))
    alike = (np.diff(of[order]) == 0) & (size[order[1:]] <= ALIKE * size[order[:-1]])
    alike &= np.isfinite(size[order[1:]])
    found = np.zeros(len(of), dtype=bool)
    found[order[1:]] |= alike
    found[order[:-1]] |= alike
    return found.reshape(-1, 2)


def _patches(model: Model) -> tuple[Ints, Floats]:
    """The patch (F,) of facets in one plane that each face is of, and the patches' centroids (F, 3)."""
    corners = model.triangles
    sides = np.sort(corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    number = sides[:, 0] * len(model.vertices) + sides[:, 1]
    face = np.repeat(model.triangle_face, 3)
    order = np.argsort(number, kind="stable")
    same = np.flatnonzero(np.diff(number[order]) == 0)
    pairs = np.stack([face[order[same]], face[order[same + 1]]], axis=1)
    cosine = np.abs(model.face_normals[pairs].prod(axis=1).sum(axis=1))
    patch = joined(len(model.faces), pairs[cosine > IN_ONE_PLANE])
    a, b, c = (model.vertices[corners[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    of, count = patch[model.triangle_face], len(model.faces)
    weight = np.maximum(np.bincount(of, area, count), TINY)
    middle = (a + b + c) / 3.0
    return patch, np.stack([np.bincount(of, area * middle[:, k], count) / weight for k in range(3)], axis=1)
