"""The poses of a first sight, refined, with what else they may be: turned, or seen from another side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from geometry.pose import Pose, near
from geometry.turns import (
    half_turns,
    near_symmetries_and_products,
    other_sides,
    right_turns,
    rim_middle,
    round_axes,
    spin_rad,
)
from numerics.two_cores import each
from vision_server.pose.observation import PoseProblem
from vision_server.trust.equal_parts import A_PART_NATS, apart
from vision_server.trust.other_hand import Matcher
from vision_server.trust.ranking import (
    COARSE_LACK_NATS,
    COARSENING,
    ONE_BASIN,
    TURNED_LACK_NATS,
    Refined,
    best_first,
    finished,
    led_to,
    roughly,
    with_beside,
)
from vision_server.trust.spun import spun
from vision_server.trust.support import evidence_at, support_at

LOOKED_AT = 10  # hypotheses that are refined (by hand)
SIDES, SIDE_DEG = 3, 20.0  # poses beside which others are looked for, and how far apart (by hand)
LOOKS_TURNED, MOST_TURNS_A_LOOK = 2, 12  # looks that are turned; turns of each that are refined (by hand)
ONE_LOOK_WITHIN = (3.0, 0.005)  # degrees, share of the range: poses that a near symmetry makes one look
# Where first sight lost a pose its best had 2 nats; the hypothesis, 3 % of the range off, was third; the pose
# had 260. Of 60 photographs of drawn parts none changes its answer by matching again under this evidence.
CONVINCING_NATS, MATCHED_AGAIN_STARTS, POSES_A_MATCH = 40.0, 5, 2


def of_most_evidence(problem: PoseProblem, hypotheses: Sequence[Pose], match: Matcher) -> list[Refined]:
    """The hypotheses of a first sight, refined, those beside them and turned; most evidence first.

    ``match`` tells where models fit near a pose; it is asked where nothing that was refined is convincing.

    They show the target from different sides, and there quality, a mean over the lines that are seen, favours
    the side with the fewest: a plate from behind, where all that stands on it is seen too. Evidence adds up.
    """
    turns = near_symmetries_and_products(problem.model)
    firsts = _firsts_of_looks(hypotheses, turns)
    others = [index for index in range(len(hypotheses)) if index not in firsts]
    ordered = [hypotheses[index] for index in firsts + others]
    found = best_first(problem, ordered[:LOOKED_AT], spin_rad(problem.model))
    found.sort(key=_evidence, reverse=True)
    if not found or _evidence(found[0]) < CONVINCING_NATS:
        found = _with_matched_again(problem, found, ordered[:MATCHED_AGAIN_STARTS], match)
    for side in _sides(found):
        beside = with_beside([side])
        found += [one for one in beside if not any(known.ends_at(one.pose, ONE_BASIN) for known in found)]
    out = [one for place in _by_place(problem, found) for one in _turned_at(problem, place, turns)]
    return sorted(out, key=_evidence, reverse=True)


def _by_place(problem: PoseProblem, found: Sequence[Refined]) -> list[list[Refined]]:
    """Some poses by where they are in the image: one list, and one more for each other part they may show."""
    ordered = sorted(found, key=_evidence, reverse=True)
    elsewhere = apart(problem.model, problem.camera, [one.pose for one in ordered])
    firsts: list[int] = []
    places: list[list[Refined]] = []
    for index, one in enumerate(ordered):
        alone = elsewhere[index, firsts].all()
        if not firsts or (alone and _evidence(one) >= A_PART_NATS):
            firsts.append(index)
            places.append([one])
        else:
            places[0 if alone else int(np.argmin(elsewhere[index, firsts]))].append(one)
    return places


def _turned_at(problem: PoseProblem, found: list[Refined], turns: Sequence[Pose]) -> list[Refined]:
    """Poses at one place, the best of them finished, with what these lead to when they are turned."""
    least = _evidence(found[0]) - COARSE_LACK_NATS
    found = [finished(one) if _evidence(one) >= least else one for one in found]
    found = _with_other_sides(problem, sorted(found, key=_evidence, reverse=True))
    looks = [found[index] for index in _firsts_of_looks([one.pose for one in found], turns)[:LOOKS_TURNED]]
    for look in looks:
        if _evidence(look) >= _evidence(looks[0]) - CONVINCING_NATS:
            regular = right_turns(problem.model) if look is looks[0] else ()
            found = _with_turned(found, look, (*turns, *half_turns(problem.model)), regular)
    return found


def _with_matched_again(
    problem: PoseProblem, known: Sequence[Refined], starts: Sequence[Pose], match: Matcher
) -> list[Refined]:
    """Poses with what is found near hypotheses that are matched once more, each seen from just there.

    A first sight's views are coarse: a hypothesis may be some percent of the range off, which a fit to edges
    does not bridge where the part has many lines beside each other.
    """
    found = list(known)
    for start in starts:
        for _, pose in match([problem.model], start)[0][:POSES_A_MATCH]:
            rough = roughly(problem, pose, found)
            if rough is not None:
                found.append(rough)
    return sorted(found, key=_evidence, reverse=True)


def _firsts_of_looks(poses: Sequence[Pose], turns: Sequence[Pose]) -> list[int]:
    """The first of the poses of each look: those that a near symmetry turns into each other are one."""
    firsts: list[int] = []
    turn = np.array([np.eye(3), *(one.matrix for one in turns)])
    shift = np.array([np.zeros(3), *(one.translation for one in turns)])
    rotations, translations = np.empty((0, 3, 3)), np.empty((0, 3))  # of the firsts, turned
    for index, pose in enumerate(poses):
        if not near(rotations, translations, pose, *ONE_LOOK_WITHIN).any():
            firsts.append(index)
            rotations = np.concatenate([rotations, pose.matrix @ turn])
            translations = np.concatenate([translations, pose.apply(shift)])
    return firsts


def _sides(found: Sequence[Refined]) -> list[Refined]:
    """The first few of them that see the target from different sides."""
    out: list[Refined] = []
    for one in found:
        if len(out) < SIDES and all(one.pose.error_to(other.pose).rotation_deg > SIDE_DEG for other in out):
            out.append(one)
    if found and _evidence(found[0]) < 0.0:  # of bad fits a pose as small as a speck misses least
        most = max(found, key=lambda one: one.support.supported_fraction)
        out += [most] if most not in out else []
    return out


def _evidence(one: Refined) -> float:
    return one.support.evidence_together


def _with_other_sides(problem: PoseProblem, known: Sequence[Refined]) -> list[Refined]:
    """Poses with what the first of a nearly round target leads to when its rim is seen from other sides.

    A rim is the same ellipse from before and behind, and tilted the other way; only what is small about it
    tells, and a search that is led by the rim may have come from one side alone.
    """
    found = list(known)
    for axis, centre in round_axes(problem.model) if known else ():
        for start in other_sides(known[0].pose, axis, rim_middle(problem.model, axis, centre)):
            rough = roughly(problem, start, found)
            if rough is None:
                continue
            coarse_px, reach_rad = COARSENING * rough.spacing_px, spin_rad(problem.model)
            starts = spun(rough.problem, rough.pose, coarse_px, reach_rad)
            best = max([rough, *led_to(rough, starts, [rough])], key=_evidence)
            least = _evidence(found[0]) - COARSE_LACK_NATS
            found.append(finished(best) if _evidence(best) >= least else best)
    return sorted(found, key=_evidence, reverse=True)


def _with_turned(
    known: Sequence[Refined], first: Refined, turns: Sequence[Pose], regular: Sequence[Pose]
) -> list[Refined]:
    """Poses with one turned by what nearly brings the target back onto itself, or regular parts of it.

    From behind, a target often looks the same turned so. Of many turns those are refined that fit best; more
    that fit as well as the pose, as a gear's do whose key seat is not seen, are taken as they are. Of
    ``regular`` ones, as of the nut that a pipe's branch stands beside, those that fit nearly as well.
    """
    found, problem, coarse_px = list(known), first.problem, COARSENING * first.spacing_px

    def seen_turned(by: Sequence[Pose]) -> list[tuple[float, Pose]]:
        starts = [first.pose.compose(turn) for turn in by]
        evidence = each(lambda start: evidence_at(problem, start, coarse_px), starts)
        return list(zip(evidence, starts, strict=True))

    itself = evidence_at(problem, first.pose, coarse_px)
    others = seen_turned([turn for turn in regular if turn not in turns])
    seen = seen_turned(turns) + [one for one in others if one[0] > itself - TURNED_LACK_NATS]
    seen.sort(key=lambda one: -one[0])
    alike, least = itself - COARSE_LACK_NATS, _evidence(found[0]) - COARSE_LACK_NATS
    for number, (evidence, start) in enumerate(seen):
        if number < MOST_TURNS_A_LOOK:
            for other in led_to(first, [start], found):
                found.append(finished(other) if _evidence(other) >= least else other)
        elif evidence >= alike and not any(one.ends_at(start, ONE_BASIN) for one in found):
            support = support_at(problem, start, first.spacing_px)
            if support is not None:
                found.append(replace(first, solution=replace(first.solution, pose=start), support=support))
    return found
