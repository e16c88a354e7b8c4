"""Which other poses are searched for and weighed: those that were found, and turns onto near symmetries."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from geometry.near_symmetries import near_symmetries
from geometry.pose import Pose
from geometry.symmetries import Symmetry
from vision_server.pose.alternatives import image_of
from vision_server.pose.places import apart, as_rival
from vision_server.pose.ranking import COARSER, ROUGHLY_NATS, Refined
from vision_server.pose.support import PoseSupport, support_at

# Chosen by hand.
SAME = (2.0, 0.01)  # degrees, share of the range: two refined poses that are one
BEYOND_NATS = 10.0  # of evidence, that a target is turned by no more than its seed pose may be off, ...
BEYOND = 0.5  # ... of the search range's margin: from so far beyond the range on
# That a seed pose is not turned onto a near symmetry. Where turns explain as much, a pose has 0.95 at most:
# of 196 estimates of true models that only their seed pose told from a turn, 195 were right (docs/trust.md).
TURNED_NATS = 9.0
NEARLY_NATS = 7.0  # of evidence that a turn may explain less, and still be a rival
ALIKE = 0.8  # share of the quality of two poses that explain the images alike


def nats_against(beyond: float) -> float:
    """What speaks against a pose that is turned so far beyond the search range, see `turned_beyond`."""
    return BEYOND_NATS * min(1.0, beyond / BEYOND)


def anywhere(_pose: Pose) -> float:
    """How far a pose is beyond the search range where there is no seed pose."""
    return 0.0


def likeliest_first(found: Sequence[Refined], beyond: Callable[[Pose], float]) -> list[Refined]:
    """Refined poses, best first; one within the search range before one beyond it that explains no more.

    ``beyond`` says how far a pose is beyond the search range.
    """

    def likely(one: Refined) -> float:
        return one.support.evidence - nats_against(beyond(one.pose))

    first = found[0]
    alike = [
        one
        for one in found[1:]
        if beyond(one.pose) < beyond(first.pose)
        and one.quality >= ALIKE * first.quality
        and not first.ends_at(one.pose, SAME)
    ]
    best = max((first, *alike), key=likely)
    return [best, *(one for one in found if one is not best)]


def rivals_of(
    found: Sequence[Refined],
    symmetry: Symmetry,
    searched: Callable[[Pose], bool],
    beyond: Callable[[Pose], float],
) -> list[tuple[Pose, PoseSupport, float]]:
    """Rivals of the first of some refined poses: pose, support, and nats that speak against it beforehand.

    Those that a symmetry takes to the first are none; of one elsewhere in the image no more counts than is
    convincing. ``beyond`` says how far a pose is beyond the range.
    """
    best, distinct = found[0], list(found[:1])
    for one in found[1:]:
        if not any(better.ends_at(one.pose, SAME) for better in distinct):
            distinct.append(one)
    own = nats_against(beyond(best.pose))
    out = [(pose, support, TURNED_NATS - own) for pose, support in turned(best, searched)]
    problem = best.problem
    elsewhere = apart(problem.model, problem.camera, [one.pose for one in distinct])[0]
    for one, far in zip(distinct[1:], elsewhere[1:], strict=True):
        if not image_of(one.pose, best.pose, symmetry):
            nats = one.support.evidence_together
            against = nats_against(beyond(one.pose)) + nats - as_rival(nats, bool(far))
            out.append((one.pose, one.support, against - own))
    return out


def turned(best: Refined, searched: Callable[[Pose], bool]) -> list[tuple[Pose, PoseSupport]]:
    """Turns of a nearly symmetric target which explain the images nearly as well as ``best``, or better.

    Those outside the search range: `best_first` has looked at the others. A seed pose that is turned wrongly
    leads to a pose that fits most lines; the others tell. Where no image shows these, turns explain as much
    but for what chance does, and the seed pose is believed by TURNED_NATS.
    """
    found = []
    for turn in near_symmetries(best.problem.model):
        pose, support = best.pose.compose(turn), None
        if searched(pose):
            continue
        for coarser, slack in ((COARSER, ROUGHLY_NATS + NEARLY_NATS), (1.0, NEARLY_NATS)):
            support = support_at(best.problem, pose, coarser * best.spacing_px)
            if support is None or support.evidence <= best.support.evidence - slack:
                break
        else:
            assert support is not None
            found.append((pose, support))
    return found
