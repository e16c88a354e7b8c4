"""How much of a line's profile across its edge is an edge, and how far what is beside it has moved it.

An edge is a step between two even sides: its derivative along the normal is a Gaussian. Print that runs
beside it, a bright rim, a shadow's end, other edges within reach add to that, and move its maximum.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from numerics.arrays import Flags, Floats, Ints
from numerics.kernels import kernel
from vision_server.channels.gradients import SCALES_PX, Frame, Normals, Tiles
from vision_server.pose.edge_points import Channel, derivative_at
from vision_server.pose.observation import Observation, PoseProblem
from vision_server.pose.outline_profiles import REACH_STEPS, Optics, outlines_of

# Chosen by hand: how far 1717 lines are off goes with the rest for 3 to 5 steps to either side.
PROFILE_STEPS = 4  # to either side of an edge, each as wide as it is soft,
MOST_STEP_PX = 2.5  # and no wider: hardly more of the image is looked at so than edges are looked for in
EDGE_WIDTHS = np.arange(0.8, 2.45, 0.1)  # sd of an edge's derivative, in steps
ON_COURSE_PX = 0.55  # of its softness: an edge point farther from its line's course is none of it
# What is beside a sharp edge is a sum of Gaussians as wide as its own (1.05 to 1.15 are seen) at these steps,
# with so much for their squared heights beside what is not explained.
SHARP_WIDTH, NEIGHBOUR_PENALTY = 1.12, 0.03
NEXT_STEPS = np.concatenate([np.arange(-4.5, -1.0, 0.5), np.arange(1.5, 5.0, 0.5)])
OUTLINE_STEP_SHARE = 0.7  # of an outline's softness where it is not sharp: a step of its profile
# What a line is off as a whole in one channel, per pixel of its softness, is so many times this power of what
# its profile has that no edge explains: read off 1717 lines at the true poses of 45 simulated and ray-traced
# scenes, of which the sharp ones go from 0.02 px to 0.2.
SPREAD_PX, SPREAD_POWER, LEAST_SPREAD_PX = 0.3, 0.33, 0.02
MOST_REST, MOST_MOVED_PX = 0.3, 0.3  # of more it is not clear which part is the edge; no more


class Place(NamedTuple):
    """Where M lines are seen, (M, 2) px as in `Courses`, and which in which channel, (M,)."""

    place: Floats
    line: Ints
    channel: Ints


class Profiles(NamedTuple):
    """What M lines' mean profiles tell.

    Attributes
    ----------
    rest : (M,), of a profile's square the share that is no Gaussian of any width, 0 to 1.
    moved : (M,), px along the normal, from a sharp edge to where its maximum is.
    """

    rest: Floats
    moved: Floats


class Moved(NamedTuple):
    """How far M lines are moved by what is beside them, (M,) px along the normal.

    Attributes
    ----------
    place : from a line to where it is seen.
    sd : of that, of each line by itself.
    shared : how much farther outlines lie along the normal if their image's blur is wider by one sd.
    """

    place: Floats
    sd: Floats
    shared: Floats


def moved_by_profiles(problem: PoseProblem, seen: Observation, at: Place) -> Moved:
    """What the profiles of lines in their channels, about where they are seen, say of what moved them."""
    softness = seen.sigma[at.channel, at.line]
    inside = seen.inside[np.searchsorted(seen.samples.line, at.line)]
    steps = np.minimum(softness, MOST_STEP_PX)
    soft = (inside != 0.0) & (softness > SCALES_PX[0])
    steps[soft] = np.minimum(OUTLINE_STEP_SHARE * softness[soft], MOST_STEP_PX)
    profiles = profiles_of(problem, seen, at, steps)
    told = told_by(profiles, softness <= SCALES_PX[0])
    place, shared = told.moved, np.zeros(len(steps))
    sd = np.maximum(SPREAD_PX * told.rest**SPREAD_POWER, LEAST_SPREAD_PX) * softness
    of = np.flatnonzero(inside)
    if len(of):
        inwards = np.where(inside[of, None] < 0.0, profiles[of, ::-1], profiles[of])
        inwards = inwards[:, PROFILE_STEPS - REACH_STEPS : PROFILE_STEPS + REACH_STEPS + 1]
        filters = np.array(SCALES_PX)[problem.filters[at.channel[of], at.line[of]]]
        weight = (inwards**2).sum(axis=1) / np.bincount(seen.samples.line)[at.line[of]]
        outlines = outlines_of(inwards, Optics(at.channel[of], filters, steps[of]), weight)
        place[of], shared[of] = -inside[of] * outlines.place, inside[of] * outlines.shared
        sd[of] = np.maximum(outlines.sd, LEAST_SPREAD_PX * softness[of])
    return Moved(place, sd, shared)


def profiles_of(problem: PoseProblem, seen: Observation, at: Place, steps_px: Floats) -> Floats:
    """Profiles (M, 2 PROFILE_STEPS + 1) of lines in their channels, summed over samples, in steps (M,) px."""
    profiles, samples = np.zeros((len(at.line), 2 * PROFILE_STEPS + 1)), seen.samples
    for c, channel in enumerate(problem.channels):
        softness = seen.sigma[c, samples.line]
        to_course = np.abs(np.nan_to_num(seen.offset[c])) + ON_COURSE_PX * softness
        reach = to_course + np.abs(seen.drawn[c]) + PROFILE_STEPS * np.minimum(softness, MOST_STEP_PX)
        normals = Normals(samples.image, samples.normal, reach)
        channel.prepare(problem.filters[c, samples.line], normals, 0.0)
        _add_up_all(channel.frame, channel.tiles, problem.filters[c], seen, c, at, steps_px, profiles)
    return profiles


def told_by(profiles: Floats, sharp: Flags) -> Profiles:
    """What profiles (M, 2 PROFILE_STEPS + 1) about their maxima tell; how far ``sharp`` ones moved."""
    square = np.maximum((profiles**2).sum(axis=1), np.finfo(np.float64).tiny)
    like = ((profiles @ _GAUSSIANS.T) ** 2).max(axis=1)
    rest = np.clip(1.0 - like / square, 0.0, 1.0)
    height, slope = (profiles @ _EDGE.T).T
    told = sharp & (rest < MOST_REST) & (height != 0.0)
    moved = np.divide(-slope, height, out=np.zeros_like(rest), where=told)
    return Profiles(rest, np.clip(moved, -MOST_MOVED_PX, MOST_MOVED_PX))


def _gaussian(widths: Floats | float, places: Floats | float = 0.0) -> Floats:
    """At the steps of a profile, (..., 2 PROFILE_STEPS + 1)."""
    around = np.arange(-PROFILE_STEPS, PROFILE_STEPS + 1.0) - np.expand_dims(np.asarray(places), -1)
    return np.asarray(np.exp(-0.5 * (around / np.expand_dims(np.asarray(widths), -1)) ** 2))


def _edge() -> Floats:
    """What makes of a profile its edge's height and that times its place in steps, (2, 2 PROFILE_STEPS + 1).

    By least squares, of both and of what is beside, which is held to be small.
    """
    own = _gaussian(SHARP_WIDTH)
    moved = np.arange(-PROFILE_STEPS, PROFILE_STEPS + 1) / SHARP_WIDTH**2 * own
    parts = np.vstack([own, moved, _gaussian(SHARP_WIDTH, NEXT_STEPS)])
    held = np.diag(np.r_[0.0, 0.0, np.full(len(NEXT_STEPS), NEIGHBOUR_PENALTY)])
    return np.asarray(np.linalg.solve(parts @ parts.T + held, parts)[:2])


_GAUSSIANS = _gaussian(EDGE_WIDTHS) / np.linalg.norm(_gaussian(EDGE_WIDTHS), axis=1)[:, None]
_EDGE = _edge()


@kernel()
def _add_up_all(
    frame: Frame, tiles: Tiles, scale: Ints, seen: Observation, c: int, at: Place, steps: Floats, out: Floats
) -> None:
    """The profiles (M, 2 PROFILE_STEPS + 1) of the lines in one channel, in ``steps`` (M,) px.

    ``scale`` (L,) are indices into SCALES_PX.
    """
    for m in range(len(at.line)):
        if at.channel[m] == c:
            s = scale[at.line[m]]
            channel = Channel(tiles.number[s], tiles.gradient[s], tiles.near_clipped[s], SCALES_PX[s])
            _add_up(frame, channel, seen, c, at, m, steps[m], out[m])


@kernel()
def _add_up(
    frame: Frame, channel: Channel, seen: Observation, c: int, at: Place, m: int, step: float, out: Floats
) -> None:
    """The sum of the profiles (2 PROFILE_STEPS + 1,) of the m-th line's samples, about its course."""
    (rows, columns), samples = frame.shape, seen.samples
    near = ON_COURSE_PX * seen.sigma[c, at.line[m]]
    out[:] = 0.0
    for i in range(np.searchsorted(samples.line, at.line[m]), len(samples.line)):
        if samples.line[i] != at.line[m]:
            break
        course = at.place[m, 0] + at.place[m, 1] * seen.along[i]
        if not abs(seen.offset[c, i] - course) < near:
            continue
        # of outlines, what their curves' blur adds is in what was read off
        seen_at = course if seen.inside[i] != 0.0 else course + seen.drawn[c, i]
        nx, ny = -samples.image_direction[i, 1], samples.image_direction[i, 0]
        for k in range(len(out)):
            u = seen_at + (k - PROFILE_STEPS) * step
            x, y = samples.image[i, 0] + u * nx, samples.image[i, 1] + u * ny
            if x >= 0.0 and y >= 0.0 and x < columns - 1 and y < rows - 1:
                out[k] += derivative_at(channel, x, y, nx, ny)
