"""A pose on whole lines, each of which counts by what lines of this target are off.

Noise hardly moves a line that has a hundred edge points; a rounded edge, print beside it, a shadow or a model
that is not quite true moves it as a whole, or turns it. Lines are therefore the observations, two numbers
each (`line_fits`), of a variance that their own residuals show, with a tail that lets some be another thing
altogether; and the radius by which the target's edges are rounded is an unknown beside the pose.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from geometry.model import Model
from geometry.pose import Pose
from geometry.rotation import cross_matrix
from numerics.arrays import Floats
from numerics.cholesky import inverse_positive
from numerics.kernels import kernel
from vision_server.pose.observation import Observation, PoseProblem, observe
from vision_server.pose.refinement import ENOUGH_ROWS, prior_precision
from vision_server.pose.steps import moved
from vision_server.pose.weights import base_weights
from vision_server.tracking.lines import LineFits, line_fits, rounding_shifts, united

Told = tuple[float, float]
"""What lines tell of the radius: precision 1/m^2, and that times the radius."""

TAIL = 4.0  # degrees of freedom of Student's t, by which lines are off
ITERATIONS = 8
# By hand, on printed boxes (radii of 1 to 4 % of the shortest side) and exact models (none):
ROUNDING_SD = 0.02  # of the shorter lines: the radius of rounded edges, as half a normal
KNOWN_TO, SHARP_TO = 0.1, 1e-4  # of a radius that was told, of the shorter lines: one sd
EVEN_PX, POWER = 0.09, 6.0  # lines that are off so much are as likely of rounded edges as of sharp ones
UNSEEN = 0.2  # numbers that OFF_PX counts as in what lines say of that
SHORTER = 25.0  # percent of the lines
LEARNT = 0.02  # share of a frame's lines and radius in what is known then: its errors are the next one's
MOST_SEEN = 12.0  # lines that what was learnt counts as
OFF_PX, SEEN_AS = 0.2, 4.0  # of lines of a target not seen yet, and how many lines that is worth
LEAST_FREE = 0.2  # of a residual, that the fit does not take up
LEAST_LINES = 4
FARTHEST = 30.0  # standard deviations of a tail that still has a number
FEW = 25.0  # the covariance is 1 + this / (numbers that the variance is from) times what that says


class Habits(NamedTuple):
    """What is known of a target's lines before a frame.

    Attributes
    ----------
    off_px2 : variance of what they are off; worth ``seen`` lines.
    radius_m, radius_sd_m : of its edges, were they rounded: a normal to be cut off at 0.
    at_first_m : the standard deviation of that before anything was seen; 0 where the radius is known.
    """

    off_px2: float
    seen: float
    radius_m: float
    radius_sd_m: float
    at_first_m: float

    @classmethod
    def of(cls, model: Model, edge_radius_m: float | None = None) -> Habits:
        """Of a target that was not seen yet; ``edge_radius_m`` of its edges where that is known."""
        lengths = np.linalg.norm(np.diff(model.vertices[model.lines], axis=1)[:, 0], axis=1)
        shorter_m = float(np.percentile(lengths, SHORTER))
        if edge_radius_m is not None:
            known_sd_m = max(KNOWN_TO * edge_radius_m, SHARP_TO * shorter_m)
            return cls(OFF_PX**2, SEEN_AS, edge_radius_m, known_sd_m, 0.0)
        radius_sd_m = ROUNDING_SD * shorter_m
        return cls(OFF_PX**2, SEEN_AS, 0.0, radius_sd_m, radius_sd_m)

    def after(self, fit: Fit) -> Habits:
        """With what one more frame said."""
        seen = min(self.seen + LEARNT * fit.lines, MOST_SEEN)
        share = LEARNT * fit.lines / seen
        known = self.radius_sd_m**-2.0
        precision = known + LEARNT * fit.radius_told[0]
        radius = (self.radius_m * known + LEARNT * fit.radius_told[1]) / precision
        off_px2 = self.off_px2 + share * (fit.off_px2 - self.off_px2)
        return Habits(off_px2, seen, radius, precision**-0.5, self.at_first_m)


@dataclass(frozen=True, eq=False)
class Fit:
    """A pose on lines.

    Attributes
    ----------
    covariance : (6, 6), of a left-multiplied step.
    observation : edge points where the step started, their offsets from the lines where it ended.
    moved_px : how far it moved the lines, at most.
    courses : of the lines, where the step started.
    known : what was known before: precisions of the unknowns (9,), and of the lines.
    off_px2 : what the lines are off, this frame alone.
    radius_m : of the edges, with what was known before.
    radius_told : what this frame alone says of it: precision 1/m^2, and that times the radius.
    """

    pose: Pose
    covariance: Floats
    observation: Observation
    moved_px: float
    courses: LineFits
    known: tuple[Floats, Habits]
    off_px2: float
    radius_m: float
    radius_told: Told

    @property
    def lines(self) -> int:
        """How many there are."""
        return len(self.courses.line)

    def covariance_with(self, more_px2: Floats) -> Floats:
        """Covariance (6, 6) if the model's lines (L,) are uncertain by so much more."""
        return _about_camera(solved(_wider(self.courses, more_px2), *self.known)[1], self.observation.centre)


def fitted(
    problem: PoseProblem,
    start: Pose,
    reach_px: float,
    spacing_px: float,
    habits: Habits,
    beside_px2: Floats | None = None,
) -> Fit | None:
    """One step from a pose that is nearly there; None where too few lines are seen.

    Parameters
    ----------
    beside_px2 : (L,), variance of each line of the model for what runs beside it, see `beside`.
    """
    seen = observe(problem, start, reach_px, spacing_px, pulls=False)
    base = base_weights(seen, True)
    if int((base > 0.0).sum()) < ENOUGH_ROWS:
        return None
    lines = line_fits(seen, base, *rounding_shifts(problem, start, seen))
    if len(problem.channels) > 1:
        lines = united(lines)
    if beside_px2 is not None:
        lines = _wider(lines, beside_px2)
    if len(lines.value) < LEAST_LINES:
        return None
    range_m = float(np.linalg.norm(start.translation))
    prior = np.append(prior_precision(range_m, problem.tone_sd_px), habits.radius_sd_m**-2.0)
    step, covariance, off_px2, radius_told = solved(lines, prior, habits)
    if not np.isfinite(step).all():
        return None
    moves = seen.jacobian @ step[:6]
    return Fit(
        moved(start, step[:6], seen.centre),
        _about_camera(covariance, seen.centre),
        seen._replace(offset=seen.offset - moves),
        float(np.abs(moves).max()),
        lines,
        (prior, habits),
        off_px2,
        float(step[8]),
        radius_told,
    )


def _wider(lines: LineFits, more_px2: Floats) -> LineFits:
    return lines._replace(variance=lines.variance + more_px2[lines.line][:, None])


def _about_camera(covariance: Floats, centre: Floats) -> Floats:
    """Of a pose (6, 6), from that (9, 9) of steps about a turning point (3,)."""
    turn = np.eye(6)
    turn[3:, :3] = cross_matrix(centre)
    return np.asarray(turn @ covariance[:6, :6] @ turn.T)


@kernel()
def none_or_rounded(
    unknowns: Floats, covariance: Floats, at_first_sd: float, odds_before: float
) -> tuple[Floats, Floats]:
    """A normal distribution of (K,) unknowns of which the last, the radius, is 0 or more.

    Parameters
    ----------
    at_first_sd : of the radius before anything was seen, that of half a normal, were the edges rounded; 0
        where they are for certain.
    odds_before : that they are, before the radius was looked at.

    Returns
    -------
    Moments of the mixture of two: sharp edges, and rounded ones, whose radius is a normal cut off at 0. Their
    odds are those of before times the ratio of the radius' densities at 0, before and now (Savage and
    Dickey). What is tied to the radius goes with it.
    """
    variance = float(covariance[-1, -1])
    sd = math.sqrt(variance)
    above = max(float(unknowns[-1]) / sd, -FARTHEST)
    mass = mills_ratio(above)
    hazard = 1.0 / mass
    rounded = 1.0
    if at_first_sd > 0.0:
        odds = odds_before * 2.0 * sd / at_first_sd / math.sqrt(2.0 * math.pi) * mass
        rounded = odds / (1.0 + odds)
    mean, spread = sd * (above + hazard), variance * max(1.0 - hazard * (hazard + above), 0.0)
    spread = rounded * (spread + (1.0 - rounded) * mean**2)
    gain = covariance[:, -1] / variance
    step = gain * (rounded * mean - float(unknowns[-1]))
    return unknowns + step, covariance - np.outer(gain, gain) * (variance - spread)


@kernel()
def rounded_odds(off_px2: float, numbers: float) -> float:
    """Odds that edges are rounded, by what other than that a frame's lines are off, as so many numbers show.

    Where lines are true to hundredths of a pixel, the model is true in its edges as well.
    """
    variance = (numbers * off_px2 + UNSEEN * OFF_PX**2) / (numbers + UNSEEN)
    return float((variance / EVEN_PX**2) ** (0.5 * POWER))


@kernel()
def mills_ratio(above: float) -> float:
    """Mass of the standard normal below ``above`` over its density there."""
    above = min(above, FARTHEST)
    return math.sqrt(0.5 * math.pi) * math.exp(0.5 * above**2) * math.erfc(-above / math.sqrt(2.0))


@kernel()
def solved(lines: LineFits, prior: Floats, habits: Habits) -> tuple[Floats, Floats, float, Told]:
    """Pose, nuisances and radius (9,), their covariance; of these lines alone, what they are off, px^2, and
    what they tell of the radius, see `Fit`.

    Iteratively reweighted least squares: the weights are Student's, the variance is that of the residuals,
    each divided by the share of it that the fit did not take up, beside what was known.
    """
    values, scatters, rows = lines.value.ravel(), lines.variance.ravel(), lines.rows.reshape(-1, 9)
    radius_m2 = habits.radius_m**2  # expected square of the radius
    factor, off_px2, own, left = np.ones(len(values)), habits.off_px2, 0.0, 0.0
    step, covariance, told = np.zeros(9), np.eye(9), (0.0, 0.0)
    for _ in range(ITERATIONS):
        normal, right = np.diag(prior), np.zeros(9)
        right[8] = prior[8] * habits.radius_m
        for i in range(len(values)):
            if scatters[i] < np.inf:
                variance = scatters[i] + lines.slack[i // 2] ** 2 / 3.0 * radius_m2 + off_px2
                weight = factor[i] / variance
                for j in range(9):
                    right[j] += weight * values[i] * rows[i, j]
                    for k in range(9):
                        normal[j, k] += weight * rows[i, j] * rows[i, k]
        covariance = inverse_positive(normal)
        step = (covariance * right).sum(axis=1)
        told = (1.0 / covariance[8, 8] - prior[8], step[8] / covariance[8, 8] - prior[8] * habits.radius_m)
        step, covariance = none_or_rounded(step, covariance, habits.at_first_m, rounded_odds(own, left))
        shares, squares, left = 0.0, 0.0, 0.0
        for i in range(len(values)):
            if scatters[i] < np.inf:
                noise = scatters[i] + lines.slack[i // 2] ** 2 / 3.0 * radius_m2
                variance = noise + off_px2
                residual = values[i] - (rows[i] * step).sum()
                free = 1.0 - factor[i] / variance * ((covariance * rows[i]).sum(axis=1) * rows[i]).sum()
                left += free
                factor[i] = (TAIL + 1.0) / (TAIL + residual**2 / variance)
                share = off_px2 / variance
                shares += share
                squares += share * max(factor[i] * residual**2 / max(free, LEAST_FREE) - noise, 0.0)
        left = max(left, 0.0)
        radius_m2 = step[8] ** 2 + covariance[8, 8]
        own = squares / max(shares, 1e-9)
        off_px2 = (habits.seen * habits.off_px2 + squares) / (habits.seen + shares)
    covariance[:6, :6] *= 1.0 + FEW / (2.0 * habits.seen + left)
    return step, covariance, own, told
