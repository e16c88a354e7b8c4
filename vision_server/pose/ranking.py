"""From the matcher's hypotheses to refined poses with their support, best first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from geometry.pose import Pose
from geometry.symmetry import near_symmetries
from vision_server.pose.hypotheses import edges_around, hypotheses_beside
from vision_server.pose.line_scales import line_scales
from vision_server.pose.observation import PoseProblem
from vision_server.pose.refinement import EXACT_REACH_PX, Solution, refine
from vision_server.pose.sampling import spacing_for
from vision_server.pose.support import PoseSupport, support_at
from vision_server.pose.trust import quality

SAME = (0.15, 0.001)  # degrees, share of the range: a step that ends this close has come to a known pose
NEAR = (0.5, 0.004)  # of coarsely refined poses, when both would end at one place
REFINED = 5  # hypotheses of the matcher that are looked at
COARSE_REACHES_PX, COARSER = (6.0, 4.0), 1.75  # first, with fewer samples; ...
FINE_REACHES_PX = (4.0, 3.0, 3.0)  # ... then, with all, ...
FINISHED_SHARE = 0.5  # ... those of at least this share of the best one's quality
SETTLED_PX = 0.03  # a step that moves no line farther is the last one
CLEAR_QUALITY = 2.0  # from here on, nothing beside the pose can be as good
BESIDE = 6  # starts that are looked at beside the best pose
BESIDE_ROUNDS = 3  # and again when that has found a better one
ROUGHLY = 0.7  # of a quality, that fewer samples may see of it
TURNED_BETTER = 1.3  # times the quality: then the target is turned otherwise than the seed pose says


@dataclass(frozen=True, eq=False)
class Refined:
    """A refined pose, what it was refined on, what supports it, and its samples' spacing, px."""

    problem: PoseProblem
    solution: Solution
    support: PoseSupport
    spacing_px: float

    @property
    def pose(self) -> Pose:
        """camera_T_target."""
        return self.solution.pose

    @property
    def quality(self) -> float:
        """Of the support."""
        return quality(self.support)

    def ends_at(self, pose: Pose, limits: tuple[float, float]) -> bool:
        """Whether it is this pose, within so many degrees and that share of the range."""
        return pose.error_to(self.pose).within(*limits)


def best_first(problem: PoseProblem, hypotheses: Sequence[Pose]) -> list[Refined]:
    """The hypotheses, refined, best first.

    All are looked at coarsely; those that come near the best in quality are refined to the end.

    Parameters
    ----------
    problem
        Its scales are the least that are used.
    """
    coarse: list[Refined] = []
    for pose in hypotheses[:REFINED]:
        scaled = replace(problem, scale=line_scales(problem, pose))
        spacing = spacing_for(problem.model, problem.camera, pose)
        rough = refined(scaled, pose, COARSE_REACHES_PX, spacing, COARSER, known=coarse)
        if rough is not None:
            coarse.append(rough)
    coarse.sort(key=lambda one: -one.quality)
    for _ in range(BESIDE_ROUNDS if coarse else 0):
        first = coarse[0]
        if first.quality >= CLEAR_QUALITY:
            break
        add_beside(coarse)
        if coarse[0] is first:
            break
    distinct: list[Refined] = []
    for one in coarse:
        if not any(better.ends_at(one.pose, NEAR) for better in distinct):
            distinct.append(one)
    least = FINISHED_SHARE * coarse[0].quality if coarse else 0.0
    out = [finished(one) if one.quality >= least else one for one in distinct]
    return sorted(out, key=lambda one: -one.quality)


def refined(
    problem: PoseProblem,
    pose: Pose,
    reaches_px: Sequence[float],
    spacing_px: float,
    coarser: float = 1.0,
    known: Sequence[Refined] = (),
) -> Refined | None:
    """One pose refined at some reaches; None where nothing holds it or it ends at a known one.

    ``coarser`` times ``spacing_px`` apart are the samples. Once the pose is near its place, reaches that
    would not move it are left out.
    """
    spacing = coarser * spacing_px
    solution = None
    for reach in reaches_px:
        solution = refine(problem, pose, (reach,), spacing)
        if solution is None or any(one.ends_at(solution.pose, SAME) for one in known):
            return None
        pose = solution.pose
        if reach <= EXACT_REACH_PX and solution.moved_px < SETTLED_PX:
            break
    assert solution is not None
    support = support_at(problem, solution.pose, spacing)
    return None if support is None else Refined(problem, solution, support, spacing_px)


def finished(rough: Refined) -> Refined:
    """A coarsely refined pose, refined to the end."""
    fine = refined(rough.problem, rough.pose, FINE_REACHES_PX, rough.spacing_px)
    return rough if fine is None else fine


def turned(best: Refined) -> list[tuple[Pose, PoseSupport]]:
    """Turns of a target that is nearly symmetric which explain the images clearly better than ``best``.

    They lie outside the search range. A seed pose that is turned wrongly leads to a pose that fits most
    lines; the others tell. Where no image shows these, the seed pose is believed.
    """
    least = TURNED_BETTER * best.quality
    found = []
    for turn in near_symmetries(best.problem.model):
        pose, support = best.pose.compose(turn), None
        for coarser, share in ((COARSER, ROUGHLY), (1.0, 1.0)):
            support = support_at(best.problem, pose, coarser * best.spacing_px)
            if support is None or quality(support) <= share * least:
                break
        else:
            assert support is not None
            found.append((pose, support))
    return found


def add_beside(found: list[Refined]) -> None:
    """Add the rivals that lie beside the first pose, see `hypotheses`; best first again."""
    first = found[0]
    near = edges_around(first.problem, first.pose)
    for start in hypotheses_beside(near, first.pose, len(first.problem.model.lines), BESIDE):
        other = refined(first.problem, start, COARSE_REACHES_PX, first.spacing_px, COARSER, known=found)
        if other is not None:
            found.append(other)
    found.sort(key=lambda one: -one.quality)
