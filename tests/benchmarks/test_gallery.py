"""The gallery's views are in the frame, and what is said of them is what was found."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.gallery import CAMERA, PANEL_PX, failures, panels, parts, told
from vision_server.trust.judgement import Estimate


def test_six_parts_are_whole_in_the_frame() -> None:
    views = parts(seed=3)
    assert len({view.name for view in views}) == 6
    for view in [*views, *failures(seed=3)]:
        seen = CAMERA.project(view.pose.apply(view.model.vertices))
        assert (seen > 0.0).all()
        assert (seen < [CAMERA.width, CAMERA.height]).all()


@pytest.mark.slow
def test_a_view_is_drawn_three_times_under_what_came_of_it() -> None:
    drawn = panels(failures(seed=3)[1], np.random.default_rng(0))
    assert drawn.shape[1:] == (3 * PANEL_PX, 3)
    assert drawn.shape[0] > PANEL_PX
    assert told(Estimate()) == "no pose, 0 straight edges"
