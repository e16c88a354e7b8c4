"""What the images say about a pose: offsets of edge points from the model's visible lines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from geometry.visibility import Samples, visible_samples
from vision_server.edge_points import CLIPPED_SD_PX, find_edge_points
from vision_server.gradients import SCALES_PX, GradientChannel
from vision_server.line_votes import choose, vote

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

VOTE_WIDTH_PX = 1.0  # tolerance of a line's vote for a sharp edge
QUALITY_SNR_SHARE = 0.5  # an edge point this many times as strong as its channel's strong ones counts half
BLUR_REACH = 1.5  # search at least this many filter scales to either side
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
    nearest
        (C, N), distance px of the edge point nearest to the model line, chosen or not (NaN: none).
    """

    samples: Samples
    normal: Floats
    along: Floats
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
    nearest: Floats

    def __len__(self) -> int:
        return len(self.normal)


def places_on_lines(samples: Samples) -> Floats:
    """Place of each sample between the ends of its line's visible part, -1 to 1, (N,)."""
    count = len(samples.line)
    along = np.zeros(count)
    if count == 0:
        return along
    starts = np.flatnonzero(np.r_[True, np.diff(samples.line) != 0])
    ends = np.r_[starts[1:], count]
    counts = ends - starts
    direction = np.repeat(samples.image_direction[(starts + ends) // 2], counts, axis=0)
    way = np.sum(samples.image * direction, axis=1)
    low = np.repeat(np.minimum.reduceat(way, starts), counts)
    length = np.repeat(np.maximum.reduceat(way, starts), counts) - low
    more = length > 0
    along[more] = 2.0 * (way[more] - low[more]) / length[more] - 1.0
    return along


def step_jacobian(camera: Camera, points_camera: Floats, normal: Floats, centre: Floats) -> Floats:
    """Motion along the image normal, px, per step (rotation about ``centre`` rad, translation m), (N, 6)."""
    x, y, z = points_camera.T
    if camera.distorted:
        normal = _through_lens(camera, points_camera, normal)
    gx = normal[:, 0] * camera.fx / z
    gy = normal[:, 1] * camera.fy / z
    slope = np.stack([gx, gy, -(gx * x + gy * y) / z], axis=1)
    return np.hstack([np.cross(points_camera - centre, slope), slope])


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
        (C, L), index into SCALES_PX for each channel and line; the channels must be prepared for them.
    spacing_px
        Between the samples of a line.
    """
    samples = visible_samples(model, camera, pose, spacing_px)
    count, lines = len(samples.line), len(model.lines)
    normal = np.stack([-samples.image_direction[:, 1], samples.image_direction[:, 0]], axis=1)
    along = places_on_lines(samples)
    points = pose.apply(samples.points)
    centre = pose.apply(0.5 * (model.vertices.min(axis=0) + model.vertices.max(axis=0))[None])[0]
    sigmas = np.array(SCALES_PX)
    line_sigma = sigmas[scale].max(axis=0) if len(channels) else np.ones(lines)
    reach = np.maximum(reach_px, BLUR_REACH * line_sigma)
    found = [
        find_edge_points(
            channel.gx,
            channel.gy,
            channel.noise,
            channel.near_clipped,
            sigmas,
            scale[index][samples.line],
            samples.image,
            normal,
            reach[samples.line],
        )
        for index, channel in enumerate(channels)
    ]
    offset, snr, sd, strength = (np.stack([part[k] for part in found]) for k in range(4))
    quality = _quality(snr)
    width = VOTE_WIDTH_PX * np.sqrt(line_sigma)
    shift, agreed = np.zeros((lines, 2)), np.zeros(lines)
    chosen = np.empty((len(channels), count), dtype=np.int64)
    vote(
        samples.line, along, offset, quality, lines, float(reach.max(initial=reach_px)), width, shift, agreed
    )
    choose(samples.line, along, offset, shift, width, chosen)
    place, slope = _chosen(offset, chosen, np.nan), _chosen(strength, chosen, 0.0)
    noise = _chosen(sd, chosen, np.inf)
    sigma = sigmas[scale][:, samples.line]
    tone = _tone(channels, samples.image, normal, place, slope, sigma)
    clipped = np.isfinite(noise) & (noise >= CLIPPED_SD_PX * sigma)
    clipping = np.where(clipped, -np.sign(slope) * sigma, 0.0)
    distance = np.abs(offset)
    nearest = np.where(np.isnan(distance), np.inf, distance).min(axis=2)
    nearest[~np.isfinite(nearest)] = np.nan
    return Measurement(
        samples=samples,
        normal=normal,
        along=along,
        jacobian=step_jacobian(camera, points, normal, centre),
        centre=centre,
        scale=scale,
        offset=place,
        sd=noise,
        strength=slope,
        snr=_chosen(snr, chosen, 0.0),
        nuisance=np.stack([tone, clipping], axis=2),
        shift=shift,
        agreed=agreed,
        nearest=nearest,
    )


def _quality(snr: Floats) -> Floats:
    """What an edge point counts in its line's vote, 0..1: strong beats weak, within its own channel."""
    out = np.zeros_like(snr)
    for index, channel in enumerate(snr):
        seen = channel[channel > 0.0]
        if len(seen):
            strong = float(np.percentile(seen, 80))
            out[index] = channel / (channel + QUALITY_SNR_SHARE * strong)
    return out


def _chosen(values: Floats, chosen: Ints, otherwise: float) -> Floats:
    picked = np.take_along_axis(values, np.maximum(chosen, 0)[:, :, None], axis=2)[:, :, 0]
    return np.where(chosen >= 0, picked, otherwise)


def _tone(
    channels: Sequence[GradientChannel],
    image: Floats,
    normal: Floats,
    offset: Floats,
    strength: Floats,
    sigma: Floats,
) -> Floats:
    """Steps relative to the mean of their sides, times the scale, (C, N); see `Measurement.tone`."""
    out = np.zeros_like(offset)
    for index, channel in enumerate(channels):
        seen = np.isfinite(offset[index])
        places = image[seen] + offset[index, seen, None] * normal[seen]
        rows, columns = channel.smooth.shape
        x = np.clip(np.round(places[:, 0]).astype(np.int64), 0, columns - 1)
        y = np.clip(np.round(places[:, 1]).astype(np.int64), 0, rows - 1)
        # the smoothed level at the nearest pixel, carried to the edge along its slope
        towards = (places[:, 0] - x) * normal[seen, 0] + (places[:, 1] - y) * normal[seen, 1]
        level = np.maximum(channel.smooth[y, x] + towards * strength[index, seen], LEAST_LEVEL)
        height = strength[index, seen] * sigma[index, seen] * np.sqrt(2.0 * np.pi)
        out[index, seen] = np.clip(height / level, -MOST_STEP, MOST_STEP) * sigma[index, seen]
    return out
