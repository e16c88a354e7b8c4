"""What the first picture of README says of its images holds, with a margin."""

import pytest

from benchmarks.story_figure import merit_px, said, told

pytestmark = pytest.mark.slow


def test_no_image_can_be_trusted_alone_and_all_together_can() -> None:
    story = told()
    assert len(story.alone) == 4
    for alone in story.alone:
        assert "not trusted" in said(alone) or alone.pose is None
        assert alone.pose is None or merit_px(alone) > 2.0
    assert merit_px(story.together) < 0.5
    assert "not trusted" not in said(story.together)
    assert story.together.pose is not None
    assert story.together.pose.error_to(story.simulator.true_pose).within(0.2, 0.002)
