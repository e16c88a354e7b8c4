"""Is the model true? Stretched and sheared ones are fitted beside the best pose; a better fit says no.

A part that is wider than its model still fits it along most lines, sharply and with a small uncertainty, at a
pose that is off. No pose of the model tells; another model does. A scale of all axes together is the same as
another range, so that two of the three scales can be seen at most.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from geometry.deformed import deformed
from geometry.model import Model
from geometry.pose import Pose
from geometry.visibility import Samples
from numerics.arrays import Floats
from vision_server.pose.covariance import unknowns_of
from vision_server.pose.refinement import Solution, prior_precision
from vision_server.pose.steps import moved
from vision_server.trust.hypotheses import edges_around, explained
from vision_server.trust.probability import LEAST_STRETCH, Misfit
from vision_server.trust.ranking import COARSENING, Refined, refined

# Of the logarithm of an axis' scale, one sd: of what is still taken for the same part (by hand), and of what
# a true model may have, which moves the pose by a third of what counts as wrong.
STRETCH_SD, TOLERATED_STRETCH_SD = 0.1, 0.003
ENOUGH_SUPPORT = 0.95  # of the visible length, with which another model has nothing to explain
FIT_REACHES_PX = (4.0, 3.0)  # of the fits of stretched models, whose lines are near
STRETCH_STEPS, MOST_STRAIN = 2, 0.3  # of a fit towards its scales, and the largest logarithm of one
BANDS_PX = (1.5, 12.0, 40.0)  # around the lines, in which edges are looked for
FAR_BANDS_PX = (*BANDS_PX, 120.0)  # where one plane of a part is kept, and others are off by all of a stretch
HELD_SUPPORT = 0.6  # of a line whose edge points hold the pose (by hand)
SCANNED = np.r_[-np.arange(2, 26), np.arange(2, 26)] * 0.01  # 2 to 25 %, as logarithms
MOST_PLANES = 2  # ways of keeping one of the part's planes that are followed
SAME_PLANE_SHARE = 1e-3  # of the diameter, between places along an axis that are one (by hand)
# Of the visible length, that a fit must explain besides. By hand: of 120 right poses of drawn scenes eleven
# have one that does, and of 131 wrong models most.
WORTH_EXPLAINED = 0.005
STRAINS = np.zeros((6, 3, 3))  # of the axes, and between two of them: the angle that is no longer a right one
STRAINS[range(3), range(3), range(3)] = 1.0
for _shear, (_one, _other) in enumerate(((0, 1), (0, 2), (1, 2)), start=3):
    STRAINS[_shear, _one, _other] = STRAINS[_shear, _other, _one] = 0.5
BETWEEN_AXES = np.array([[1.0, -1.0, 0.0], [0.0, 1.0, -1.0]])


def misfit(best: Refined) -> Misfit:
    """Look for a stretched model that explains more than a pose's own."""
    step, covariance = strain_of(best.problem.model, best.solution, 3)
    significance = significance_of(step, covariance)
    gain, found = 0.0, np.r_[step, np.zeros(3)]
    starts = _scanned(best) if best.support.supported_fraction < ENOUGH_SUPPORT else []
    itself = refined(best.problem, best.pose, FIT_REACHES_PX, best.spacing_px, COARSENING) if starts else None
    better_one = best if itself is None else itself
    if itself is not None:
        for strain, fit in _followed(best, starts):
            better = fit.support.evidence - itself.support.evidence
            if better > gain and max(np.ptp(strain[:3]), *np.abs(strain[3:])) >= LEAST_STRETCH:
                gain, found, better_one = better, strain, fit
    found[:3] -= found[:3].mean()
    borne_out = better_one.support.evidence / max(better_one.support.confirmed, 1e-9)
    return Misfit(significance, gain, tuple(found.tolist()), borne_out=borne_out)


def stretched(model: Model, strain: Floats) -> Model:
    """The model stretched about its middle by the exponential of a symmetric matrix.

    Parameters
    ----------
    strain
        (3,), logarithms of the scales of its axes; or (6,), followed by the angles, rad, that axes x and y, x
        and z, y and z lean towards each other.
    """
    value, axis = np.linalg.eigh(np.tensordot(strain, STRAINS[: len(strain)], 1))
    return deformed(model, (axis * np.exp(value)) @ axis.T)


def motion_of_strains(samples: Samples, jacobian: Floats, model: Model, pose: Pose) -> Floats:
    """Motion of samples along their normals, px per unit of each of STRAINS, (N, 6)."""
    aside = samples.points - model.middle
    return np.asarray(np.einsum("ni,kij,nj->nk", jacobian[:, 3:] @ pose.matrix, STRAINS, aside))


def strain_of(model: Model, solution: Solution, count: int = 6) -> tuple[Floats, Floats]:
    """The first so many STRAINS that bring the lines onto their edge points, with their covariance."""
    seen = solution.observation
    rates = motion_of_strains(seen.samples, seen.jacobian, model, solution.pose)[:, :count]
    step, covariance = unknowns_of(solution, rates, np.full(count, STRETCH_SD))
    return step[-count:], covariance[-count:, -count:]


def significance_of(strain: Floats, covariance: Floats) -> float:
    """Squared stretch of axes against each other, in units of its covariance and of what is tolerated.

    Of logarithms of the three axes' scales (3,), and their covariance (3, 3).
    """
    between = BETWEEN_AXES @ strain
    covariance = covariance + TOLERATED_STRETCH_SD**2 * np.eye(3)
    return float(between @ np.linalg.solve(BETWEEN_AXES @ covariance @ BETWEEN_AXES.T, between))


def _scanned(best: Refined) -> list[tuple[Floats, Pose]]:
    """One of STRAINS, (6,), with the poses at which lines that have an edge keep it and others get one."""
    pose, model = best.pose, best.problem.model
    near = edges_around(best.problem, pose, BANDS_PX)
    if not near.offset.size:
        return []
    line, px, rows = near.samples.line, near.samples.px, near.jacobian
    held = np.where((np.abs(near.offset) <= BANDS_PX[0]).any(axis=1), px, 0.0)
    holds = np.zeros(len(model.lines), dtype=np.bool_)
    holds[[one.line for one in best.support.lines if one.support >= HELD_SUPPORT]] = True
    held[~holds[line]] = 0.0
    prior = prior_precision(float(np.linalg.norm(pose.translation)), 1.0)[:6]
    rates = motion_of_strains(near.samples, rows, model, pose)
    kept = -np.linalg.solve(
        (rows * held[:, None]).T @ rows + np.diag(prior), rows.T @ (held[:, None] * rates)
    )
    rates = rates + rows @ kept
    itself = explained(rows, near.offset, px, np.zeros(6))
    out = []
    for kind in range(len(STRAINS)):
        along = np.zeros_like(rows)
        along[:, 0] = rates[:, kind]
        gains = [explained(along, near.offset, px, np.r_[log, np.zeros(5)]) - itself for log in SCANNED]
        most = int(np.argmax(gains))
        if gains[most] > WORTH_EXPLAINED:
            log = SCANNED[most]
            out.append((gains[most], log * np.eye(6)[kind], moved(pose, log * kept[:, kind], near.centre)))
    out.sort(key=lambda one: -one[0])
    return [(strain, start) for _, strain, start in out + _from_a_plane(best)]


def _from_a_plane(best: Refined) -> list[tuple[float, Floats, Pose]]:
    """What `_scanned` looks for, where the pose was found by one plane of the part and is right there.

    Texture and what is behind give lines elsewhere an edge, too, so that they seem to hold the pose.
    """
    pose = best.pose
    near = edges_around(best.problem, pose, FAR_BANDS_PX)
    if not near.offset.size:
        return []
    itself = explained(near.jacobian, near.offset, near.samples.px, np.zeros(6))
    along, found = np.zeros_like(near.jacobian), []
    for axis in range(3):
        for plane in _planes(best, axis):
            gains = np.full(len(SCANNED), -itself)
            for k, shift in enumerate(_shifts_from(best, near.samples, axis, plane)):
                along[:, 0] = shift
                gains[k] += explained(along, near.offset, near.samples.px, np.eye(6)[0])
            most = int(np.argmax(gains))
            if gains[most] > WORTH_EXPLAINED:
                log = SCANNED[most]
                kept = pose.translation - math.expm1(log) * plane * pose.matrix[:, axis]
                found.append((gains[most], log * np.eye(6)[axis], Pose(pose.rotation_vector, kept)))
    found.sort(key=lambda one: -one[0])
    return found[:MOST_PLANES]


def _planes(best: Refined, axis: int) -> list[float]:
    """Where on an axis the ends are, and lines across it that have an edge, m from the model's middle."""
    model = best.problem.model
    aside = model.vertices[:, axis] - model.middle[axis]
    held = [one.line for one in best.support.lines if one.support >= HELD_SUPPORT]
    first, last = aside[model.lines[held]].T
    same = SAME_PLANE_SHARE * model.diameter
    out = [float(aside.min()), float(aside.max())]
    for place in first[np.abs(last - first) <= same].tolist():
        if min(abs(place - other) for other in out) > same:
            out.append(place)
    return out


def _shifts_from(best: Refined, samples: Samples, axis: int, plane: float) -> Floats:
    """How far SCANNED move samples along their normals, px, (S, N), if a plane across an axis is kept.

    ``plane`` is where that is beside the model's middle, m.
    """
    points = np.repeat(samples.points[None], len(SCANNED), axis=0)
    from_it = samples.points[:, axis] - best.problem.model.middle[axis] - plane
    points[..., axis] += np.expm1(SCANNED)[:, None] * from_it
    image = best.problem.camera.project(best.pose.apply(points.reshape(-1, 3))).reshape(*points.shape[:2], 2)
    shift = ((image - samples.image) * samples.normal).sum(axis=2)
    return np.where(np.isfinite(shift), shift, np.inf)


def _followed(best: Refined, starts: list[tuple[Floats, Pose]]) -> list[tuple[Floats, Refined]]:
    """Strains (6,) and the fits of models strained so that starts lead to."""
    found = []
    for first, start in starts:
        strain, fit = first, _fitted(best, first, start)
        for _ in range(STRETCH_STEPS):
            if fit is None:
                break
            found.append((strain, fit))
            strain = np.clip(
                strain + strain_of(fit.problem.model, fit.solution)[0], -MOST_STRAIN, MOST_STRAIN
            )
            fit = _fitted(best, strain, fit.pose)
        if fit is not None:
            found.append((strain, fit))
    return found


def _fitted(best: Refined, strain: Floats, start: Pose) -> Refined | None:
    problem = replace(best.problem, model=stretched(best.problem.model, strain))
    return refined(problem, start, FIT_REACHES_PX, best.spacing_px, COARSENING)
