"""Refinement: robust least squares of a pose on sub-pixel edge points along the model's visible lines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from geometry.visibility import visible_samples
from vision_server.edge_points import find_edge_points
from vision_server.gradients import SCALES_PX, GradientChannel
from vision_server.measurement import Measurement, measure

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

REACHES_PX = (6.0, 4.0, 3.0, 3.0)
SOLVER_ITERATIONS = 5  # of reweighting, on the edge points of one measurement
MOST_SAMPLES = 900
SYSTEMATIC_SD_PX = 0.12  # of one edge point: pixel grid, texture and shading beside the edge
TUKEY = 4.685  # 95 % efficient on Gaussian residuals
LEAST_SCALE_PX = 0.12
STRONG_PERCENTILE = 70.0
SCATTER_PX = 0.35  # scatter about its own straight line at which a line counts half
SOFTER_RATIO = 0.70  # peak at twice the scale over peak at the scale: above this the edge is the softer one
FEWEST_POINTS = 8
# Shift of an edge per unit of the first nuisance: what is left of a known tone curve; of a nominal one (0.19
# was
# seen on sRGB read as linear); and per unit of the second: clipping by the sensor.
KNOWN_TONE_SD_PX = 0.01
NOMINAL_TONE_SD_PX = 0.15
CLIPPING_SD_PX = 0.8
SAMPLES_TOGETHER = 10.0  # neighbouring edge points that are worth one, when weighed against a prior
PRIOR_ROTATION_SD_RAD = 0.3
PRIOR_TRANSLATION_SD = 0.1  # of the range
ENOUGH_ROWS = 12


@dataclass(frozen=True, eq=False)
class Solution:
    """A refined pose and the least-squares problem it solves.

    Attributes
    ----------
    pose
        camera_T_target.
    measurement
        Taken at ``pose``.
    weight
        (C, N), final weights, 1/px^2.
    nuisance
        (2,), estimated factors of the measurement's ``nuisance``, px.
    tone_sd_px
        What was assumed of the first of them.
    """

    pose: Pose
    measurement: Measurement
    weight: Floats
    nuisance: Floats
    tone_sd_px: float


def spacing_for(model: Model, camera: Camera, pose: Pose) -> float:
    """Spacing of samples, px, that keeps a large or intricate target within MOST_SAMPLES."""
    length = float(visible_samples(model, camera, pose, 4.0).px.sum())
    return max(1.0, length / MOST_SAMPLES)


def line_scales(
    channels: Sequence[GradientChannel],
    model: Model,
    camera: Camera,
    pose: Pose,
    reach_px: float,
    least: int = 0,
) -> Ints:
    """Filter scale that suits the blur of each line in each channel, (C, L), indices into SCALES_PX.

    An edge of blur b answers a Gaussian derivative of scale s with a peak proportional to (b^2 + s^2)^-1/2;
    the
    ratio of the peaks at 2s and s therefore tells b/s, whatever the contrast.
    """
    samples = visible_samples(model, camera, pose, 2.0)
    normal = np.stack([-samples.image_direction[:, 1], samples.image_direction[:, 0]], axis=1)
    lines = len(model.lines)
    out = np.full((len(channels), lines), least, dtype=np.int64)
    reach = np.empty(len(normal))
    for index, channel in enumerate(channels):
        peaks = []
        for scale in range(least, len(SCALES_PX)):
            channel.prepare(scale + 1)
            reach[:] = max(reach_px, 1.5 * SCALES_PX[scale])
            chosen = np.full(len(normal), scale, dtype=np.int64)
            _, _, _, strength = find_edge_points(
                channel.gx,
                channel.gy,
                channel.noise,
                channel.near_clipped,
                np.array(SCALES_PX),
                chosen,
                samples.image,
                normal,
                reach,
            )
            peaks.append(np.abs(strength).max(axis=1))
            if scale == least:
                continue
            ratio = _median_ratios(peaks[-1], peaks[-2], samples.line, lines)
            softer = (out[index] == scale - 1) & (ratio > SOFTER_RATIO)
            out[index, softer] = scale
            if not softer.any():
                break
    return out


def _median_ratios(upper: Floats, lower: Floats, line: Ints, lines: int) -> Floats:
    """Median of upper / lower for each line; where lower sees too little but upper does not: 1, else 0."""
    out = np.zeros(lines)
    for index in np.unique(line).tolist():
        of_line = line == index
        a, b = upper[of_line], lower[of_line]
        both = (a > 0) & (b > 0)
        if both.sum() >= FEWEST_POINTS:
            out[index] = float(np.median(a[both] / b[both]))
        if (b > 0).sum() < 0.25 * (a > 0).sum():
            out[index] = 1.0
    return out


def line_trust(measurement: Measurement, lines: int) -> Floats:
    """How straight and complete the edge points of each channel are along each line, 0..1, (C, L).

    Texture beside a crease that has no contrast in one light, shadow edges and clutter give edge points that
    are few, or that scatter about any straight line.
    """
    out = np.zeros((len(measurement.offset), lines))
    _trust(measurement.samples.line, measurement.along, measurement.offset, SCATTER_PX, out)
    return out


@njit(cache=True)
def _trust(line: Ints, along: Floats, offset: Floats, scatter_px: float, out: Floats) -> None:
    """share^2 / (1 + (scatter / scatter_px)^2) for each channel and line; ``line`` is ascending."""
    channels, count = offset.shape
    x, y = np.empty(count), np.empty(count)
    start = 0
    while start < count:
        end = start
        while end < count and line[end] == line[start]:
            end += 1
        for c in range(channels):
            seen = 0
            for i in range(start, end):
                if not np.isnan(offset[c, i]):
                    x[seen], y[seen] = along[i], offset[c, i]
                    seen += 1
            if seen >= 3:
                share = seen / (end - start)
                ratio = _scatter(x[:seen], y[:seen]) / scatter_px
                out[c, line[start]] = share * share / (1.0 + ratio * ratio)
        start = end


@njit(cache=True)
def _scatter(x: Floats, y: Floats) -> float:
    """Robust scatter of y about its straight line over x, px: twice reweighted, median absolute residual."""
    residual = y - np.median(y)
    weight = np.ones(len(x))
    for _ in range(2):
        total = weight.sum()
        mean_x, mean_y = (weight * x).sum() / total, (weight * y).sum() / total
        spread = (weight * (x - mean_x) ** 2).sum()
        slope = (weight * (x - mean_x) * (y - mean_y)).sum() / spread if spread > 1e-9 else 0.0
        residual = y - mean_y - slope * (x - mean_x)
        weight = 1.0 / (1.0 + (residual / 0.5) ** 2)
    return float(1.4826 * np.median(np.abs(residual)))


def base_weights(measurement: Measurement, lines: int) -> Floats:
    """Weight of each edge point before its residual is known, (C, N), 1/px^2."""
    trust = line_trust(measurement, lines)
    sigma = np.array(SCALES_PX)[measurement.scale]
    systematic = SYSTEMATIC_SD_PX * sigma[:, measurement.samples.line]
    out = np.zeros_like(measurement.offset)
    for c in range(len(out)):
        seen = np.isfinite(measurement.offset[c])
        if not seen.any():
            continue
        strength = np.abs(measurement.strength[c, seen])
        strong = max(float(np.percentile(strength, STRONG_PERCENTILE)), 1e-12)
        variance = measurement.sd[c, seen] ** 2 + systematic[c, seen] ** 2
        out[c, seen] = (
            np.minimum(1.0, strength / strong) * trust[c, measurement.samples.line[seen]] / variance
        )
    return out * measurement.samples.px


def prior_precision(range_m: float, tone_sd_px: float) -> Floats:
    """Diagonal (8,) of the prior on rotation (rad), translation (m), tone and clipping shifts (px)."""
    pose = np.r_[np.full(3, PRIOR_ROTATION_SD_RAD), np.full(3, PRIOR_TRANSLATION_SD * range_m)]
    sd = np.r_[pose, tone_sd_px, CLIPPING_SD_PX]
    return np.asarray(sd**-2.0)


def solve(measurement: Measurement, base: Floats, range_m: float, tone_sd_px: float) -> tuple[Floats, Floats]:
    """The step that brings the lines onto their edge points, by iteratively reweighted least squares.

    A tone curve that was not undone moves each edge towards its dark side, by an amount proportional to its
    relative height, and so does clipping by the sensor (`Measurement.nuisance`); both factors are estimated
    along
    with the pose.

    Returns
    -------
    step (8,), rotation rad about the measurement's centre, translation m, nuisance px; weights (C, N),
    1/px^2.
    """
    used = base > 0
    channel, sample = np.nonzero(used)
    rows = np.column_stack([measurement.jacobian[sample], measurement.nuisance[used]])
    offset, start = measurement.offset[used], base[used]
    prior = SAMPLES_TOGETHER * np.diag(prior_precision(range_m, tone_sd_px))
    step: Floats = np.zeros(8)
    weight: Floats = start
    for iteration in range(SOLVER_ITERATIONS):
        if iteration > 0:
            residual = np.abs(offset - rows @ step)
            spread = max(LEAST_SCALE_PX, 1.4826 * _weighted_median(residual, start))
            weight = start * np.maximum(0.0, 1.0 - (residual / (TUKEY * spread)) ** 2) ** 2
        scaled = rows * weight[:, None]
        step = np.asarray(np.linalg.solve(scaled.T @ rows + prior, scaled.T @ offset), dtype=np.float64)
    out = np.zeros_like(base)
    out[channel, sample] = weight
    return step, out


def _weighted_median(values: Floats, weights: Floats) -> float:
    if len(values) == 0:
        return 0.0
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order[np.searchsorted(total, 0.5 * total[-1])]])


def moved(pose: Pose, step: Floats, centre: Floats) -> Pose:
    """The pose after a step that turns about ``centre`` (camera frame)."""
    turned = Pose(np.zeros(3), -centre)
    return (
        Pose(np.zeros(3), centre + step[3:6])
        .compose(Pose(step[:3], np.zeros(3)))
        .compose(turned)
        .compose(pose)
    )


def refine(
    channels: Sequence[GradientChannel],
    model: Model,
    camera: Camera,
    start: Pose,
    scale: Ints,
    reaches_px: Sequence[float] = REACHES_PX,
    tone_sd_px: float = KNOWN_TONE_SD_PX,
    coarser: float = 1.0,
) -> Solution | None:
    """Refine one candidate pose on all channels together.

    At each reach the edge points are looked for anew, visibility included, and the pose is solved for; each
    channel counts where it sees edges, by the noise of each of them, their strength and straightness.

    Parameters
    ----------
    scale
        (C, L), from `line_scales`.
    reaches_px
        How far along the normals to look, one after the other.
    tone_sd_px
        How far edges may be off by a tone curve that is still in the images.
    coarser
        Factor on the spacing of samples.

    Returns
    -------
    The refined pose, or None when there is nothing to hold on to: the model is out of sight, or fewer than
    ENOUGH_ROWS edge points are near it.
    """
    pose = start
    spacing = coarser * spacing_for(model, camera, pose)
    solution = None
    for reach in reaches_px:
        measurement = measure(channels, model, camera, pose, reach, scale, spacing)
        base = base_weights(measurement, len(model.lines))
        if int((base > 0).sum()) < ENOUGH_ROWS:
            return None
        step, weight = solve(measurement, base, float(np.linalg.norm(pose.translation)), tone_sd_px)
        if not np.isfinite(step).all():
            return None
        pose = moved(pose, step, measurement.centre)
        if not pose.apply(model.vertices)[:, 2].max() > 0:
            return None
        solution = Solution(pose, measurement, weight, step[6:], tone_sd_px)
    return solution
