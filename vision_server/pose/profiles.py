"""How much of a line's profile across the edge is an edge, and how much is something else.

An edge is a step between two even sides: its derivative along the normal is a Gaussian. Print that runs
beside it, a bright rim, a shadow's end, other edges within reach add to that, and move its maximum.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from numerics.kernels import kernel
from vision_server.channels.gradients import SCALES_PX, Frame, Tiles
from vision_server.pose.edge_points import Channel, derivative_at
from vision_server.pose.observation import Observation, PoseProblem

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Chosen by hand: how far 1717 lines are off goes with the rest for 3 to 5 steps to either side.
STEPS = 4  # to either side of an edge, each as wide as it is soft,
MOST_STEP_PX = 2.5  # and no wider: gradients are there so far
WIDTHS = np.arange(0.8, 2.45, 0.1)  # sd of an edge's derivative, in steps
ON_COURSE_PX = 0.55  # of its softness: an edge point farther from its line's course is none of it


class Place(NamedTuple):
    """Where M lines are seen, (M, 2) px as in `Courses`, and which in which channel, (M,)."""

    place: Floats
    line: Ints
    channel: Ints


def rest_of_profiles(problem: PoseProblem, seen: Observation, at: Place) -> Floats:
    """Of the square of each line's mean profile the share that is no Gaussian of any width, (M,), 0 to 1."""
    shapes = np.exp(-0.5 * (np.arange(-STEPS, STEPS + 1) / WIDTHS[:, None]) ** 2)
    shapes /= np.linalg.norm(shapes, axis=1)[:, None]
    out = np.ones(len(at.line))
    for c, channel in enumerate(problem.channels):
        _rest(channel.frame, channel.tiles, problem.filters[c], seen, c, at, shapes, out)
    return out


@kernel()
def _rest(
    frame: Frame, tiles: Tiles, scale: Ints, seen: Observation, c: int, at: Place, shapes: Floats, out: Floats
) -> None:
    """The same in one channel; ``scale`` (L,), index into SCALES_PX; ``shapes`` (W, 2 STEPS + 1)."""
    profile = np.empty(shapes.shape[1])
    for m in range(len(at.line)):
        if at.channel[m] == c:
            s, softness = scale[at.line[m]], seen.sigma[c, at.line[m]]
            channel = Channel(tiles.number[s], tiles.gradient[s], tiles.near_clipped[s], SCALES_PX[s])
            _add_up(frame, channel, seen, c, at, m, softness, profile)
            square, like = 0.0, 0.0
            for value in profile:
                square += value * value
            for shape in shapes:
                along = 0.0
                for k in range(len(profile)):
                    along += shape[k] * profile[k]
                like = max(like, along * along)
            out[m] = 1.0 - like / square if square > 0.0 else 1.0


@kernel()
def _add_up(
    frame: Frame, channel: Channel, seen: Observation, c: int, at: Place, m: int, softness: float, out: Floats
) -> None:
    """The sum of the profiles (2 STEPS + 1,) of the m-th line's samples, about its course."""
    (rows, columns), samples = frame.shape, seen.samples
    step = min(softness, MOST_STEP_PX)
    out[:] = 0.0
    for i in range(np.searchsorted(samples.line, at.line[m]), len(samples.line)):
        if samples.line[i] != at.line[m]:
            break
        course = at.place[m, 0] + at.place[m, 1] * seen.along[i]
        if not abs(seen.offset[c, i] - course) < ON_COURSE_PX * softness:
            continue
        nx, ny = -samples.image_direction[i, 1], samples.image_direction[i, 0]
        for k in range(len(out)):
            u = course + (k - STEPS) * step
            x, y = samples.image[i, 0] + u * nx, samples.image[i, 1] + u * ny
            if x >= 0.0 and y >= 0.0 and x < columns - 1 and y < rows - 1:
                out[k] += derivative_at(channel, x, y, nx, ny)
