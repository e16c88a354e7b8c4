"""What the images say about a pose: offsets of edge points from the model's visible lines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from geometry.visibility import Samples, visible_samples
from numerics.arrays import Floats, Ints
from numerics.kernels import kernel
from vision_server.channels.gradients import (
    SCALES_PX,
    TILE_BITS,
    TILE_PX,
    Frame,
    GradientChannel,
    Normals,
    Tiles,
)
from vision_server.channels.tone import KNOWN_TONE_SD_PX
from vision_server.pose.association import associate
from vision_server.pose.blending import Edges, blended
from vision_server.pose.chords import beyond_chords
from vision_server.pose.curved_edges import drawn_in, facet_lengths
from vision_server.pose.edge_points import CLIPPED_SD_PX, Channel, EdgePoints, search
from vision_server.pose.hough import choose, vote, vote_worth
from vision_server.pose.outline_shading import inside_of, way_back
from vision_server.pose.roundings import onto_roundings, slack_px
from vision_server.pose.sampling import places_on_lines
from vision_server.pose.steps import step_jacobian, turning_point

VOTE_WIDTH_PX = 1.0  # tolerance of a line's vote for a sharp edge
# Index into SCALES_PX of the filter, for each softness: half of the blur and no more than 2 px. A wider one
# takes in what lies beside an edge; on 18 hard stacks right poses were 1.17 times as far off with it.
FILTER_OF_SOFTNESS = np.array([0, 0, 1, 1])
SIGMAS = np.array(SCALES_PX)
REACH_OVER_SOFTNESS = 1.5  # an edge is looked for at least this many times its softness to either side
GAP_SPACINGS = 2.0  # samples that are farther apart than this many spacings are no neighbours
MOST_STEP_RATIO = 2.0  # height of a step over the mean of its two sides: that of a step from black
START_SHARE = 1.0 / 3.0  # of the reach: how far a line may be from its place, one sd
LEAST_LEVEL_GREY = 2.0  # of that mean, under which the ratio is noise


@dataclass(frozen=True, eq=False)
class PoseProblem:
    """What a pose of a target is refined on.

    Attributes
    ----------
    scale
        (C, L), index into SCALES_PX of the softness of each line in each channel, see `line_scales`.
    tone_sd_px
        How far edges may be off by a tone curve that is still in the images.
    tolerance_m
        How far each line of the part may be off the model's, one sd.
    untold_tolerance_m
        The same where nobody has told it: the covariance allows for it, the pose only where lines ask for it.
    roundness
        Where round parts are looked for: 0 is along the chords of the model, 1 along the curve through their
        ends.
    """

    channels: Sequence[GradientChannel]
    model: Model
    camera: Camera
    scale: Ints
    tone_sd_px: float = KNOWN_TONE_SD_PX
    tolerance_m: float = 0.0
    untold_tolerance_m: float = 0.0
    roundness: float = 0.0

    @cached_property
    def filters(self) -> Ints:
        """(C, L), index into SCALES_PX of the filter that places the edge points; not to be written to."""
        return FILTER_OF_SOFTNESS[self.scale]

    @cached_property
    def sigma(self) -> Floats:
        """(C, L), softness of each line in each channel, px; not to be written to."""
        return SIGMAS[self.scale]

    @classmethod
    def at_scale(
        cls,
        channels: Sequence[GradientChannel],
        model: Model,
        camera: Camera,
        scale: int = 0,
        tone_sd_px: float = KNOWN_TONE_SD_PX,
        tolerance_m: float = 0.0,
        untold_tolerance_m: float = 0.0,
    ) -> PoseProblem:
        """With the same softness of all lines."""
        everywhere = np.full((len(channels), len(model.lines)), scale, dtype=np.int64)
        return cls(channels, model, camera, everywhere, tone_sd_px, tolerance_m, untold_tolerance_m)


class Observation(NamedTuple):
    """Edge points near the visible lines of a model at one pose; N samples, C channels, L model lines.

    Attributes
    ----------
    samples
        Points on the visible lines.
    along
        (N,), place of a sample on its line's visible part, -1 to 1.
    from_end
        (N,), distance of a sample from the nearest end of a visible part of its line, px.
    jacobian
        (N, 6), change of the line's place along the normal, px, per (rotation rad about ``centre``,
        translation m).
    centre
        (3,), camera frame, metres: the turning point of the steps.
    sigma
        (C, L), softness of each line in each channel, px: 1 of a sharp one.
    offset, sd, strength
        (C, N), of the chosen edge point: place along the normal px (NaN: none), its noise px, signed
        derivative grey/px.
    drawn
        (C, N), px along the normal, see `drawn_in`: ``offset`` is without it.
    nuisance
        (C, N, 2), what moves edges but not the pose, up to a factor each: a tone curve that was not undone
        (signed height of the step over the mean of its sides), and clipping (towards the dark side; 0 for
        edges away from saturated pixels); both times the line's softness.
    neighbours
        (C, N), how far lines beside this one may have moved its edge besides what the offset has been moved
        back by, px, signed; see `blending`.
    tolerance
        (N,), how far the part's line may be off the model's, or a rounded crease's edge off its place, px.
    slack
        (N,), half the width of a rounded crease, px, see `roundings.slack_px`; 0 of other lines.
    inside
        (N,), on which side of an outline its surface is, see `inside_of`.
    """

    samples: Samples
    along: Floats
    from_end: Floats
    jacobian: Floats
    centre: Floats
    sigma: Floats
    offset: Floats
    sd: Floats
    strength: Floats
    drawn: Floats
    nuisance: Floats
    neighbours: Floats
    tolerance: Floats
    slack: Floats
    inside: Floats


def observe(
    problem: PoseProblem, pose: Pose, reach_px: float, spacing_px: float, pulls: bool = True
) -> Observation:
    """Look for edge points along the normals of the model's visible lines.

    Parameters
    ----------
    reach_px
        How far to look to either side; more where the softness asks for it.
    spacing_px
        Between the samples of a line.
    pulls
        Whether edges are moved back by what runs beside them, and ``neighbours`` are worked out; else zeros.
    """
    channels, model, camera = problem.channels, problem.model, problem.camera
    samples = visible_samples(model, camera, pose, spacing_px)
    centre = turning_point(model, pose)
    jacobian = step_jacobian(camera, pose.apply(samples.points), samples.normal, centre)
    if problem.roundness > 0.0:
        out = problem.roundness * beyond_chords(model, pose, samples, jacobian).sum(axis=1, keepdims=True)
        samples = samples._replace(image=samples.image + out * samples.normal)
    along, from_end = places_on_lines(samples, GAP_SPACINGS * spacing_px)
    filters = np.take(problem.filters, samples.line, axis=1)  # in rows, as kernels expect
    sigma = np.take(problem.sigma, samples.line, axis=1)
    widest = sigma.max(axis=0) if len(channels) else np.ones(len(along))
    reach, width = np.maximum(reach_px, REACH_OVER_SOFTNESS * widest), VOTE_WIDTH_PX * np.sqrt(widest)
    slack = slack_px(model, camera, pose, samples)
    around = np.maximum(reach, np.where(slack > 0.0, slack + width, 0.0))
    normals = Normals(samples.image, samples.normal, around)
    points = search(channels, filters, normals)
    associate(samples, points.offset)
    farthest = float(normals.reach_px.max(initial=reach_px))
    votes = vote_worth(points.snr)
    shift = vote(samples.line, along, points.offset, votes, len(model.lines), farthest, width)
    chosen = choose(samples.line, along, points.offset, shift, width)
    shape, inside = chosen.shape, inside_of(model, camera, pose, samples)
    found = _Chosen(np.empty(shape), np.empty(shape), np.empty(shape), np.empty((*shape, 2)))
    for c, channel in enumerate(channels):
        looked = _Looked(c, chosen, sigma, filters, inside)
        _take_chosen(looked, points, channel.frame, channel.tiles, samples, found)
    drawn = drawn_in(samples, facet_lengths(model, camera, pose, samples), sigma, SIGMAS[filters])
    offset, neighbours = found.offset - drawn, np.zeros(shape)
    if pulls:
        seen = Edges(offset, found.sd, found.strength)
        by, neighbours = blended(samples, sigma, _blur(channels, sigma, SIGMAS[filters]), seen)
        offset = offset - by
    tolerance = np.zeros(len(along))
    if problem.tolerance_m > 0.0:
        tolerance = problem.tolerance_m * np.linalg.norm(jacobian[:, 3:], axis=1)
    if slack.any():
        tolerance = np.hypot(tolerance, onto_roundings(samples.line, offset, slack, START_SHARE * reach_px))
    return Observation(
        samples=samples,
        along=along,
        from_end=from_end,
        jacobian=jacobian,
        centre=centre,
        sigma=problem.sigma,
        offset=offset,
        sd=found.sd,
        strength=found.strength,
        drawn=drawn,
        nuisance=found.nuisance,
        neighbours=neighbours,
        tolerance=tolerance,
        slack=slack,
        inside=inside,
    )


def _blur(channels: Sequence[GradientChannel], sigma: Floats, filters: Floats) -> Floats:
    """Blur (C, N) px of edges and their filters together, from their softness and their images' blur."""
    of_images = np.array([[channel.blur_px] for channel in channels]).reshape(-1, 1)
    return np.asarray(np.hypot(np.maximum(sigma, of_images), filters))


class _Chosen(NamedTuple):
    """The chosen edge points, (C, N) and (C, N, 2), see `Observation`."""

    offset: Floats
    sd: Floats
    strength: Floats
    nuisance: Floats


class _Looked(NamedTuple):
    """How one channel was looked at, the c-th of C; of N samples on L lines."""

    c: int
    chosen: Ints  # (C, N), which edge point of each sample is taken, -1 for none
    sigma: Floats  # (C, N), softness of each sample's line, px
    filters: Ints  # (C, N), index into SCALES_PX
    inside: Floats  # (N,), see `inside_of`


@kernel()
def _take_chosen(
    looked: _Looked, points: EdgePoints, frame: Frame, tiles: Tiles, samples: Samples, out: _Chosen
) -> None:
    """One channel's chosen edge points with what they may be off by.

    The tone curve moves an edge in proportion to the step's height over the mean of its sides, times its
    softness; clipping towards its dark side; an outline as `way_back` says.
    """
    c, chosen, sigma, filters, inside = looked
    rows, columns = frame.shape
    for i in range(chosen.shape[1]):
        k = chosen[c, i]
        out.offset[c, i], out.sd[c, i], out.strength[c, i] = np.nan, np.inf, 0.0
        out.nuisance[c, i, 0] = out.nuisance[c, i, 1] = 0.0
        if k < 0:
            continue
        own = sigma[c, i]
        place, slope = points.offset[c, i, k], points.strength[c, i, k]
        out.offset[c, i], out.sd[c, i], out.strength[c, i] = place, points.sd[c, i, k], slope
        nx, ny = -samples.image_direction[i, 1], samples.image_direction[i, 0]
        x, y = samples.image[i, 0] + place * nx, samples.image[i, 1] + place * ny
        column = min(max(int(x + 0.5), 0), columns - 1)
        row = min(max(int(y + 0.5), 0), rows - 1)
        # the smoothed level at the nearest pixel, carried to the edge along its slope
        tile = tiles.smooth[tiles.number[0, row >> TILE_BITS, column >> TILE_BITS]]
        level = tile[row % TILE_PX * TILE_PX + column % TILE_PX]
        level = max(level + ((x - column) * nx + (y - row) * ny) * slope, LEAST_LEVEL_GREY)
        step = slope * own * math.sqrt(2.0 * math.pi) / level
        out.nuisance[c, i, 0] = min(max(step, -MOST_STEP_RATIO), MOST_STEP_RATIO) * own
        s = filters[c, i]
        if points.sd[c, i, k] >= CLIPPED_SD_PX * SIGMAS[s]:
            out.nuisance[c, i, 1] = -own if slope > 0.0 else own
        if inside[i] != 0.0:
            at_scale = Channel(tiles.number[s], tiles.gradient[s], tiles.near_clipped[s], SIGMAS[s])
            back, unsure = way_back(frame, at_scale, (x, y), (nx, ny), slope, inside[i])
            out.offset[c, i] += back
            out.sd[c, i] = math.hypot(out.sd[c, i], unsure)
