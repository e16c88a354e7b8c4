"""Poses of a nearly round part that are turned about its axis: rims fit all of them, only the bolts tell.

A search is led by the large rims, and ends at any turn about their axis; refinement looks no farther than a
few pixels beside each line. So all turns are looked at, so close to each other that no line is passed over.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from geometry.model import Model
from geometry.pose import Pose
from geometry.turns import folds_about, round_axes, turned_about
from numerics.arrays import Floats
from numerics.two_cores import each
from vision_server.pose.observation import PoseProblem
from vision_server.trust.support import CAP_PX, PoseSupport, support_at

SPIN_STEP_PX = 1.5 * CAP_PX  # of the farthest point between two turns: its edge is seen from one of both
LEAST_STEP_RAD, MOST_STEP_RAD = math.radians(1.5), math.radians(6.0)
# Between the best turn and the median one: evidence of an image, and share of the visible length. On 16 views
# of a flange of 128 segments 8 to 24 and 0.03 to 0.08 where the best turn was often wrong, 42 to 118 and 0.08
# to 0.22 where the holes were seen.
UNSEEN_SPREAD = (30.0, 0.06)
# Turns that are looked at for that: all around, or an n-th of it where it has n folds, but so many at least.
MOST_TURNS_ALL_AROUND, LEAST_TURNS_A_FOLD = 48, 8
STRONGER = 0.03  # strength by which a turn must be better; two that differ by less are alike
MOST_UNCLEAR_TURNS = 2  # turns that are looked at where none is clearly better (chosen by hand)


def spun(problem: PoseProblem, pose: Pose, spacing_px: float, reach_rad: float) -> list[Pose]:
    """The least turn of a pose about each axis of a nearly round model that is clearly better supported.

    Of bolts that look alike many turns do; the least one is nearest to what is known of the pose. Where none
    is clearly better, as of a tank that has but one small lug, the few at which most is seen.

    Parameters
    ----------
    spacing_px
        Between the samples of a line.
    reach_rad
        How far to turn, to either side.
    """
    out: list[Pose] = []
    for turns, found in _all_turns(problem, pose, spacing_px, reach_rad):
        count = len(turns) // 2
        strength = np.array([0.0 if support is None else support.strength for support in found])
        peaks = _peaks(strength)
        clear = peaks[strength[peaks] >= max(strength[count], strength.max() - 2.0 * STRONGER) + STRONGER]
        seen_px = np.array([0.0 if one is None else one.strength * one.samples.px.sum() for one in found])
        if len(clear):
            out.append(turns[clear[np.argmin(np.abs(clear - count))]])
        else:
            most = sorted(_peaks(seen_px), key=lambda k: -seen_px[k])[:MOST_UNCLEAR_TURNS]
            out += [turns[k] for k in most if abs(k - count) > 1 and seen_px[k] > seen_px[count]]
    return out


def all_around(
    problem: PoseProblem, pose: Pose, spacing_px: float, reach_rad: float, most: int
) -> list[Pose]:
    """About each axis of a nearly round model, the turns of a pose that most speaks for, however little.

    Parameters as of `spun`; ``most`` turns about an axis, without those next to the pose.
    """
    out: list[Pose] = []
    for turns, found in _all_turns(problem, pose, spacing_px, reach_rad):
        nats = np.array([0.0 if support is None else support.evidence for support in found])
        peaks = [k for k in _peaks(nats).tolist() if abs(k - len(turns) // 2) > 1]
        out += [turns[k] for k in sorted(peaks, key=lambda k: -nats[k])[:most]]
    return out


def _all_turns(
    problem: PoseProblem, pose: Pose, spacing_px: float, reach_rad: float
) -> Iterator[tuple[list[Pose], list[PoseSupport | None]]]:
    """About each axis, a pose turned by all steps within reach, itself in the middle, and their support."""
    for axis, centre in round_axes(problem.model) if reach_rad > 0.0 else ():
        step = _step(problem.model, axis, centre, pose, problem.camera.fx)
        count = math.ceil(min(reach_rad, math.pi) / step)
        turns = [turned_about(pose, axis, centre, step * k) for k in range(-count, count + 1)]
        yield turns, each(lambda one: support_at(problem, one, spacing_px), turns)


def unseen_turns(problem: PoseProblem, pose: Pose, spacing_px: float) -> tuple[Floats, ...]:
    """The axes of a nearly round model about which no turn of a pose fits the images much better than others.

    Seen from its side a flange shows slivers of its holes, and noise decides which turn fits best. Turns are
    looked at as far as none is one that changes nothing.

    Parameters
    ----------
    spacing_px
        Between the samples of a line; every second of them is looked at.
    """
    out = []
    for axis, centre in round_axes(problem.model):
        step = _step(problem.model, axis, centre, pose, problem.camera.fx)
        folds = folds_about(problem.model, axis)
        turns = np.arange(0.0, 2.0 * math.pi / folds, step)
        most = max(LEAST_TURNS_A_FOLD, MOST_TURNS_ALL_AROUND // folds)
        some = turns[np.unique(np.linspace(0, len(turns) - 1, most).astype(int))]
        starts = [turned_about(pose, axis, centre, turn) for turn in some]
        found = each(lambda one: support_at(problem, one, 2.0 * spacing_px), starts)
        told = np.array([(one.evidence, one.strength) for one in found if one is not None]).reshape(-1, 2)
        if len(told) and (np.ptp([told.max(axis=0), np.median(told, axis=0)], axis=0) < UNSEEN_SPREAD).any():
            out.append(axis)
    return tuple(out)


def _peaks(values: Floats) -> NDArray[np.intp]:
    """Where values (N,) are no less than those beside them."""
    return np.flatnonzero(values >= np.maximum(np.r_[0.0, values[:-1]], np.r_[values[1:], 0.0]))


def _step(model: Model, axis: Floats, centre: Floats, pose: Pose, focal_px: float) -> float:
    """By how much two turns about an axis differ, rad."""
    aside = np.linalg.norm(np.cross(model.vertices - centre, axis), axis=1).max()
    radius_px = float(aside * focal_px / np.linalg.norm(pose.translation))
    return min(max(SPIN_STEP_PX / max(radius_px, 1.0), LEAST_STEP_RAD), MOST_STEP_RAD)
