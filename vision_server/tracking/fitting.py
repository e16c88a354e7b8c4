"""A pose on whole lines, each of which counts by what lines of this target are off.

Noise hardly moves a line that has a hundred edge points; a rounded edge, print beside it, a shadow or a model
that is not quite true moves it as a whole, or turns it. Lines are therefore the observations. Of each, two
numbers y (`line_fits`: its offset and its turn, px) are modelled as

    y = rows . unknowns + error,  unknowns = (pose 6, nuisances 2, radius 1),
    error ~ Student's t of TAIL degrees of freedom, of variance s^2 + (slack radius)^2 / 3 + off^2,

where s^2 is what scatters along the line, the second part is that of an edge that may be anywhere on a
rounding, and off^2 is what lines are off as a whole, which their residuals show. Pose and nuisances have the
priors of refinement. The radius of the target's edges has a mixture of two: it is 0, or half a normal
(`none_or_rounded`), with odds by how far off the lines are (`rounded_odds`). What frames tell of off^2 and of
the radius is handed on to the next ones (`Habits`).

Poses that are tracked or checked are fitted so. A session's estimate takes `trust.settling` as its last step
instead, where no frames before tell what lines are off: the profiles across their edges have to.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from geometry.model import Model
from geometry.pose import Pose
from numerics.arrays import Floats, Ints
from numerics.cholesky import inverse_positive
from numerics.kernels import kernel
from vision_server.pose.observation import Observation, PoseProblem, observe
from vision_server.pose.refinement import FEWEST_EDGE_POINTS, prior_precision
from vision_server.pose.steps import moved
from vision_server.pose.weights import base_weights
from vision_server.tracking.lines import (
    LINE_UNKNOWNS,
    RADIUS,
    LineFits,
    line_fits,
    on_roundings,
    rounding_shifts,
    united,
)
from vision_server.tracking.motion import about
from vision_server.tracking.repeated_lines import offsets_of, repetition, sums_of_rows

Information = tuple[float, float]
"""What lines tell of the radius: the precision, 1/m^2, and that times the radius."""

TAIL = 4.0  # degrees of freedom of Student's t, by which lines are off (by hand)
FIT_ITERATIONS = 8  # of reweighting (by hand)
# The priors of the radius were chosen by hand, on printed boxes (whose radii are 1 to 4 % of the shortest
# side) and on exact models (which have none). It is measured in lengths of the shorter lines, which are those
# at this percentile; that of rounded edges is half of a normal of this sd.
SHORTER_PERCENTILE, ROUNDING_SD_SHARE = 25.0, 0.02
KNOWN_RADIUS_SD_SHARE, LEAST_RADIUS_SD_SHARE = 0.1, 1e-4  # sd of a radius that is given: of it, and at least
# Rounded edges are as likely as sharp ones where lines are off by this; the odds grow with that power of it.
EVEN_ODDS_OFF_PX, ROUNDED_ODDS_POWER = 0.09, 6.0
PRIOR_NUMBERS = 0.2  # how many numbers FIRST_OFF_PX counts as, beside those that a frame has, in these odds
LEARNT_SHARE = 0.02  # of what a frame tells, as the errors of the next frame are the same
MOST_SEEN_LINES = 12.0  # lines that all that was learnt counts as, at most
FIRST_OFF_PX, FIRST_SEEN_LINES = 0.2, 4.0  # what a new target's lines are off, and how many lines say so
LEAST_FREE = 0.2  # of a residual's variance, the share that the fit is taken to leave at least
COMMON_SHARE = 0.7  # of off^2, what the lines of a row (`repeated_lines`) share: of a film of slots 0.66
LEAST_LINES = 4  # that hold a pose and tell what lines are off: a pose takes three
FARTHEST_SIGMAS = 30.0  # beyond these, a normal's tail has no number
WIDER_BY = 25.0  # a covariance is wider by this over the numbers that its variance is from, and one


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
        shorter_m = float(np.percentile(lengths, SHORTER_PERCENTILE))
        if edge_radius_m is not None:
            known_sd_m = max(KNOWN_RADIUS_SD_SHARE * edge_radius_m, LEAST_RADIUS_SD_SHARE * shorter_m)
            return cls(FIRST_OFF_PX**2, FIRST_SEEN_LINES, edge_radius_m, known_sd_m, 0.0)
        radius_sd_m = ROUNDING_SD_SHARE * shorter_m
        return cls(FIRST_OFF_PX**2, FIRST_SEEN_LINES, 0.0, radius_sd_m, radius_sd_m)

    def after(self, fit: Fit) -> Habits:
        """With what one more frame said."""
        lines = len(fit.fits.line)
        seen = min(self.seen + LEARNT_SHARE * lines, MOST_SEEN_LINES)
        share = LEARNT_SHARE * lines / seen
        known = self.radius_sd_m**-2.0
        precision = known + LEARNT_SHARE * fit.radius_information[0]
        radius = (self.radius_m * known + LEARNT_SHARE * fit.radius_information[1]) / precision
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
    fits : of the lines, where the step started.
    known : what was known before: precisions of the unknowns (9,), of the lines, and their rows (M,).
    off_px2 : what the lines are off, this frame alone.
    radius_m : of the edges, with what was known before.
    radius_information : what this frame alone says of it: precision 1/m^2, and that times the radius.
    """

    pose: Pose
    covariance: Floats
    observation: Observation
    moved_px: float
    fits: LineFits
    known: tuple[Floats, Habits, Ints]
    off_px2: float
    radius_m: float
    radius_information: Information

    def covariance_with(self, more_px2: Floats) -> Floats:
        """Covariance (6, 6) if the model's lines (L,) are uncertain by so much more."""
        return about(-self.observation.centre, solved(_wider(self.fits, more_px2), *self.known)[1][:6, :6])


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
    if int((base > 0.0).sum()) < FEWEST_EDGE_POINTS:
        return None
    lines = line_fits(seen, base, *rounding_shifts(problem, start, seen))
    lines = united(lines) if len(problem.channels) > 1 else lines
    lines = lines if beside_px2 is None else _wider(lines, beside_px2)
    if len(lines.value) < LEAST_LINES:
        return None
    if problem.model.edge_radius_m > 0.0:
        lines = on_roundings(lines, seen)
    whole = problem.model.edge_radius_m * lines.rows[:, :, RADIUS]  # from where sharp edges would be
    lines = lines._replace(value=lines.value + whole)
    known = prior_precision(float(np.linalg.norm(start.translation)), problem.tone_sd_px)
    prior = np.append(known, habits.radius_sd_m**-2.0)
    rows = repetition(problem.model)[lines.line]
    step, covariance, off_px2, radius_information = solved(lines, prior, habits, rows)
    if not np.isfinite(step).all():
        return None
    moves = seen.jacobian @ step[:6]
    return Fit(
        moved(start, step[:6], seen.centre),
        about(-seen.centre, covariance[:6, :6]),
        seen._replace(offset=seen.offset - moves),
        float(np.abs(moves).max()),
        lines,
        (prior, habits, rows),
        off_px2,
        float(step[RADIUS]),
        radius_information,
    )


def _wider(lines: LineFits, more_px2: Floats) -> LineFits:
    return lines._replace(variance=lines.variance + more_px2[lines.line][:, None])


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
    above = max(float(unknowns[-1]) / sd, -FARTHEST_SIGMAS)
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
    variance = (numbers * off_px2 + PRIOR_NUMBERS * FIRST_OFF_PX**2) / (numbers + PRIOR_NUMBERS)
    return float((variance / EVEN_ODDS_OFF_PX**2) ** (0.5 * ROUNDED_ODDS_POWER))


@kernel()
def mills_ratio(above: float) -> float:
    """Mass of the standard normal below ``above`` over its density there."""
    above = min(above, FARTHEST_SIGMAS)
    return math.sqrt(0.5 * math.pi) * math.exp(0.5 * above**2) * math.erfc(-above / math.sqrt(2.0))


@kernel()
def solved(
    lines: LineFits, prior: Floats, habits: Habits, row: Ints
) -> tuple[Floats, Floats, float, Information]:
    """The unknowns (9,), their covariance; of these lines alone, off^2, and what they tell of the radius.

    Iteratively reweighted least squares: the weights are Student's, off^2 is that of the residuals, each
    divided by the share of it that the fit did not take up, beside what was known. Lines of one ``row`` (M,),
    see `repetition`, share a part of their offsets.
    """
    known = lines.variance.ravel() < np.inf
    value, scatter = lines.value.ravel()[known], lines.variance.ravel()[known]
    rows, slack = lines.rows.reshape(-1, LINE_UNKNOWNS)[known], np.repeat(lines.slack, 2)[known]
    member = offsets_of(row)[known]
    pull, radius_m2 = prior[RADIUS] * habits.radius_m, habits.radius_m**2  # the latter as is expected
    factor, off_px2, own, left = np.ones(len(value)), habits.off_px2, 0.0, 0.0
    step, covariance, told = np.zeros(LINE_UNKNOWNS), np.eye(LINE_UNKNOWNS), (0.0, 0.0)
    for _ in range(FIT_ITERATIONS):
        noise = scatter + slack * slack / 3.0 * radius_m2
        variance = noise + off_px2
        alone = np.where(member == 0, variance, variance - COMMON_SHARE * off_px2)
        weight = factor / alone
        normal, right = np.diag(prior), np.zeros(LINE_UNKNOWNS)
        right[RADIUS] = pull
        for i in range(len(value)):
            for j in range(LINE_UNKNOWNS):
                right[j] += weight[i] * value[i] * rows[i, j]
                for k in range(LINE_UNKNOWNS):
                    normal[j, k] += weight[i] * rows[i, j] * rows[i, k]
        sums = sums_of_rows(member, weight, value, rows)
        gains = 1.0 / (1.0 / (COMMON_SHARE * off_px2) + sums[:, -1])
        for g in range(len(sums)):
            right -= gains[g] * sums[g, -2] * sums[g, :LINE_UNKNOWNS]
            normal -= gains[g] * np.outer(sums[g, :LINE_UNKNOWNS], sums[g, :LINE_UNKNOWNS])
        covariance = inverse_positive(normal)
        step = (covariance * right).sum(axis=1)
        own_radius = covariance[RADIUS, RADIUS]
        told = (1.0 / own_radius - prior[RADIUS], step[RADIUS] / own_radius - pull)
        step, covariance = none_or_rounded(step, covariance, habits.at_first_m, rounded_odds(own, left))
        common = gains * (sums[:, -2] - (sums[:, :LINE_UNKNOWNS] * step).sum(axis=1))
        shares, squares, left = 0.0, 0.0, 0.0
        for i in range(len(value)):
            residual = value[i] - (rows[i] * step).sum()
            free = 1.0 - weight[i] * ((covariance * rows[i]).sum(axis=1) * rows[i]).sum()
            apart = residual - np.sign(member[i]) * common[abs(member[i])]
            factor[i] = (TAIL + 1.0) / (TAIL + apart**2 / alone[i])
            share = off_px2 / variance[i]
            left, shares = left + free, shares + share
            squares += share * max(factor[i] * residual**2 / max(free, LEAST_FREE) - noise[i], 0.0)
        left = max(left, 0.0)
        radius_m2 = step[RADIUS] ** 2 + covariance[RADIUS, RADIUS]
        own = squares / max(shares, 1e-9)
        off_px2 = (habits.seen * habits.off_px2 + squares) / (habits.seen + shares)
    covariance[:6, :6] *= 1.0 + WIDER_BY / (2.0 * habits.seen + left)
    return step, covariance, own, told
