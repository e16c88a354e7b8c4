"""From where a target is expected to where it is: a few refinement passes around one pose.

Each frame begins with the look `Sight.near`, and each search ends with it; `far` and `turned` are for frames
in which it does not suffice (see `tracker`). All of them end with a fit to whole lines.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from geometry.rotation import matrix_of
from numerics.arrays import Floats
from vision_server.channels.depth import Pixels
from vision_server.pose.covariance import uncertainty
from vision_server.pose.observation import PoseProblem
from vision_server.pose.refinement import EXACT_REACH_PX, refine
from vision_server.tracking.beside import Beside, beside
from vision_server.tracking.fitting import Fit, Habits, fitted
from vision_server.tracking.frame import Tone, problem_of, window
from vision_server.tracking.motion import Motion
from vision_server.tracking.outermost import outermost
from vision_server.tracking.softness import Softness
from vision_server.tracking.strain import is_strained
from vision_server.trust.alternatives import EQUIVALENT_WITHIN
from vision_server.trust.probability import ERROR_OVER_SD, RIVAL_NATS, belief, quality, shared
from vision_server.trust.support import PoseSupport, support_of

# By hand. Edges are looked for this far from lines near a pose that the motion foresaw; around others 28 px
# far, in pictures of a quarter and half of the size. Farther around, more that is not the target is met.
NEAR_REACHES_PX, FAR_LOOKS = (6.0,), ((4, (7.0, 5.0)), (2, (5.0,)))
WINDOW_MARGIN_PX = 40.0  # of the window around the target: these 28 px, and the filters' reach
# A fit has settled when a step moves no line farther than this. Where a pose that was foreseen has settled to
# the second, its edges are off by 0.02 px more. It takes so many passes at most.
SETTLED_PX, NEAR_SETTLED_PX, MOST_PASSES = 0.3, 1.0, 3
# Of a pose on outermost edges (on 22 films of printed boxes): how far around it is looked, so that those
# inside are left out; by what share of the range it is nearer; what it may lack of quality and evidence.
OUTER_REACHES_PX = (2.0, 2.0)
NEARER_SHARE, PRINT_QUALITY, PRINT_NATS = 0.003, 0.5, 10.0
ACROSS_VIEW = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]])
TRIED_TURNS_RAD = np.radians(6.0) * ACROSS_VIEW  # (by hand)
MOST_CLIMBS = 3  # from pose to pose, each better supported, one after the other


@dataclass(frozen=True, eq=False)
class Found:
    """A pose that a frame was refined to, and what the frame says of it."""

    fit: Fit
    support: PoseSupport
    softness: Softness
    problem: PoseProblem

    @property
    def pose(self) -> Pose:
        """camera_T_target."""
        return self.fit.pose

    @property
    def covariance(self) -> Floats:
        """(6, 6), of a left-multiplied step."""
        return self.fit.covariance

    @cached_property
    def quality(self) -> float:
        """Of the support."""
        return quality(self.support)

    @cached_property
    def _own_belief(self) -> float:
        """Without rivals; the covariance of a fit has the tails already that are meant for an estimate's."""
        return belief(self.support, 0.0, uncertainty(self.covariance, self.pose.translation) / ERROR_OVER_SD)

    def belief(self, ambiguity: float) -> float:
        """Probability that this is where the target is, however exactly, see `probability.belief`."""
        return shared(self._own_belief, ambiguity)

    @cached_property
    def evidence(self) -> float:
        """For it, nats."""
        return self.support.evidence

    def is_at(self, pose: Pose | None) -> bool:
        """Whether it is this pose."""
        return pose is not None and self.pose.error_to(pose).within(*EQUIVALENT_WITHIN)

    def is_strained(self) -> bool:
        """Whether its lines say that the model is too long along an axis."""
        return is_strained(self.problem, self.pose, self.softness.spacing_px)


@dataclass(frozen=True, eq=False)
class Foreseen:
    """What frames before tell of a target that was followed surely, for a look near its pose.

    Attributes
    ----------
    softness : of its lines.
    outer : whether edges outside of it are asked about, wherever it is.
    """

    softness: Softness | None = None
    outer: bool = True


@dataclass(frozen=True, eq=False)
class Sight:
    """What looks at frames: model, camera and tone curve."""

    model: Model
    camera: Camera
    tone: Tone

    def near(
        self, pixels: Pixels, expected: Pose, habits: Habits, foreseen: Foreseen | None = None
    ) -> Found | None:
        """The pose a few pixels around the one expected; None where nothing holds it.

        What frames before tell is ``foreseen`` where the target was followed surely in the last one.
        """
        seen = window(pixels, self.model, self.camera, expected, WINDOW_MARGIN_PX)
        if seen is None:
            return None
        sharp, known = problem_of(seen, self.model, self.tone), foreseen or Foreseen()
        kept = known.softness
        if kept is not None and not kept.holds(self.model, self.camera, expected):
            kept = None
        own = kept or Softness.measured(sharp, expected)
        problem = replace(sharp, scale=own.scale)
        first = refine(problem, expected, NEAR_REACHES_PX, own.spacing_px)
        if first is None:
            return None
        line = first.observation.samples.line
        if kept is not None and not kept.holds(self.model, self.camera, first.pose, line):
            own = Softness.measured(sharp, first.pose)
            problem = replace(sharp, scale=own.scale)
        return on_lines(problem, first.pose, own, habits, None if known.outer else expected)

    def far(self, pixels: Pixels, expected: Sequence[Pose], habits: Habits) -> list[Found]:
        """The same some 30 px around each of the poses, by way of smaller pictures; best first."""
        found = []
        for start in expected:
            seen, pose = window(pixels, self.model, self.camera, start, WINDOW_MARGIN_PX), start
            if seen is None:
                continue
            for factor, reaches in FAR_LOOKS:
                solution = refine(problem_of(seen.smaller(factor), self.model, self.tone), pose, reaches)
                if solution is None:
                    break
                pose = solution.pose
            if (one := self.near(pixels, pose, habits)) is not None:
                found.append(one)
        return sorted(found, key=lambda one: -one.quality)

    def turned(self, pixels: Pixels, found: Sequence[Found], habits: Habits) -> list[Found]:
        """What the best supported pose leads to if it is turned, as long as that is better supported.

        Slender and flat things show nearly the same from two sides of the line of sight, and lines of the one
        pose hold it where those of the other are beside them: no small search comes from there to the other.
        What less than nothing supports is not told: turns then lead anywhere.
        """
        better = [max(found, key=lambda one: one.evidence)]
        for _ in range(MOST_CLIMBS):
            starts = (turned_about(better[-1].pose, self.model.middle, turn) for turn in TRIED_TURNS_RAD)
            turned = [one for start in starts if (one := self.near(pixels, start, habits)) is not None]
            best = max(turned, key=lambda one: one.evidence, default=better[-1])
            if best.evidence < better[-1].evidence + RIVAL_NATS:
                break
            better.append(best)
        return [one for one in better[1:] if one.evidence > 0.0]


def likeliest(found: Sequence[Found], expected: Motion, middle: Floats) -> Found:
    """The pose for which lines and motion speak most together; ``middle`` (3,) of the target, m.

    Print may look better than the edge beside it, and the motion knows which it was; but of a small target
    seen from the front, turned one way or the other, the motion may foresee the wrong one, and lines tell.
    """

    def nats(one: Found) -> float:
        surprise = expected.innovation(one.pose, one.covariance, middle).squared
        return one.evidence / RIVAL_NATS - 0.5 * surprise

    return max(found, key=nats)


def looked_again(
    found: Found, start: Pose, habits: Habits, back: tuple[float, float] | None = None
) -> Found | None:
    """What the frame of a pose makes of another start near it, with lines as soft; None as in `near`.

    None, too, where the first step leads ``back``: to within so many degrees and share of the range.
    """
    first = refine(found.problem, start, NEAR_REACHES_PX, found.softness.spacing_px)
    if first is None or (back is not None and first.pose.error_to(found.pose).within(*back)):
        return None
    return on_lines(found.problem, first.pose, found.softness, habits)


def turned_about(pose: Pose, middle: Floats, turn: Floats) -> Pose:
    """A pose turned by a rotation vector of the camera's frame about the target's middle (3,), m."""
    matrix = matrix_of(turn) @ pose.matrix
    return Pose.from_matrix(matrix, pose.apply(middle[None])[0] - matrix @ middle)


def on_lines(
    problem: PoseProblem, near: Pose, softness: Softness, habits: Habits, as_far: Pose | None = None
) -> Found | None:
    """Fitted to whole lines from nearby; on the outermost edges where those inside of them may be print.

    The latter is not asked of a pose no farther away than another one, ``as_far``: on print it would be.
    """
    around = beside(problem, near)
    found = _fitted(problem, near, (EXACT_REACH_PX, NEAR_SETTLED_PX), softness, habits, around)
    middle = problem.model.middle
    if found is not None and as_far is not None and not _is_farther(found.pose, as_far, middle):
        return found
    outer = outermost(problem, near, around)
    if found is None or outer is None:
        return found
    refined = refine(problem, outer, OUTER_REACHES_PX, softness.spacing_px)
    if refined is None:
        return found
    around = beside(problem, refined.pose)
    other = _fitted(problem, refined.pose, (OUTER_REACHES_PX[-1], SETTLED_PX), softness, habits, around)
    return other if other is not None and _is_print(found, other, middle) else found


def _is_farther(one: Pose, other: Pose, middle: Floats, share: float = 0.5 * NEARER_SHARE) -> bool:
    """Whether a target with this middle (3,) is farther away at the one pose, by a share of its range."""
    far, near = (float(np.linalg.norm(pose.apply(middle[None]))) for pose in (one, other))
    return near <= (1.0 - share) * far


def _is_print(found: Found, outer: Found, middle: Floats) -> bool:
    """Whether one pose is on print, and the target's is the other one, nearer and outside of it.

    Print explains the edges of the first; of the second, chance would have to explain those outside.
    """
    if not _is_farther(found.pose, outer.pose, middle, NEARER_SHARE):
        return False
    if outer.quality < PRINT_QUALITY * found.quality:
        return False
    return outer.evidence >= found.evidence - PRINT_NATS


def _fitted(
    problem: PoseProblem,
    pose: Pose,
    looks_px: tuple[float, float],
    softness: Softness,
    habits: Habits,
    around: Beside,
) -> Found | None:
    """Fitted to whole lines in a few passes; ``looks_px``: the reach, and a step that is settled."""
    reach_px, settled_px = looks_px
    fit, variance = None, around.variance_px2
    for _ in range(MOST_PASSES):
        fit = fitted(problem, pose, reach_px, softness.spacing_px, habits, variance)
        if fit is None:
            return None
        pose = fit.pose
        if fit.moved_px < settled_px:
            break
    assert fit is not None
    names = [channel.name for channel in problem.channels]
    return Found(fit, support_of(fit.observation, names), softness, problem)
