"""What the images say about a pose: offsets of edge points from the model's visible lines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from geometry.visibility import Samples, visible_samples
from numerics.kernels import kernel
from vision_server.channels.gradients import SCALES_PX, GradientChannel
from vision_server.pose.association import leave_to_owners, pulls_of_neighbours
from vision_server.pose.edge_points import CLIPPED_SD_PX
from vision_server.pose.edge_search import search
from vision_server.pose.hough import choose, vote

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

VOTE_WIDTH_PX = 1.0  # tolerance of a line's vote for a sharp edge
STRONG_SHARE = 0.8  # of the edge points of a channel are weaker than its strong ones
QUALITY_SNR_SHARE = 0.5  # an edge point this many times as strong as its channel's strong ones counts half
BLUR_REACH = 1.5  # search at least this many filter scales to either side
GAP_SPACINGS = 2.0  # between samples that are no neighbours
SMALL_STEP_PX = 0.5  # for the derivative of the lens distortion
MOST_STEP = 2.0  # a step from black, over the mean of its two sides
LEAST_LEVEL = 2.0  # grey, under which that ratio is noise


@dataclass(frozen=True, eq=False)
class Measurement:
    """Edge points near the visible lines of a model at one pose; N samples, C channels, L model lines.

    Attributes
    ----------
    samples
        Points on the visible lines.
    normal
        (N, 2), unit normals of the lines in the image.
    along
        (N,), place of a sample on its line's visible part, -1 to 1.
    from_end
        (N,), distance of a sample from the nearest end of a visible part of its line, px.
    jacobian
        (N, 6), change of the line's place along the normal, px, per (rotation rad about ``centre``,
        translation m).
    centre
        (3,), camera frame, metres: the turning point of the steps.
    scale
        (C, L), index into SCALES_PX used for each channel and line.
    offset, sd, strength, snr
        (C, N), of the chosen edge point: place along the normal px (NaN: none), its noise px, signed
        derivative
        grey/px, and that over its noise.
    nuisance
        (C, N, 2), what moves edges but not the pose, up to a factor each: a tone curve that was not undone
        (signed
        height of the step over the mean of its sides), and clipping (towards the dark side; 0 for edges away
        from
        saturated pixels); both times the filter's scale.
    shift
        (L, 2), each line's voted edge; agreed (L,), the votes it got.
    neighbours
        (C, N), how far lines beside this one may move its edge, px, signed.
    nearest
        (C, N), distance px of the edge point nearest to the model line, chosen or not (NaN: none).
    """

    samples: Samples
    normal: Floats
    along: Floats
    from_end: Floats
    jacobian: Floats
    centre: Floats
    scale: Ints
    offset: Floats
    sd: Floats
    strength: Floats
    snr: Floats
    nuisance: Floats
    shift: Floats
    agreed: Floats
    neighbours: Floats
    nearest: Floats

    def __len__(self) -> int:
        return len(self.normal)


@kernel(error_model="numpy")
def places_on_lines(line: Ints, image: Floats, direction: Floats, gap_px: float) -> tuple[Floats, Floats]:
    """Where each sample is on its line, and how far from where the line or a visible part of it ends.

    Parameters
    ----------
    line
        (N,) ascending; image and direction (N, 2), as in `Samples`.
    gap_px
        Neighbours that are farther apart have something in between that hides the line.

    Returns
    -------
    along (N,), between the ends of all visible parts, -1 to 1; distance (N,) to the nearest end, px.
    """
    count = len(line)
    along, distance = np.zeros(count), np.zeros(count)
    start = 0
    while start < count:
        end = start
        while end < count and line[end] == line[start]:
            end += 1
        ux, uy = direction[(start + end) // 2, 0], direction[(start + end) // 2, 1]
        low, high, part = np.inf, -np.inf, start
        for i in range(start, end):
            along[i] = image[i, 0] * ux + image[i, 1] * uy
            low, high = min(low, along[i]), max(high, along[i])
            if i + 1 == end or abs(image[i + 1, 0] * ux + image[i + 1, 1] * uy - along[i]) > gap_px:
                for k in range(part, i + 1):
                    distance[k] = min(abs(along[k] - along[part]), abs(along[k] - along[i])) + 0.25 * gap_px
                part = i + 1
        for i in range(start, end):
            along[i] = 2.0 * (along[i] - low) / (high - low) - 1.0 if high > low else 0.0
        start = end
    return along, distance


def turning_point(model: Model, pose: Pose) -> Floats:
    """The middle of the target, (3,), camera frame, metres: what steps turn about."""
    return np.asarray(pose.apply(model.middle[None])[0])


def step_jacobian(camera: Camera, points_camera: Floats, normal: Floats, centre: Floats) -> Floats:
    """Motion along the image normal, px, per step (rotation about ``centre`` rad, translation m), (N, 6)."""
    if camera.distorted:
        normal = _through_lens(camera, points_camera, normal)
    out: Floats = _pinhole_jacobian(camera.fx, camera.fy, points_camera, normal, centre)
    return out


@kernel(error_model="numpy")
def _pinhole_jacobian(fx: float, fy: float, points: Floats, normal: Floats, centre: Floats) -> Floats:
    out = np.empty((len(points), 6))
    for i in range(len(points)):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        gx, gy = normal[i, 0] * fx / z, normal[i, 1] * fy / z
        gz = -(gx * x + gy * y) / z
        x, y, z = x - centre[0], y - centre[1], z - centre[2]
        out[i, 0], out[i, 1], out[i, 2] = y * gz - z * gy, z * gx - x * gz, x * gy - y * gx
        out[i, 3], out[i, 4], out[i, 5] = gx, gy, gz
    return out


def _through_lens(camera: Camera, points: Floats, normal: Floats) -> Floats:
    """Normals times the derivative of distorted by ideal pixels, (N, 2)."""
    columns = []
    for axis, focal in ((0, camera.fx), (1, camera.fy)):
        step = np.zeros_like(points)
        step[:, axis] = SMALL_STEP_PX * points[:, 2] / focal
        moved = camera.project(points + step) - camera.project(points - step)
        columns.append(np.sum(normal * moved, axis=1) / (2.0 * SMALL_STEP_PX))
    return np.stack(columns, axis=1)


def measure(
    channels: Sequence[GradientChannel],
    model: Model,
    camera: Camera,
    pose: Pose,
    reach_px: float,
    scale: Ints,
    spacing_px: float,
) -> Measurement:
    """Look for edge points along the normals of the model's visible lines.

    Parameters
    ----------
    reach_px
        How far to look to either side; more where the scale of the filter asks for it.
    scale
        (C, L), index into SCALES_PX for each channel and line.
    spacing_px
        Between the samples of a line.
    """
    samples = visible_samples(model, camera, pose, spacing_px)
    count, lines = len(samples.line), len(model.lines)
    normal = samples.normal
    along, from_end = places_on_lines(
        samples.line, samples.image, samples.image_direction, GAP_SPACINGS * spacing_px
    )
    centre = turning_point(model, pose)
    sigmas = np.array(SCALES_PX)
    line_sigma = sigmas[scale].max(axis=0) if len(channels) else np.ones(lines)
    reach = np.maximum(reach_px, BLUR_REACH * line_sigma)
    offset, snr, sd, strength = search(
        channels, np.take(scale, samples.line, axis=1), samples.image, normal, reach[samples.line]
    )
    leave_to_owners(samples.line, samples.image, samples.image_direction, normal, lines, offset)
    width = VOTE_WIDTH_PX * np.sqrt(line_sigma)
    shift, agreed = np.zeros((lines, 2)), np.zeros(lines)
    chosen = np.empty((len(channels), count), dtype=np.int64)
    farthest = float(reach.max(initial=reach_px))
    vote(samples.line, along, offset, _quality(snr), lines, farthest, width, shift, agreed)
    choose(samples.line, along, offset, shift, width, chosen)
    places = [np.empty((len(channels), count)) for _ in range(5)]
    nuisance = np.empty((len(channels), count, 2))
    for c, channel in enumerate(channels):
        _take_chosen(
            chosen[c],
            offset[c],
            sd[c],
            strength[c],
            snr[c],
            channel.smooth,
            sigmas[scale[c]][samples.line],
            samples.image,
            normal,
            places[0][c],
            places[1][c],
            places[2][c],
            places[3][c],
            places[4][c],
            nuisance[c],
        )
    return Measurement(
        samples=samples,
        normal=normal,
        along=along,
        from_end=from_end,
        jacobian=step_jacobian(camera, pose.apply(samples.points), normal, centre),
        centre=centre,
        scale=scale,
        offset=places[0],
        sd=places[1],
        strength=places[2],
        snr=places[3],
        nuisance=nuisance,
        shift=shift,
        agreed=agreed,
        neighbours=pulls_of_neighbours(
            samples.line, samples.image, samples.image_direction, normal, lines, sigmas[scale]
        ),
        nearest=places[4],
    )


@kernel(error_model="numpy")
def _quality(snr: Floats) -> Floats:
    """What each edge point counts in its line's vote, 0..1: strong beats weak, within its own channel."""
    channels, count, peaks = snr.shape
    out = np.zeros_like(snr)
    seen = np.empty(count * peaks)
    for c in range(channels):
        found = 0
        for i in range(count):
            for k in range(peaks):
                if snr[c, i, k] > 0.0:
                    seen[found] = snr[c, i, k]
                    found += 1
        if found == 0:
            continue
        rank = int(STRONG_SHARE * (found - 1))
        strong = QUALITY_SNR_SHARE * np.partition(seen[:found], rank)[rank]
        for i in range(count):
            for k in range(peaks):
                out[c, i, k] = snr[c, i, k] / (snr[c, i, k] + strong)
    return out


@kernel(error_model="numpy")
def _take_chosen(
    chosen: Ints,
    offset: Floats,
    sd: Floats,
    strength: Floats,
    snr: Floats,
    smooth: NDArray[np.float32],
    sigma: Floats,
    image: Floats,
    normal: Floats,
    place: Floats,
    noise: Floats,
    slope: Floats,
    ratio: Floats,
    nearest: Floats,
    nuisance: Floats,
) -> None:
    """One channel's chosen edge points (N, PEAKS) to (N,), with what they may be off by; six outputs.

    The tone curve moves an edge in proportion to the step's height over the mean of its sides, times the
    scale; clipping moves it towards its dark side.
    """
    rows, columns = smooth.shape
    for i in range(len(chosen)):
        nearest[i] = np.nan
        for k in range(offset.shape[1]):
            if not abs(offset[i, k]) >= nearest[i]:
                nearest[i] = abs(offset[i, k])
        k = chosen[i]
        place[i], noise[i], slope[i], ratio[i] = np.nan, np.inf, 0.0, 0.0
        nuisance[i, 0] = nuisance[i, 1] = 0.0
        if k < 0:
            continue
        place[i], noise[i], slope[i], ratio[i] = offset[i, k], sd[i, k], strength[i, k], snr[i, k]
        x, y = image[i, 0] + place[i] * normal[i, 0], image[i, 1] + place[i] * normal[i, 1]
        column = min(max(int(x + 0.5), 0), columns - 1)
        row = min(max(int(y + 0.5), 0), rows - 1)
        # the smoothed level at the nearest pixel, carried to the edge along its slope
        towards = (x - column) * normal[i, 0] + (y - row) * normal[i, 1]
        level = max(smooth[row, column] + towards * slope[i], LEAST_LEVEL)
        step = slope[i] * sigma[i] * math.sqrt(2.0 * math.pi) / level
        nuisance[i, 0] = min(max(step, -MOST_STEP), MOST_STEP) * sigma[i]
        if noise[i] >= CLIPPED_SD_PX * sigma[i]:
            nuisance[i, 1] = -sigma[i] if slope[i] > 0.0 else sigma[i]
