from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from geometry.pose import Pose
from geometry.symmetries import ASYMMETRIC
from vision_server.trust.judgement import Estimate, stated, with_poses
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


@pytest.mark.parametrize(("score", "wider"), [(1.0, 1.0), (0.25, 4.0), (1e-9, 50.0)])
def test_what_is_doubted_is_stated_with_a_wider_spread(score: float, wider: float) -> None:
    pose = Pose(np.zeros(3), np.array([0.0, 0.0, 1.0]))
    told = stated(Estimate(pose=pose, covariance=np.eye(6), uncertainty=0.001, score=score))
    assert told.covariance == pytest.approx(wider * np.eye(6))
    assert told.uncertainty == pytest.approx(0.001 * wider**0.5)
    assert stated(Estimate()).covariance is None
