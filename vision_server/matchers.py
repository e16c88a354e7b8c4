"""The matchers by name, and what one of them makes of a set's segments."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

from bridge.errors import BadInput
from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from numerics.arrays import Floats
from vision_server.baselines.genetic import match_genetic
from vision_server.matching.match import Anywhere, Hypothesis, SearchRange, ideal_segments, worth_refining
from vision_server.matching.search import THOROUGH, USUAL, Effort, match_search

Matcher = Callable[[Floats, Model, Camera, Pose, int, SearchRange], list[Hypothesis]]
DEFAULT_MATCHER = "search"
MATCHERS: dict[str, Matcher] = {DEFAULT_MATCHER: match_search, "genetic": match_genetic}


@dataclass(frozen=True)
class Matching:
    """Which matcher, and how it looks; see `pipeline.PipelineSettings`."""

    matcher: str
    seed: int
    reach: SearchRange
    generations: int
    population: int
    effort: Effort = USUAL

    @property
    def thorough(self) -> Matching:
        """The same with more effort, where the matcher has more to offer."""
        return replace(self, effort=THOROUGH)

    def hypotheses(
        self, endpoints: Floats, model: Model, camera: Camera, seed_pose: Pose | Anywhere
    ) -> list[Pose]:
        """The poses that segments (N, 4), px, support and that are worth refining, best first.

        Raises
        ------
        BadInput
            An unknown matcher, or one that needs a seed pose where there is none.
        """
        ends = ideal_segments(endpoints, camera)
        return worth_refining(self._matched(ends, model, camera, seed_pose))

    def _matched(
        self, ends: Floats, model: Model, camera: Camera, seed_pose: Pose | Anywhere
    ) -> list[Hypothesis]:
        if self.matcher not in MATCHERS:
            raise BadInput(f"Unknown matcher {self.matcher!r}.", f"Use {' or '.join(sorted(MATCHERS))}.")
        if isinstance(seed_pose, Anywhere):
            if self.matcher != DEFAULT_MATCHER:
                raise BadInput(f"The {self.matcher} matcher needs a seed pose.", "Give one, or use search.")
            from vision_server.matching.first_sight import match_anywhere  # most sessions have a seed pose

            return match_anywhere(ends, model, camera, seed_pose)
        matcher = MATCHERS[self.matcher]
        if self.matcher == "genetic":
            matcher = partial(match_genetic, generations=self.generations, population=self.population)
        elif self.effort is not USUAL:
            matcher = partial(match_search, effort=self.effort)
        return matcher(ends, model, camera, seed_pose, self.seed, self.reach)
