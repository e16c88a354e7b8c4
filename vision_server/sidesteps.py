"""Start poses beside a pose, for rivals that no small step leads to.

Printed lines, shadow edges and double outlines run beside true edges, and a fit that took one of them for a
model line can be nearly as good as the truth. A motion that the lines hardly hold can hide another one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from geometry.visibility import Samples, visible_samples
from vision_server.edge_points import find_edge_points
from vision_server.gradients import SCALES_PX, GradientChannel
from vision_server.line_votes import vote
from vision_server.measurement import Measurement, places_on_lines
from vision_server.refinement import moved, prior_precision

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

REACH_PX = 24.0  # how far beside a line another edge is looked for
APART_PX = 1.5  # an edge closer than this to the line is the line's own
TOLERANCE_PX = 1.5
LEAST_AGREED = 0.35  # share of a line's samples that must lie on the other edge
EDGES_A_LINE = 4
SPACING_PX = 3.0
LAID_WEIGHT = 4.0  # of a sample of the line that is laid elsewhere, against the others' median
LOOSENED_PX = 5.0  # how far the farthest sample goes along a motion that is hardly held


def laid_beside(
    channels: Sequence[GradientChannel],
    model: Model,
    camera: Camera,
    pose: Pose,
    measurement: Measurement,
    base: Floats,
    most: int,
) -> list[Pose]:
    """The pose with one of its lines laid on another straight edge that runs along it.

    Parameters
    ----------
    measurement
        Taken at ``pose``; ``base`` its weights, (C, N), 1/px^2.
    most
        Poses to return; those with the clearest edges come first.
    """
    found = _edges_beside(channels, model, camera, pose, measurement.scale)
    found.sort(key=lambda edge: -edge[0])
    return [_laid(pose, measurement, base, line, shift) for _, line, shift in found[:most]]


def loosened(pose: Pose, measurement: Measurement, base: Floats, motions: int) -> list[Pose]:
    """The pose a step away along each of the motions that its lines hold least, to either side.

    Parameters as in `laid_beside`; twice as many poses as ``motions``, the loosest first.
    """
    rows, prior, units = measurement.jacobian, _prior(pose), _units(pose)
    normal = (rows * base.sum(axis=0)[:, None]).T @ rows + prior
    _, loosest_first = np.linalg.eigh(normal * np.outer(units, units))
    out = []
    for motion in loosest_first.T[:motions]:
        step = motion * units
        step *= LOOSENED_PX / np.abs(rows @ step).max()
        out += [moved(pose, step, measurement.centre), moved(pose, -step, measurement.centre)]
    return out


def _units(pose: Pose) -> Floats:
    """Radians and ranges: what makes turning comparable with moving."""
    return np.asarray(np.r_[np.ones(3), np.full(3, np.linalg.norm(pose.translation))])


def _prior(pose: Pose) -> Floats:
    return np.asarray(np.diag(prior_precision(float(np.linalg.norm(pose.translation)), 1.0)[:6]))


def _edges_beside(
    channels: Sequence[GradientChannel], model: Model, camera: Camera, pose: Pose, scale: Ints
) -> list[tuple[float, int, Floats]]:
    """Straight edges that run along visible lines, as (clearness, line, shift (2,) px as in `vote`)."""
    samples = visible_samples(model, camera, pose, SPACING_PX)
    along, _ = places_on_lines(samples.line, samples.image, samples.image_direction, 2.0 * SPACING_PX)
    lines = len(model.lines)
    counts = np.maximum(np.bincount(samples.line, minlength=lines), 1)
    length = np.bincount(samples.line, weights=samples.px, minlength=lines)
    width = np.full(lines, TOLERANCE_PX)
    out = []
    for index, channel in enumerate(channels):
        offset = _offsets_beside(channel, samples, scale[index][samples.line])
        for _ in range(EDGES_A_LINE):
            shift, agreed = np.zeros((lines, 2)), np.zeros(lines)
            counted = np.isfinite(offset).astype(np.float64)
            vote(samples.line, along, offset[None], counted[None], lines, REACH_PX, width, shift, agreed)
            expected = shift[samples.line, 0] + shift[samples.line, 1] * along
            near = np.abs(offset - expected[:, None]) < 2.0 * TOLERANCE_PX
            share = np.bincount(samples.line, weights=near.any(axis=1), minlength=lines) / counts
            for line in np.flatnonzero(share >= LEAST_AGREED).tolist():
                out.append((float(share[line] * np.sqrt(length[line])), line, shift[line]))
            offset[near] = np.nan
    return out


def _offsets_beside(channel: GradientChannel, samples: Samples, scale: Ints) -> Floats:
    """Edge points to either side of the samples, (N, 2 * PEAKS) px along the normal, NaN for none."""
    normal = samples.normal
    middle, reach = 0.5 * (REACH_PX + APART_PX), np.full(len(normal), 0.5 * (REACH_PX - APART_PX))
    sides = []
    for side in (-middle, middle):
        offset, *_ = find_edge_points(
            channel.gx,
            channel.gy,
            channel.noise,
            channel.near_clipped,
            np.array(SCALES_PX),
            scale,
            samples.image + side * normal,
            normal,
            reach,
        )
        sides.append(offset + side)
    return np.concatenate(sides, axis=1)


def _laid(pose: Pose, measurement: Measurement, base: Floats, line: int, shift: Floats) -> Pose:
    """The pose with one line on its other edge, and the others as near to their edges as that allows."""
    weight = base.sum(axis=0)
    offset = np.where(base > 0.0, measurement.offset, 0.0)
    target = (base * offset).sum(axis=0) / np.maximum(weight, 1e-12)
    of_line = measurement.samples.line == line
    target[of_line] = shift[0] + shift[1] * measurement.along[of_line]
    weight[of_line] = LAID_WEIGHT * (np.median(weight[weight > 0.0]) if weight.any() else 1.0)
    rows = measurement.jacobian
    scaled = rows * weight[:, None]
    step = np.linalg.solve(scaled.T @ rows + _prior(pose), scaled.T @ target)
    return moved(pose, step, measurement.centre)
