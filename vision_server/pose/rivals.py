"""The other poses that explain the images: those that were found, and turns onto near symmetries."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from geometry.near_symmetries import near_symmetries
from geometry.pose import Pose
from geometry.symmetries import Symmetry
from vision_server.pose.alternatives import image_of
from vision_server.pose.ranking import COARSER, ROUGHLY_NATS, Refined
from vision_server.pose.support import PoseSupport, support_at

SAME = (2.0, 0.01)  # degrees, share of the range: two refined poses that are one (chosen by hand)
TURNED_NATS = 10.0  # of evidence, that a target is turned as its seed pose says (chosen by hand)


def rivals_of(
    found: Sequence[Refined], symmetry: Symmetry, searched: Callable[[Pose], bool]
) -> list[tuple[Pose, PoseSupport, float]]:
    """Rivals of the first of some refined poses: pose, support, and nats that speak against it beforehand.

    Those that a symmetry takes to the first are none.
    """
    best, distinct = found[0], list(found[:1])
    for one in found[1:]:
        if not any(better.ends_at(one.pose, SAME) for better in distinct):
            distinct.append(one)
    out = [(pose, support, TURNED_NATS) for pose, support in turned(best, searched)]
    out += [
        (one.pose, one.support, 0.0) for one in distinct[1:] if not image_of(one.pose, best.pose, symmetry)
    ]
    return out


def turned(best: Refined, searched: Callable[[Pose], bool]) -> list[tuple[Pose, PoseSupport]]:
    """Turns of a target that is nearly symmetric which explain the images as well as ``best``, or better.

    Those outside the search range: `best_first` has looked at the others. A seed pose that is turned wrongly
    leads to a pose that fits most lines; the others tell. Where no image shows these, the seed pose is
    believed.
    """
    found = []
    for turn in near_symmetries(best.problem.model):
        pose, support = best.pose.compose(turn), None
        if searched(pose):
            continue
        for coarser, slack in ((COARSER, ROUGHLY_NATS), (1.0, 0.0)):
            support = support_at(best.problem, pose, coarser * best.spacing_px)
            if support is None or support.evidence <= best.support.evidence - slack:
                break
        else:
            assert support is not None
            found.append((pose, support))
    return found
