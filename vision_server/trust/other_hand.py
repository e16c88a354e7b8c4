"""Is the model the right way round? Where much of it is not seen, a mirrored or turned one is tried.

A model that is mirrored, or lies upside down, fits the outline of the part at a pose near by, but has what
stands on the part on its other side: its lines are missing there, or it shows its plain back, few lines, all
of them seen. The same model the other way round explains what the images show.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from geometry.deformed import deformed
from geometry.model import Model
from geometry.pose import RIGHT, Pose
from numerics.arrays import Floats
from vision_server.pose.line_scales import with_line_scales
from vision_server.trust.probability import MOST_ODDS, odds
from vision_server.trust.ranking import COARSE_REACHES_PX, COARSENING, Refined, refined
from vision_server.trust.support import support_at

Matcher = Callable[[Sequence[Model], Pose], list[list[tuple[float, Pose]]]]

# The lines in sight say that the model is the right way round where no more than this share of their length
# is missing, and they are more than a plain box shows or more than are out of sight (chosen by hand).
LITTLE_MISSING, FEW_IN_SIGHT, HIDDEN_SHARE = 0.015, 9, 0.5
# Nats of evidence that a model is unlikely to be the wrong way round, and that it is so where the other way
# fits at the same pose, which is right then in any case (by hand).
UNLIKELY_NATS, SAME_POSE_NATS = 10.0, 18.0
AS_GOOD_SHARE = 0.95  # of the model's own score, from which on another way is worth a look (by hand)
# At the pose itself: less of evidence, before it is refined, another way is not worth a look (by hand),
# which is with so many times fewer samples.
HERE_NATS, HERE_COARSENING = 30.0, 3.0
# What the other way leaves unexplained, beyond what two fits differ by anyway, counts so many times more: one
# thing in the way hides many lines. A plain back then misses less than a front that is half hidden, but has
# fewer of the edges (chosen by hand).
LOST_TIMES, LITTLE_LOST_NATS = 3.0, 5.0
SAME_CORNERS_SHARE = 1e-3  # of the diameter, between corners of one model and of a same one (by hand)
FIRST_CORNERS = 16  # that are asked first whether two models are the same
FEW_CORNERS = 500  # are all held against all: in 15 ms, a tenth of what it takes to load SciPy
WAYS = tuple(np.diag(signs) for signs in np.array(
    [[-1, 1, 1], [1, -1, 1], [1, 1, -1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=np.float64
))  # fmt: skip


@lru_cache(maxsize=4)
def other_ways(model: Model) -> tuple[Model, ...]:
    """The model mirrored and turned by half about each axis, where that makes another one; each once."""
    out = [model]
    for way in WAYS:
        other = deformed(model, way)
        if not any(_same(other, known) for known in out):
            out.append(other)
    return tuple(out[1:])


def _same(one: Model, other: Model) -> bool:
    """Whether two models have the same corners."""
    most = SAME_CORNERS_SHARE * one.diameter
    if _apart(one.vertices[:: max(1, len(one.vertices) // FIRST_CORNERS)], other.vertices) > most:
        return False  # so with nearly all other models
    if len(one.vertices) <= FEW_CORNERS:
        return _apart(one.vertices, other.vertices) <= most
    from scipy.spatial import cKDTree  # late: few models need it, and it takes a quarter of a start

    apart, _ = cKDTree(other.vertices).query(one.vertices)
    return float(apart.max()) <= most


def _apart(some: Floats, corners: Floats) -> float:
    """The largest distance of any of some points (M, 3) from the nearest of the corners (N, 3)."""
    return float(np.linalg.norm(some[:, None] - corners, axis=2).min(axis=1).max())


def the_other_way(best: Refined, match: Matcher) -> float:
    """Chance that the model is mirrored or turned by half over that it is not, at most MOST_ODDS.

    Parameters
    ----------
    match
        Scores and poses of each of some models from the same segments, near a pose, best first.
    """
    seen, lines = len(np.unique(best.support.samples.line)), len(best.problem.model.lines)
    few = seen <= min(FEW_IN_SIGHT, (1.0 - HIDDEN_SHARE) * lines)
    if best.support.missing <= LITTLE_MISSING and not few:
        return 0.0
    model = best.problem.model
    others = other_ways(model)
    if not others:
        return 0.0
    itself, *found = match((model, *others), best.pose)
    least = itself[0][0] if itself else 0.0
    likely = [
        (other, one[0][1])
        for other, one in zip(others, found, strict=True)
        if one and one[0][0] > AS_GOOD_SHARE * least
    ]
    likely += [(other, best.pose) for other in others if _is_likely_here(best, other)]
    fits = [_fit(best, other, pose) for other, pose in likely]
    return max((_chance(best, fit) for fit in fits if fit is not None), default=0.0)


def _chance(own: Refined, other: Refined) -> float:
    """Chance of the other way over the model's own, at most MOST_ODDS."""
    same = other.pose.error_to(own.pose).within(*RIGHT)
    lost = max(0.0, own.support.confirmed - other.support.confirmed - LITTLE_LOST_NATS)
    unlikely = (SAME_POSE_NATS if same else UNLIKELY_NATS) + LOST_TIMES * lost
    return odds(other.support.evidence - own.support.evidence - unlikely, MOST_ODDS)


def _is_likely_here(own: Refined, other: Model) -> bool:
    """Whether another model explains about as much at the pose itself.

    What stands on a part is little of it. Where the rest is alike on both sides, the other way is at the same
    pose; its few segments need not be among those that a match is made from.
    """
    of_same_softness = replace(own.problem, model=other)  # each line as soft as the model's own
    support = support_at(of_same_softness, own.pose, HERE_COARSENING * own.spacing_px)
    return support is not None and support.evidence > own.support.evidence - HERE_NATS


def _fit(own: Refined, other: Model, pose: Pose) -> Refined | None:
    """What another model's hypothesis leads to."""
    sharp = replace(own.problem, model=other, scale=np.zeros_like(own.problem.scale))
    return refined(with_line_scales(sharp, pose), pose, COARSE_REACHES_PX, own.spacing_px, COARSENING)
