"""Whether lines say that the model is too long along an axis: its pose may be off then, exact as it seems.

Where a view hardly shows the wrong axis, a pose takes up most of what the lines are off; with the axes'
lengths as unknowns beside it, the lines tell how much longer one is for another.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from geometry.pose import Pose
from numerics.arrays import Floats
from vision_server.pose.observation import PoseProblem
from vision_server.pose.refinement import EXACT_REACH_PX, refine
from vision_server.trust.probability import USUAL_STRETCH_CHI2
from vision_server.trust.stretch import significance_of, strain_of

# Of an axis beside the mean of all three. Of sure frames of three films with a model 5 to 15 % too long half
# have more than 0.03 to 0.07; of films with the true one, of printed boxes and of a real cube nine in ten
# have less than 0.005, 0.007 and 0.013.
LEAST_STRAIN = 0.02
ASKED_AGAIN_FRAMES = 8  # sure frames until lines are asked again, as it costs half of a frame (by hand)


class Strain:
    """Whether the model is not that of the target; asked of a sure pose first, and now and then."""

    def __init__(self) -> None:
        self._found, self._since = False, ASKED_AGAIN_FRAMES

    def asked(self, ask: Callable[[], bool]) -> bool:
        """Of the next sure pose, whose lines ``ask`` asks."""
        self._since += 1
        if self._found or self._since >= ASKED_AGAIN_FRAMES:
            self._since, self._found = 0, ask()
        return self._found


def is_strained(problem: PoseProblem, pose: Pose, spacing_px: float) -> bool:
    """Whether another model, longer or shorter along an axis, is what the lines at a pose say."""
    solution = refine(problem, pose, (EXACT_REACH_PX,), spacing_px)
    if solution is None:
        return False
    return clearly_strained(*strain_of(problem.model, solution, 3))


def clearly_strained(strain: Floats, covariance: Floats) -> bool:
    """Whether logarithms of three axes' scales (3,), of this covariance, are surely not alike."""
    if float(np.abs(strain - strain.mean()).max()) < LEAST_STRAIN:
        return False
    return significance_of(strain, covariance) > USUAL_STRETCH_CHI2
