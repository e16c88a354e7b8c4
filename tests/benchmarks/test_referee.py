"""The referee's benchmark: shapes of its scenes, poses as of corners, and a fit that never saw the shape."""

import numpy as np
import pytest

from benchmarks import given_poses, referee
from benchmarks.films import CAMERA
from geometry.model import TARGETS, load_model
from geometry.pose import RIGHT, Pose
from vision_server.tracking.chances import CALIBRATION, Agreement, Calibration, Chance, Chances


@pytest.mark.parametrize(("number", "shape"), [(3, "box"), (6, "part"), (12, "part")])
def test_every_third_scene_is_a_frame_of_a_box_or_of_a_random_part(number: int, shape: str) -> None:
    images, model, _, _ = given_poses.scene(number)
    assert model.name == shape
    assert len(images.images) == 1


def test_corners_tell_the_pose_but_for_those_that_are_interchanged(monkeypatch: pytest.MonkeyPatch) -> None:
    model, rng = load_model(TARGETS / "fixture.cao"), np.random.default_rng(0)
    true = Pose(np.array([0.4, 0.5, 0.1]), np.array([0.02, -0.01, 0.9]))
    monkeypatch.setattr(given_poses, "MOST_OFF_PX", 1e-3)
    monkeypatch.setattr(given_poses, "INTERCHANGED", 0.0)
    found = given_poses._of_corners(rng, model, CAMERA, true)
    assert found is not None
    assert found.error_to(true).within(0.05, 0.001)
    monkeypatch.setattr(given_poses, "INTERCHANGED", 1.0)
    others = [given_poses._of_corners(rng, model, CAMERA, true) for _ in range(5)]
    assert not any(other is not None and other.error_to(true).within(*RIGHT) for other in others)


def test_a_shape_is_judged_by_a_fit_to_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    fits = []

    def fitted(rows: list[referee.Row]) -> Calibration:
        fits.append({row.shape for row in rows})
        return CALIBRATION._replace(most=float(len(fits)))

    monkeypatch.setattr(referee, "fitted", fitted)
    chances = Chances((Chance(1.0, 0.9, 0.9, Agreement(1.0, 1.0)),), 2.0)
    rows = [referee.Row(str(k), shape, "drawn", True, chances, 0.0) for k, shape in enumerate("abca")]
    _, stated = referee.cross_validated(rows)
    assert sorted(map(sorted, fits)) == [["a", "b"], ["a", "b", "c"], ["a", "c"], ["b", "c"]]
    assert stated[0] == stated[3]
    assert len(set(stated)) == 3
