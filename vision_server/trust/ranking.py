"""From the matcher's hypotheses to refined poses with their support, best first: a multi-start of refinement.

All are refined coarsely, with turns and edges beside that no small step leads to, and those that come near
the best in quality to the end. Of very many lines the longest are taken (`fewer_lines`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from geometry.chains import chains, longest_chains
from geometry.model import Model
from geometry.near_symmetries import near_symmetries
from geometry.pose import Pose
from numerics.arrays import Ints
from vision_server.pose.line_scales import with_line_scales
from vision_server.pose.observation import PoseProblem
from vision_server.pose.refinement import EXACT_REACH_PX, Solution, refine
from vision_server.pose.sampling import spacing_for
from vision_server.trust.hypotheses import edges_around, hypotheses_beside
from vision_server.trust.probability import quality
from vision_server.trust.spun import spun
from vision_server.trust.support import PoseSupport, support_at

# Chosen by hand where nothing else is said. Halved or doubled (`python -m benchmarks.constants`, 24 sets of
# recorded and hard stacks), clear quality, share that is finished and starts beside change one pose at most;
# twelve starts take a fifth more time.
# Degrees and share of the range: a refinement that ends so close to a known pose has come to that optimum;
# two coarse ones that are so close would come to one optimum if they were refined to the end.
ONE_OPTIMUM, ONE_BASIN = (0.15, 0.001), (0.5, 0.004)
COARSE_REACHES_PX, COARSENING = (6.0, 4.0), 1.75  # first, with fewer samples; ...
FINE_REACHES_PX = (4.0, 3.0, 3.0)  # ... then, with all, ...
FINISHED_QUALITY_SHARE = 0.5  # ... those of at least this share of the best one's quality
CONVERGED_PX = 0.03  # a step that moves no line farther is the last one
CLEAR_QUALITY = 2.0  # 1/px: from here on, nothing beside the pose can be as good
MOST_BESIDE, BESIDE_ROUNDS = 6, 3  # starts beside the best pose, and again when that has found a better one
COARSE_LACK_NATS = 10.0  # of evidence, that fewer samples may miss
TURNED_LACK_NATS = 20.0  # that a turned pose may lack before it is refined: odds of e^-7 after that

# A pose is found by so many of the longest lines and chains of lines (by hand). Of plates with 5000 lines as
# many poses are right with 400, 500 and 800 as with all, 0.8 to 1.8 times as far off, in a third of the time;
# 11 of 14 are trusted with 500, and none with all.
MOST_COMPARED_CURVES = 500


@dataclass(frozen=True, eq=False)
class Refined:
    """A refined pose, on what, what supports it, its samples' spacing, px; whether to the end."""

    problem: PoseProblem
    solution: Solution
    support: PoseSupport
    spacing_px: float
    to_the_end: bool = False

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


def _rank(one: Refined) -> tuple[float, float]:
    """To sort by, best first; where all lines are far from their edges, quality does not tell."""
    return -one.quality, -one.support.evidence


def nowhere(_pose: Pose) -> bool:
    """The search range where there is no seed pose to search around."""
    return False


def best_first(
    problem: PoseProblem,
    hypotheses: Sequence[Pose],
    spin_rad: float = 0.0,
    searched: Callable[[Pose], bool] = nowhere,
) -> list[Refined]:
    """The hypotheses, refined, best first.

    All are looked at coarsely; those that come near the best in quality are refined to the end.

    Parameters
    ----------
    problem
        Its scales are the least that are used.
    spin_rad
        How far a nearly round target may be turned about its axis from the hypotheses, see `spun`.
    searched
        Whether a pose is in the search range: the first is turned onto those of its near symmetries that are.
    """
    coarse: list[Refined] = []
    for pose in hypotheses:
        rough = roughly(problem, pose, coarse)
        if rough is not None:
            coarse.append(rough)
    coarse = _with_spun(sorted(coarse, key=_rank), spin_rad)
    turned = coarse[:1]
    for _ in range(BESIDE_ROUNDS if coarse else 0):
        first = coarse[0]
        if first.quality >= CLEAR_QUALITY:
            break
        coarse = with_beside(coarse)
        if coarse[0] is first:
            break
    if coarse[:1] != turned:
        coarse = _with_spun(coarse, spin_rad)
    for first in coarse[:1]:
        starts = map(first.pose.compose, near_symmetries(problem.model))
        coarse = [*coarse, *led_to(first, filter(searched, starts), coarse)]
    distinct: list[Refined] = []
    for one in sorted(coarse, key=_rank):
        if not any(better.ends_at(one.pose, ONE_BASIN) for better in distinct):
            distinct.append(one)
    least = FINISHED_QUALITY_SHARE * max((one.quality for one in distinct), default=0.0)
    out = [finished(one) if one.quality >= least else one for one in distinct]
    return sorted(out, key=_rank)


def _with_spun(found: list[Refined], spin_rad: float) -> list[Refined]:
    """Poses with the first of a nearly round target turned about its axis, see `spun`; best first."""
    if not found:
        return []
    first = found[0]
    starts = spun(first.problem, first.pose, COARSENING * first.spacing_px, spin_rad)
    return sorted([*found, *led_to(first, starts, found)], key=_rank)


def roughly(problem: PoseProblem, pose: Pose, known: Sequence[Refined]) -> Refined | None:
    """One hypothesis, refined coarsely on scales of its own; None where it ends at a known one."""
    scaled = with_line_scales(problem, pose)
    spacing = spacing_for(problem.model, problem.camera, pose)
    return refined(scaled, pose, COARSE_REACHES_PX, spacing, COARSENING, known=known)


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
        if solution is None or any(one.ends_at(solution.pose, ONE_OPTIMUM) for one in known):
            return None
        pose = solution.pose
        if reach <= EXACT_REACH_PX and solution.moved_px < CONVERGED_PX:
            break
    assert solution is not None
    support = support_at(problem, solution.pose, spacing)
    return None if support is None else Refined(problem, solution, support, spacing_px)


def fewer_lines(problem: PoseProblem) -> PoseProblem:
    """The problem with the longest MOST_COMPARED_CURVES of its model's lines; all faces still hide.

    Outlines of curved surfaces all stay: which of them are seen depends on the pose.
    """
    model, kept = _sparse(problem.model)
    return problem if model is problem.model else replace(problem, model=model, scale=problem.scale[:, kept])


@lru_cache(maxsize=8)
def _sparse(model: Model) -> tuple[Model, Ints]:
    """The model with these lines only, and which they are."""
    chosen = longest_chains(model.vertices, model.lines, model.smooth, chains(model), MOST_COMPARED_CURVES)
    kept = np.flatnonzero(chosen)
    if len(kept) == len(model.lines):
        return model, kept
    lines, faces, smooth = model.lines[kept], model.line_faces[kept], model.smooth[kept]
    return replace(model, lines=lines, line_faces=faces, smooth=smooth), kept


def finished(rough: Refined) -> Refined:
    """A coarsely refined pose, refined to the end, unless it is."""
    fine = None if rough.to_the_end else refined(rough.problem, rough.pose, FINE_REACHES_PX, rough.spacing_px)
    return rough if fine is None else replace(fine, to_the_end=True)


def with_beside(found: Sequence[Refined]) -> list[Refined]:
    """Poses with the rivals that lie beside the first of them, see `hypotheses`; best first."""
    first = found[0]
    near = edges_around(first.problem, first.pose)
    starts = hypotheses_beside(near, first.pose, len(first.problem.model.lines), MOST_BESIDE)
    return sorted([*found, *led_to(first, starts, found)], key=_rank)


def led_to(like: Refined, starts: Iterable[Pose], known: Sequence[Refined]) -> list[Refined]:
    """What starts lead to, coarsely, with the scales and samples of another pose; none that is known."""
    found: list[Refined] = []
    for start in starts:
        other = refined(like.problem, start, COARSE_REACHES_PX, like.spacing_px, COARSENING, [*known, *found])
        if other is not None:
            found.append(other)
    return found
