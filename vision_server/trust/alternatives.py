"""Which poses an estimate tells, and the chance of each; a symmetry's images are one answer, or share it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from geometry.pose import Pose, near
from geometry.symmetries import Symmetry, turned_towards
from numerics.arrays import Flags, Floats
from vision_server.trust.equal_parts import as_rival
from vision_server.trust.probability import RIVAL_NATS

# Chosen by hand: three times what makes a pose wrong, so that two fits of one look are told as one.
EQUIVALENT_WITHIN = (3.0, 0.03)  # degrees, share of the range: one pose, or its image by a symmetry
# A pose is listed from this chance on; or, if less, from this share of what each would have if all that are
# likely had the same, as a gear's turns have (by hand).
LEAST_LISTED_CHANCE, LEAST_OF_EVEN_CHANCE = 0.01, 0.1


@dataclass(frozen=True, eq=False)
class PoseChance:
    """One of the poses that fit, and the probability that it is the right one."""

    pose: Pose
    probability: float


def equivalent(one: Pose, other: Pose, symmetry: Symmetry) -> bool:
    """Whether a symmetry of the target takes one pose to the other, within EQUIVALENT_WITHIN."""
    if symmetry.free_axis is None:
        turn = np.array([pose.matrix for pose in symmetry.turns]).reshape(-1, 3, 3)
        shift = np.array([pose.translation for pose in symmetry.turns]).reshape(-1, 3)
        return bool(near(one.matrix @ turn, one.apply(shift), other, *EQUIVALENT_WITHIN).any())
    turned = (turned_towards(one.compose(turn), other, symmetry) for turn in symmetry.turns)
    return any(pose.error_to(other).within(*EQUIVALENT_WITHIN) for pose in turned)


def image_of(one: Pose, other: Pose, symmetry: Symmetry) -> bool:
    """Whether a pose is another one turned by a symmetry, and so no rival of it."""
    real = symmetry.turns if symmetry.free_axis is not None else symmetry.turns[1:]
    return equivalent(one, other, replace(symmetry, turns=real))


def distinct_of(poses: Sequence[Pose], symmetry: Symmetry) -> list[int]:
    """Which of some poses are not another one before them, or its image by a symmetry."""
    distinct: list[int] = []
    for index, pose in enumerate(poses):
        if not any(equivalent(pose, poses[known], symmetry) for known in distinct):
            distinct.append(index)
    return distinct


def shares(nats: Floats, elsewhere: Flags) -> list[float]:
    """What each of N poses, of such evidence (N,), has of it, against those that are rivals of it.

    Of those ``elsewhere`` (N, N) in the image no more counts than is convincing, see `as_rival`.
    """
    out = []
    for own, others in zip(nats, elsewhere, strict=True):
        against = [as_rival(float(other), bool(far)) for other, far in zip(nats, others, strict=True)]
        out.append(1.0 / float(np.exp((np.array(against) - own) / RIVAL_NATS).sum()))
    return out


def listed(
    likely: Sequence[tuple[Pose, float]],
    symmetry: Symmetry,
    allowed: Callable[[Pose], bool] = lambda _pose: True,
) -> tuple[PoseChance, ...]:
    """Distinct poses and the images of each by the target's symmetries, which share its probability.

    Parameters
    ----------
    likely
        Poses and the probability that each is the right one.
    allowed
        Whether an image of a pose may be, by what is known beforehand.
    """
    out = []
    least = min(LEAST_LISTED_CHANCE, LEAST_OF_EVEN_CHANCE / max(1, len(likely)))
    for pose, probability in likely:
        turned = [pose.compose(turn) for turn in symmetry.turns[1:]]
        images = [pose, *(image for image in turned if allowed(image))]
        if probability >= least:
            out += [PoseChance(image, probability / len(images)) for image in images]
    return tuple(out)


def without_free_turn(covariance: Floats, pose: Pose, symmetry: Symmetry) -> Floats:
    """The covariance (6, 6) of a pose whose turn about the free axis is taken for given."""
    if symmetry.free_axis is None:
        return covariance
    held = np.r_[pose.matrix @ symmetry.free_axis, np.zeros(3)]
    pull = covariance @ held
    return np.asarray(covariance - np.outer(pull, pull) / (held @ pull))
