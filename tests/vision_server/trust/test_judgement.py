from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from geometry.pose import Pose
from geometry.symmetries import ASYMMETRIC
from vision_server.trust.judgement import Estimate, with_poses
from vision_server.trust.likely import Likely


def likely(angle: float, probability: float) -> Likely:
    pose = Pose(np.array([0.0, 0.0, angle]), np.array([0.0, 0.0, 1.0]))
    told = SimpleNamespace(last=SimpleNamespace(best=SimpleNamespace(pose=pose)), probability=probability)
    return cast("Likely", told)


@pytest.mark.parametrize("score", [0.95, 0.3, 1e-5])
def test_no_pose_is_more_likely_than_the_estimate_is_believed(score: float) -> None:
    found = [likely(0.0, 0.8), likely(1.0, 0.15)]
    told = with_poses(Estimate(score=score), found, ASYMMETRIC, lambda _pose: True)
    first, second = (one.probability for one in told.poses)
    assert told.score == pytest.approx(min(score, 0.8))
    assert (first, second) == pytest.approx((told.score, told.score * 0.15 / 0.8))
