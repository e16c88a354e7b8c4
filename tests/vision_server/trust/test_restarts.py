"""Whether the last step comes back to a pose from beside it."""

from dataclasses import replace

import numpy as np
import pytest

from geometry.model import Model
from geometry.pose import Pose
from geometry.symmetries import ASYMMETRIC
from geometry.turns import turned_about
from numerics.arrays import Floats
from tests.vision_server.refined_poses import channels_of
from tests.vision_server.synthetic import CAMERA, POSE, linear_picture, photographed
from vision_server.pose.observation import PoseProblem
from vision_server.pose.steps import moved, turning_point
from vision_server.trust import restarts
from vision_server.trust.ranking import Refined, best_first
from vision_server.trust.restarts import MOST_ASTRAY, astray
from vision_server.trust.settling import Round, Settled, last_round, settled

GREYS = (0.3, 0.7, 0.2, 0.9, 0.5, 0.8)


def last_step(model: Model, picture: Floats, seed: int) -> Settled:
    """Of a pose that is refined on a photograph of a picture."""
    channels = channels_of(photographed(picture, seed=seed))
    last = settled(best_first(PoseProblem.at_scale(channels, model, CAMERA), [POSE])[0])
    assert last is not None
    return last


@pytest.mark.parametrize("seed", range(3))
def test_the_last_step_comes_back_to_a_pose_that_is_the_only_one(model: Model, seed: int) -> None:
    last = last_step(model, linear_picture(model, CAMERA, POSE, GREYS), seed)
    assert astray(last, ASYMMETRIC) < 0.1


def test_it_is_the_mean_of_how_far_away_starts_end(model: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of four of which one ends at another pose, 1.2 degrees away, and one nowhere."""
    last = last_step(model, linear_picture(model, CAMERA, POSE, GREYS), 0)
    pose = last.best.pose
    tilted = moved(pose, np.r_[0.0, np.radians(1.2), np.zeros(4)], turning_point(model, pose))
    ends = iter([pose, tilted, None, pose])

    def looked(best: Refined, _start: Pose) -> Round | None:
        look, end = last_round(best, pose), next(ends)
        assert look is not None
        return None if end is None else look._replace(pose=end, step=np.zeros_like(look.step))

    monkeypatch.setattr(restarts, "last_round", looked)
    assert astray(last, ASYMMETRIC) == pytest.approx((1.2 + MOST_ASTRAY) / 4.0, abs=0.01)


def test_a_turn_about_a_free_axis_is_none(model: Model) -> None:
    """The box stands for a round part, at a pose from which the last step turns it by 1.1 degrees."""
    last = last_step(model, linear_picture(model, CAMERA, POSE, GREYS), 0)
    pose, axis = last.best.pose, np.array([0.0, 0.0, 1.0])
    turned = replace(last.best.solution, pose=turned_about(pose, axis, np.zeros(3), 0.02))
    last = last._replace(best=replace(last.best, solution=turned))
    assert astray(last, replace(ASYMMETRIC, free_axis=axis)) < 0.1
    assert astray(last, ASYMMETRIC) > 1.0
