"""Edge points from whole profiles: the place of a blurred step between two plain sides.

The maximum of a smoothed gradient heeds a few pixels and is hardly moved by what lies beside an edge. Where
both sides are plain for some pixels, the place where the profile crosses its middle is known better. So the
profile of each line in each channel is fitted with a step H Phi((d - u) / b) on a level A; A, H and the place
u change linearly along the line, b is the blur. The pixels themselves are fitted, with no filter before.
A line is placed so only when its pixels agree that it is such a step, and lines are placed at all only when
nearly all of the target is so plain. Beside texture, edges are off by more than their noise, and the few
lines that pass would count too much.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from numerics.kernels import kernel
from vision_server.channels.gradients import SCALES_PX, GradientChannel
from vision_server.pose.association import ends_of_lines
from vision_server.pose.observation import Measurement
from vision_server.pose.step_fit import FIT, SLOPES, fit_step, profile_row

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Field = NDArray[np.float32]

SOFTEST = 1  # index into SCALES_PX; softer edges reach too far for plain sides
NEAR, WIDE = 4.0, 12.0  # to either side of a line, times the filter's scale: the edge, and its plain sides
GUARD = 2.5  # pixels nearer to another line are left out, times the filter's scale
LEAST_SIDE = 2.5  # free of other lines, times the filter's scale, for a sample to be used
STEP_PX = 0.5  # in which a sample's normal is followed
LEAST_NOISE_GREY = 0.3
FIRST_BLUR = 0.8  # times the filter's scale
SOFTEST_SHARE = 0.45  # of the distance that is kept from other lines, for an edge's blur
FEWEST_SAMPLES = 4
FEWEST_PIXELS = 40
MOST_MISFIT = 1.5  # mean squared residual over the noise
FARTHEST_PX = 1.0  # of a line from where the pose has it
# By slopes across the sides, by wider sides, or away from the gradient's maximum a line may move so far ...
MOST_MOVED_PX = 0.03
MOST_MOVED_SD = 2.0  # ... and this many standard deviations of the noise of that
PLAIN_SHARE = 0.8  # of the length with edge points, in all channels together, that must be placed so


@kernel(error_model="numpy")
def _to_segment(px: float, py: float, ax: float, ay: float, bx: float, by: float) -> float:
    """Distance of a point p from the segment from a to b, px."""
    x, y = bx - ax, by - ay
    square = x * x + y * y
    share = ((px - ax) * x + (py - ay) * y) / square if square > 0.0 else 0.0
    share = min(1.0, max(0.0, share))
    x, y = px - ax - share * x, py - ay - share * y
    return math.sqrt(x * x + y * y)


@kernel(error_model="numpy")
def free_sides(
    line: Ints, image: Floats, normal: Floats, from_end: Floats, reach: Floats, guard: Floats
) -> Floats:
    """How far along its normal each sample sees no other line, to the left and to the right, (N, 2) px.

    Parameters
    ----------
    line, image, normal
        As in `Samples`; from_end (N,) px as in `Measurement`.
    reach, guard
        (L,) px for each line: the most, and what other lines and the line's own ends keep clear of.
    """
    ends = ends_of_lines(line, len(reach))
    out = np.zeros((len(line), 2))
    for i in range(len(line)):
        mine = line[i]
        clear = guard[mine]
        if from_end[i] < clear:
            continue
        out[i, 0] = out[i, 1] = reach[mine]
        x, y, nx, ny = image[i, 0], image[i, 1], normal[i, 0], normal[i, 1]
        for other in range(len(reach)):
            first, last = ends[other, 0], ends[other, 1]
            if other == mine or first < 0:
                continue
            ax, ay, bx, by = image[first, 0], image[first, 1], image[last, 0], image[last, 1]
            distance = _to_segment(x, y, ax, ay, bx, by)
            nearest = max(0.0, STEP_PX * math.floor((distance - clear) / STEP_PX))  # what may be too near
            for side in range(2):
                sign = 2.0 * side - 1.0
                away = nearest
                while away <= out[i, side]:
                    if _to_segment(x + sign * away * nx, y + sign * away * ny, ax, ay, bx, by) < clear:
                        out[i, side] = away - STEP_PX
                        break
                    away += STEP_PX
    return out


@kernel(error_model="numpy")
def _gathered(
    start: int,
    end: int,
    image: Floats,
    normal: Floats,
    px: Floats,
    along: Floats,
    free: Floats,
    least: float,
    linear: Field,
    noise: Field,
    clipped: NDArray[np.uint8],
    owner: Ints,
    place: Floats,
    share: Floats,
    value: Floats,
    variance: Floats,
) -> int:
    """Pixels beside the samples start to end - 1 of one line; five outputs (M,), and how many there are.

    Each pixel belongs to the sample nearest along the line: ``owner``; ``place`` is its signed distance from
    the line, px, ``share`` how far along the line it is, -1 to 1, as ``along``.
    """
    rows, columns = linear.shape
    found = 0
    for i in range(start, end):
        left, right = free[i, 0], free[i, 1]
        if min(left, right) < least:
            continue
        nx, ny = normal[i, 0], normal[i, 1]
        ux, uy = ny, -nx
        half = 0.5 * px[i]
        slope = 0.0  # of ``along``, per px
        other = i + 1 if i + 1 < end else i - 1
        apart = (image[other, 0] - image[i, 0]) * ux + (image[other, 1] - image[i, 1]) * uy
        if apart != 0.0:
            slope = (along[other] - along[i]) / apart
        extent_x = abs(nx) * max(left, right) + abs(ux) * half
        extent_y = abs(ny) * max(left, right) + abs(uy) * half
        low_x, high_x = math.ceil(image[i, 0] - extent_x), math.floor(image[i, 0] + extent_x)
        low_y, high_y = math.ceil(image[i, 1] - extent_y), math.floor(image[i, 1] + extent_y)
        if low_x < 0 or low_y < 0 or high_x >= columns or high_y >= rows:
            continue
        before = found
        for y in range(low_y, high_y + 1):
            for x in range(low_x, high_x + 1):
                dx, dy = x - image[i, 0], y - image[i, 1]
                at, away = dx * ux + dy * uy, dx * nx + dy * ny
                if not (-half <= at < half and -left <= away <= right):
                    continue
                if clipped[y, x] != 0:
                    found = -1
                    break
                if found == len(owner):
                    return found
                owner[found], place[found], share[found] = i, away, along[i] + slope * at
                value[found], variance[found] = linear[y, x], noise[y, x] * noise[y, x]
                found += 1
            if found < 0:
                break
        if found < 0:  # a sample beside saturated pixels
            found = before
    return found


@kernel(error_model="numpy")
def _even_variance(place: Floats, variance: Floats) -> None:
    """Give each side the mean variance of its pixels: one that follows the pixel's own noise would bias."""
    for side in range(2):
        total, count = 0.0, 0
        for k in range(len(place)):
            if (place[k] > 0.0) == (side == 1):
                total += variance[k]
                count += 1
        mean = max(total / max(count, 1), LEAST_NOISE_GREY**2)
        for k in range(len(place)):
            if (place[k] > 0.0) == (side == 1):
                variance[k] = mean


@kernel(error_model="numpy")
def _nearest_first(
    near: float, owner: Ints, place: Floats, share: Floats, value: Floats, variance: Floats
) -> int:
    """Bring the pixels not farther than ``near`` from the line to the front; how many these are."""
    front = 0
    for k in range(len(place)):
        if abs(place[k]) <= near:
            owner[front], owner[k] = owner[k], owner[front]
            place[front], place[k] = place[k], place[front]
            share[front], share[k] = share[k], share[front]
            value[front], value[k] = value[k], value[front]
            variance[front], variance[k] = variance[k], variance[front]
            front += 1
    return front


@kernel(error_model="numpy")
def _place_lines(
    line: Ints,
    image: Floats,
    normal: Floats,
    px: Floats,
    along: Floats,
    free: Floats,
    sigma: Floats,
    linear: Field,
    noise: Field,
    clipped: NDArray[np.uint8],
    peak: Floats,
    peak_sd: Floats,
    offset: Floats,
    sd: Floats,
    common: Floats,
    bearable_px: float,
) -> float:
    """Place one channel's lines that are blurred steps, see `placed_by_profiles`; sigma (L,), 0: not this.

    Offset, sd and common (N,) are outputs and stay as they are for other samples. Returns what is left of
    ``bearable_px``, the length with edge points that need not be placed; it stops once nothing is left.
    """
    count = len(line)
    fit, inverse, row = np.empty(FIT), np.empty((FIT, FIT)), np.empty(SLOPES)
    pull, weight = np.empty(count), np.empty(count)
    start = 0
    while start < count:
        end, room, seen, placed = start, 0, 0.0, False
        while end < count and line[end] == line[start]:
            if not np.isnan(peak[end]):
                seen += px[end]
            room += int((px[end] + 2.0) * (free[end].sum() + 2.0))
            end += 1
        scale = sigma[line[start]]
        found = near = 0
        if scale > 0.0 and seen > 0.0 and end - start >= FEWEST_SAMPLES:
            owner, place, share = np.empty(room, np.int64), np.empty(room), np.empty(room)
            value, variance = np.empty(room), np.empty(room)
            found = _gathered(
                start,
                end,
                image,
                normal,
                px,
                along,
                free,
                LEAST_SIDE * scale,
                linear,
                noise,
                clipped,
                owner,
                place,
                share,
                value,
                variance,
            )
            owner, place, share = owner[:found], place[:found], share[:found]
            value, variance = value[:found], variance[:found]
            near = _nearest_first(NEAR * scale, owner, place, share, value, variance)
            _even_variance(place, variance)
        before, before_variance = np.nan, 0.0
        for used in (near, found):
            if near < FEWEST_PIXELS:
                break
            misfit, shifted, spread = fit_step(
                place[:used],
                share[:used],
                value[:used],
                variance[:used],
                near,
                FIRST_BLUR * scale,
                fit,
                inverse,
            )
            most = MOST_MOVED_PX * scale
            if not (misfit < MOST_MISFIT and abs(shifted) < most + MOST_MOVED_SD * spread):
                break
            if fit[6] > SOFTEST_SHARE * GUARD * scale or abs(fit[4]) + abs(fit[5]) > FARTHEST_PX * scale:
                break
            spread = math.sqrt(max(before_variance - inverse[4, 4], 0.0))
            if abs(fit[4] - before) > most + MOST_MOVED_SD * spread:
                break
            before, before_variance = fit[4], inverse[4, 4]
            pull[start:end], weight[start:end] = 0.0, 0.0
            for k in range(near):
                left = value[k] - profile_row(place[k], share[k], fit, row)
                pull[owner[k]] += row[4] * left / variance[k]
                weight[owner[k]] += row[4] * row[4] / variance[k]
            total, moved, samples, whole = 0.0, 0.0, 0, 0.0
            for i in range(start, end):
                if not weight[i] > 0.0:
                    continue
                samples += 1
                whole += weight[i]
                away = peak[i] - fit[4] - along[i] * fit[5]
                if abs(away) < FARTHEST_PX * scale:
                    total += peak_sd[i] ** -2.0
                    moved += away * peak_sd[i] ** -2.0
            if samples < FEWEST_SAMPLES or not total > 0.0:
                break
            if abs(moved / total) > most + MOST_MOVED_SD / math.sqrt(total):
                break
            placed = True
            shared = math.sqrt(max(inverse[4, 4] - 1.0 / whole, 0.0))
            for i in range(start, end):
                if weight[i] > 0.0:
                    offset[i] = fit[4] + along[i] * fit[5] + pull[i] / weight[i]
                    sd[i] = 1.0 / math.sqrt(weight[i])
                    common[i] = shared
        if not placed:
            bearable_px -= seen
            if bearable_px < 0.0:
                break
        start = end
    return bearable_px


def _crowded(measurement: Measurement, free: Floats, lines: int) -> NDArray[np.bool_]:
    """Edge points (C, N) of lines that are too soft, or have others too near, to be placed by profiles.

    ``free`` (N,) is the narrower of a sample's two sides, px. No fit is needed to tell that.
    """
    line = measurement.samples.line
    scale = measurement.scale[:, line]
    usable = (scale <= SOFTEST) & (free >= LEAST_SIDE * np.array(SCALES_PX)[scale])
    counts = np.stack([np.bincount(line[of_channel], minlength=lines) for of_channel in usable])
    return np.asarray(counts[:, line] < FEWEST_SAMPLES, dtype=np.bool_)


def placed_by_profiles(
    measurement: Measurement, channels: Sequence[GradientChannel], lines: int
) -> Measurement | None:
    """The measurement with its edge points placed by their lines' profiles; None for a target not so plain.

    `Measurement.common` tells which edge points were placed so.
    """
    samples = measurement.samples
    sigmas = np.array(SCALES_PX)
    offset, sd = measurement.offset.copy(), measurement.sd.copy()
    common = np.full_like(offset, np.nan)
    softest = np.minimum(measurement.scale.max(axis=0, initial=0), SOFTEST)
    reach, guard = WIDE * sigmas[softest], GUARD * sigmas[softest]
    free = free_sides(samples.line, samples.image, measurement.normal, measurement.from_end, reach, guard)
    seen_px = np.where(np.isfinite(measurement.offset), samples.px, 0.0)
    bearable_px = (1.0 - PLAIN_SHARE) * float(seen_px.sum())
    if float(seen_px[_crowded(measurement, free.min(axis=1), lines)].sum()) > bearable_px:
        return None
    for c, channel in enumerate(channels):
        scale = measurement.scale[c]
        bearable_px = _place_lines(
            samples.line,
            samples.image,
            measurement.normal,
            samples.px,
            measurement.along,
            free,
            np.where(scale <= SOFTEST, sigmas[scale], 0.0),
            channel.linear,
            channel.noise,
            channel.clipped,
            measurement.offset[c],
            measurement.sd[c],
            offset[c],
            sd[c],
            common[c],
            bearable_px,
        )
        if bearable_px < 0.0:
            return None
    return replace(measurement, offset=offset, sd=sd, common=common)
