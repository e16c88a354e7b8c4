"""Which other poses are weighed, found ones and turns of the best, and what speaks against each before."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

from geometry.near_symmetries import near_symmetries
from geometry.pose import Pose
from geometry.symmetries import Symmetry, turned_towards
from geometry.turns import free_turns
from vision_server.trust.alternatives import image_of
from vision_server.trust.equal_parts import apart, as_rival
from vision_server.trust.likely import Likely
from vision_server.trust.ranking import COARSE_LACK_NATS, COARSENING, Refined
from vision_server.trust.support import PoseSupport, support_at
from vision_server.trust.told_apart import evidence_apart

ONE_RIVAL_WITHIN = (2.0, 0.01)  # degrees, share of the range: two refined poses are one (by hand)
# By hand: nats that a target is off its seed pose by no more than this part of the range's margin.
BEYOND_NATS, BEYOND_MARGINS = 10.0, 0.5
# That a seed pose is not turned onto a near symmetry. Where turns explain as much, a pose has 0.95 at most:
# of 196 estimates of true models that only their seed pose told from a turn, 195 were right (docs/trust.md).
TURNED_NATS = 9.0
RIVAL_LACK_NATS = 7.0  # that a turn may explain less, and still have odds of a tenth as a rival (by hand)
# By hand: share of the first one's quality from which a pose may go before it; and of one that explains more
# by so many nats.
ALIKE_QUALITY_SHARE, CLEARLY_QUALITY_SHARE, CLEARLY_NATS = 0.8, 0.5, 12.0


class RivalPose(NamedTuple):
    """Another pose than the first, and how many nats more speak for it; as a rule fewer do.

    ``turned``: it is the first one, turned onto a near symmetry of the target.
    """

    pose: Pose
    nats: float
    turned: bool = False


def nats_against(beyond: float) -> float:
    """What speaks against a pose that is so far beyond the search range (within it: less than 0), nats."""
    return BEYOND_NATS * min(1.0, max(0.0, beyond) / BEYOND_MARGINS)


def likeliest_first(found: Sequence[Refined], beyond: Callable[[Pose], float]) -> list[Refined]:
    """Refined poses, best first; one nearer to the seed pose before one farther off that explains no more.

    Also one that explains clearly more: quality, a mean over the lines in sight, favours the side of a round
    part on which there is nothing to see. ``beyond`` says how far a pose is beyond the search range; within
    it that is less than 0.
    """

    def likely(one: Refined) -> float:
        return one.support.evidence - nats_against(beyond(one.pose))

    first = found[0]

    def may_go_before(one: Refined) -> bool:
        if likely(one) >= likely(first) + CLEARLY_NATS:
            return one.quality >= CLEARLY_QUALITY_SHARE * first.quality
        return beyond(one.pose) < beyond(first.pose) and one.quality >= ALIKE_QUALITY_SHARE * first.quality

    alike = [one for one in found[1:] if may_go_before(one) and not first.ends_at(one.pose, ONE_RIVAL_WITHIN)]
    best = max((*alike, first), key=likely)  # the first of those that explain as much
    return [best, *(one for one in found if one is not best)]


def rivals_of(
    found: Sequence[Refined],
    symmetry: Symmetry,
    searched: Callable[[Pose], bool],
    beyond: Callable[[Pose], float],
) -> list[RivalPose]:
    """Rivals of the first of some refined poses, which a search from a seed pose has found.

    Those that a symmetry takes to the first are none; of one elsewhere in the image no more counts than is
    convincing. ``beyond`` says how far a pose is beyond the range. No pose has taken the last step: it would
    be an advantage over those that have not.
    """
    best, distinct = found[0], list(found[:1])
    for one in found[1:]:
        if not any(better.ends_at(one.pose, ONE_RIVAL_WITHIN) for better in distinct):
            distinct.append(one)
    against_best = nats_against(beyond(best.pose))

    def turn(pose: Pose, support: PoseSupport, against: float) -> RivalPose:
        return RivalPose(pose, evidence_apart(support, best.support) - against + against_best, True)

    def of_turn(pose: Pose) -> float:
        return nats_against(beyond(pose)) if searched(pose) else TURNED_NATS

    turns = _turns_of(best)
    out = [turn(pose, support, of_turn(pose)) for pose, support in turned(best)]
    out += [turn(pose, support, nats_against(beyond(pose))) for pose, support in turned_round(best)]
    problem = best.problem
    elsewhere = apart(problem.model, problem.camera, [one.pose for one in distinct])[0]
    for one, far in zip(distinct[1:], elsewhere[1:], strict=True):
        if image_of(one.pose, best.pose, symmetry):
            continue
        if not any(one.ends_at(pose, ONE_RIVAL_WITHIN) for pose in turns):
            nats = as_rival(one.support.evidence, bool(far)) - nats_against(beyond(one.pose))
            out.append(RivalPose(one.pose, nats - best.support.evidence + against_best))
            continue
        rival = turn(one.pose, one.support, of_turn(one.pose))
        exact = [known for known in out if one.ends_at(known.pose, ONE_RIVAL_WITHIN)]
        if all(known.nats < rival.nats for known in exact):
            out = [*(known for known in out if known not in exact), rival]
    return out


def symmetric_images(pose: Pose, symmetry: Symmetry, beyond: Callable[[Pose], float]) -> list[RivalPose]:
    """What a target's symmetries make of a pose within the range, or nearly: no image tells them apart.

    Their evidence would differ by noise.
    """
    images = [turned_towards(pose.compose(turn), pose, symmetry) for turn in symmetry.turns[1:]]
    against = [nats_against(beyond(image)) for image in images]
    itself = nats_against(beyond(pose))
    return [
        RivalPose(image, itself - nats, True)
        for image, nats in zip(images, against, strict=True)
        if nats < BEYOND_NATS
    ]


def rivals_at_first_sight(likely: Sequence[Likely], symmetry: Symmetry) -> list[RivalPose]:
    """Rivals of the first of the poses that are likely where there was no seed pose.

    Nothing speaks against its turns beforehand. Those are compared with it as it was refined, and the other
    poses after the last step.
    """
    first, found = likely[0], []
    best = first.refined
    for pose, support in (*turned(best), *turned_round(best)):
        if not image_of(pose, best.pose, symmetry):
            nats = evidence_apart(support, best.support, together=True)
            found.append(RivalPose(pose, nats, True))
    turns, problem = _turns_of(best), best.problem
    poses = [one.last.best.pose for one in likely]
    elsewhere = apart(problem.model, problem.camera, poses)[0]
    for one, pose, far in zip(likely[1:], poses[1:], elsewhere[1:], strict=True):
        is_turn = any(one.refined.ends_at(turn, ONE_RIVAL_WITHIN) for turn in turns)
        found.append(RivalPose(pose, as_rival(one.nats, bool(far)) - first.nats, is_turn))
    return found


def turned(best: Refined) -> list[tuple[Pose, PoseSupport]]:
    """Turns of a nearly symmetric target which explain the images nearly as well as ``best``, or better.

    Also those within the search range, which `best_first` has looked at. A seed pose that is turned wrongly
    leads to a pose that fits most lines; the others tell. Where no image shows these, turns explain as much,
    and the seed pose is believed by TURNED_NATS.
    """
    return list(_nearly_as_likely(best, _turns_of(best)))


def _turns_of(best: Refined) -> list[Pose]:
    """A pose, turned onto each near symmetry of its target."""
    return [best.pose.compose(turn) for turn in near_symmetries(best.problem.model)]


def turned_round(best: Refined) -> list[tuple[Pose, PoseSupport]]:
    """Of the turns of a nearly round target about each such axis the likeliest that explains nearly as much.

    Rims fit at any of them, and noise or a light on them holds one turn as exactly as a lug would: what is
    small about a target and tells must be seen.
    """
    found = []
    for turns in free_turns(best.problem.model):
        poses = [best.pose.compose(turn) for turn in turns]
        alike = list(_nearly_as_likely(best, poses))
        if alike:
            found.append(max(alike, key=lambda one: evidence_apart(one[1], best.support)))
    return found


def _nearly_as_likely(best: Refined, poses: Sequence[Pose]) -> Iterator[tuple[Pose, PoseSupport]]:
    """Those of some poses, with their support, that explain RIVAL_LACK_NATS less than the best at most."""
    least = best.support.evidence - COARSE_LACK_NATS - RIVAL_LACK_NATS
    for pose in poses:
        coarse = support_at(best.problem, pose, COARSENING * best.spacing_px)
        if coarse is None or coarse.evidence <= least:
            continue
        support = support_at(best.problem, pose, best.spacing_px)
        if support is not None and evidence_apart(support, best.support) > -RIVAL_LACK_NATS:
            yield pose, support
