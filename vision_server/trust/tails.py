"""How far off a pose may be along what its lines hold least: by their likelihood, not by its curvature alone.

Lines are off by Student's t: one that is a pixel beside its place is no wonder. Where many hold a pose, the
likelihood falls off as a Gaussian does that is curved like it at the top. Where one line alone holds a tilt,
it falls off like the t of that line, and a degree more may hardly be less likely. The other unknowns follow
(profile likelihood: Pawitan, In All Likelihood, chapter 3).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from numerics.arrays import Floats

MULTIPLES = (0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 11.0, 15.0)  # of the standard deviation (by hand)
MASS, MASS_SIGMAS = 0.95, 1.96  # of a Gaussian, within so many of its standard deviations
MOST_STEPS, STILL_NATS = 12, 1e-3  # of reweighting at one place, at most and until the likelihood is so still
FINE = 1201  # places between which the likelihood is interpolated


class Held(NamedTuple):
    """What holds a pose: M places of lines, J unknowns, the first six of them its step.

    Attributes
    ----------
    place, motion : (M, 2), and (M, 2, J), as of `Courses`, in units of what each may be off.
    share : (M,), what each counts.
    prior : (J,), precision of the unknowns about 0.
    freedom : degrees of freedom of Student's t.
    """

    place: Floats
    motion: Floats
    share: Floats
    prior: Floats
    freedom: float

    def squares(self, unknowns: Floats) -> Floats:
        """Squared distances (M,) of places from where unknowns (J,) have them."""
        off = self.place - self.motion @ unknowns
        return np.asarray((off**2).sum(axis=1))

    def weights(self, squares: Floats) -> Floats:
        """What places count (M,) of which the pose leaves such ``squares`` (M,)."""
        return self.share * (self.freedom + 2.0) / (self.freedom + squares)

    def equations(self, squares: Floats) -> tuple[Floats, Floats]:
        """Normal equations, (J, J) and (J,), of places reweighted by their ``squares`` (M,)."""
        rows = self.motion.reshape(-1, len(self.prior))
        pulls = rows.T * np.repeat(self.weights(squares), 2)
        return pulls @ rows + np.diag(self.prior), pulls @ self.place.ravel()

    def nats(self, squares: Floats, unknowns: Floats) -> float:
        """-ln of the likelihood of unknowns (J,) that leave the places such ``squares`` (M,)."""
        return (
            0.5 * (self.freedom + 2.0) * float(self.share @ np.log1p(squares / self.freedom))
            + 0.5 * float(unknowns**2 @ self.prior)
        )  # fmt: skip


def with_tails(covariance: Floats, limits: Floats, held: Held, step: Floats, factor: float) -> Floats:
    """The covariance (6, 6) of a step, as wide along its loosest motion as the likelihood is there.

    Parameters
    ----------
    covariance
        By the curvature; ``limits`` (6,) are the unit in which motions are compared.
    held, step
        What holds the pose, and the likeliest unknowns (J,).
    factor
        On all variances, by how much lines scatter.
    """
    spread, motions = np.linalg.eigh(covariance / np.outer(limits, limits))
    asked = motions[:, -1] / limits
    ratio = _wider(held, step, asked, float(np.sqrt(spread[-1] / factor)), factor)
    pull = covariance @ asked
    return np.asarray(covariance + (ratio**2 - 1.0) * np.outer(pull, pull) / (asked @ pull))


def _wider(held: Held, step: Floats, asked: Floats, sd: float, factor: float) -> float:
    """How many times as wide the likelihood of ``asked`` (6,) @ step is as a Gaussian of that ``sd``.

    By the interval about the likeliest that has MASS of it; at least 1.
    """
    weights = np.r_[asked, np.zeros(len(step) - 6)]
    top = held.nats(held.squares(step), step)
    fine = np.linspace(0.0, MULTIPLES[-1], FINE)
    likelihood = np.zeros(FINE)
    for side in (-1.0, 1.0):
        nats, unknowns = [0.0], step
        for multiple in MULTIPLES:
            unknowns = _likeliest(held, unknowns, weights, float(weights @ step) + side * multiple * sd)
            nats.append(held.nats(held.squares(unknowns), unknowns) - top)
        likelihood += np.exp(-np.interp(fine, (0.0, *MULTIPLES), nats) / factor)
    mass = np.cumsum(likelihood)
    # In sds of the curvature, which the factor has made as much wider.
    half = float(fine[np.searchsorted(mass, MASS * mass[-1])]) / math.sqrt(factor)
    return max(1.0, half / MASS_SIGMAS)


def _likeliest(held: Held, start: Floats, weights: Floats, value: float) -> Floats:
    """The likeliest unknowns with a value of ``weights`` @ them, by reweighted least squares from a start."""
    unknowns, before = start, np.inf
    squares = held.squares(unknowns)
    for _ in range(MOST_STEPS):
        normal, right = held.equations(squares)
        free, along = np.linalg.solve(normal, np.column_stack([right, weights])).T
        unknowns = free + along * (value - weights @ free) / (weights @ along)
        squares = held.squares(unknowns)
        nats = held.nats(squares, unknowns)
        if abs(nats - before) < STILL_NATS:
            break
        before = nats
    return unknowns
