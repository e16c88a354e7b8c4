"""From the matcher's candidates to refined poses with their evidence, best first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from geometry.symmetry import near_symmetries
from vision_server.channels.gradients import GradientChannel
from vision_server.pose.hypotheses import starts_beside, surroundings
from vision_server.pose.line_scales import line_scales
from vision_server.pose.refinement import EXACT_REACH_PX, Solution, refine
from vision_server.pose.sampling import spacing_for
from vision_server.pose.support import Evidence, gather_evidence
from vision_server.pose.trust import quality

Ints = NDArray[np.int64]

SAME = (0.15, 0.001)  # degrees, share of the range: a step that ends this close has come to a known pose
NEAR = (0.5, 0.004)  # of coarsely refined poses, when both would end at one place
SCALE_REACH_PX = 4.0  # around a candidate's lines, where the blur of the edges is looked at
REFINED = 5  # candidates of the matcher that are looked at
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
    """A refined pose, what the images say about it, and the spacing of samples that suits it, px."""

    solution: Solution
    evidence: Evidence
    spacing_px: float


@dataclass(frozen=True, eq=False)
class Refiner:
    """Refines poses of one model on the channels of one image set.

    Attributes
    ----------
    least_scale
        Index of the smallest filter scale that is used.
    tone_sd_px
        See `refine`.
    """

    channels: Sequence[GradientChannel]
    model: Model
    camera: Camera
    least_scale: int
    tone_sd_px: float

    def best_first(self, candidates: Sequence[Pose]) -> list[Refined]:
        """The candidates, refined, best first.

        All are looked at coarsely; those that come near the best in quality are refined to the end.
        """
        coarse: list[Refined] = []
        for pose in candidates[:REFINED]:
            scale = line_scales(
                self.channels, self.model, self.camera, pose, SCALE_REACH_PX, self.least_scale
            )
            spacing = spacing_for(self.model, self.camera, pose)
            rough = self.refined(pose, scale, COARSE_REACHES_PX, spacing, COARSER, known=coarse)
            if rough is not None:
                coarse.append(rough)
        coarse.sort(key=lambda one: -quality(one.evidence))
        for _ in range(BESIDE_ROUNDS if coarse else 0):
            first = coarse[0]
            if quality(first.evidence) >= CLEAR_QUALITY:
                break
            self.add_beside(coarse)
            if coarse[0] is first:
                break
        distinct: list[Refined] = []
        for one in coarse:
            if not any(_ends_at(one.solution.pose, better.solution.pose, NEAR) for better in distinct):
                distinct.append(one)
        least = FINISHED_SHARE * quality(coarse[0].evidence) if coarse else 0.0
        out = [self.finished(one) if quality(one.evidence) >= least else one for one in distinct]
        return sorted(out, key=lambda one: -quality(one.evidence))

    def refined(
        self,
        pose: Pose,
        scale: Ints,
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
            solution = refine(
                self.channels, self.model, self.camera, pose, scale, (reach,), self.tone_sd_px, spacing
            )
            if solution is None or any(_ends_at(solution.pose, one.solution.pose, SAME) for one in known):
                return None
            pose = solution.pose
            if reach <= EXACT_REACH_PX and solution.moved_px < SETTLED_PX:
                break
        assert solution is not None
        evidence = gather_evidence(self.channels, self.model, self.camera, solution.pose, scale, spacing)
        return None if evidence is None else Refined(solution, evidence, spacing_px)

    def finished(self, rough: Refined) -> Refined:
        """A coarsely refined pose, refined to the end."""
        scale = rough.evidence.measurement.scale
        fine = self.refined(rough.solution.pose, scale, FINE_REACHES_PX, rough.spacing_px)
        return rough if fine is None else fine

    def turned(self, best: Refined) -> list[tuple[Pose, Evidence]]:
        """Turns of a target that is nearly symmetric which explain the images clearly better than ``best``.

        They lie outside the search range. A seed pose that is turned wrongly leads to a pose that fits most
        lines; the others tell. Where no image shows these, the seed pose is believed.
        """
        scale, least = best.evidence.measurement.scale, TURNED_BETTER * quality(best.evidence)
        found = []
        for turn in near_symmetries(self.model):
            pose = best.solution.pose.compose(turn)
            for coarser, share in ((COARSER, ROUGHLY), (1.0, 1.0)):
                spacing = coarser * best.spacing_px
                evidence = gather_evidence(self.channels, self.model, self.camera, pose, scale, spacing)
                if evidence is None or quality(evidence) <= share * least:
                    break
            else:
                assert evidence is not None
                found.append((pose, evidence))
        return found

    def add_beside(self, found: list[Refined]) -> None:
        """Add the rivals that lie beside the first pose, see `sidesteps`; best first again."""
        first, scale = found[0], found[0].evidence.measurement.scale
        near = surroundings(self.channels, self.model, self.camera, first.solution.pose, scale)
        for start in starts_beside(near, first.solution.pose, len(self.model.lines), BESIDE):
            other = self.refined(start, scale, COARSE_REACHES_PX, first.spacing_px, COARSER, known=found)
            if other is not None:
                found.append(other)
        found.sort(key=lambda one: -quality(one.evidence))


def _ends_at(pose: Pose, other: Pose, limits: tuple[float, float]) -> bool:
    return pose.error_to(other).within(*limits)
