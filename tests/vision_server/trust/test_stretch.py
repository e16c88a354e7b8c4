"""A part that is not quite its model: a stretched model tells, and its pose is not believed."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.photographs import image_set
from benchmarks.trust_rows import drawn_set, simulated
from geometry.model import Model
from geometry.pose import RIGHT, Pose
from tests.vision_server.synthetic import CAMERA, POSE, linear_picture, one_image, photographed
from vision_server.pipeline import estimate_pose
from vision_server.pose.observation import PoseProblem
from vision_server.trust import judgement
from vision_server.trust.judgement import LEAST_BY_LINES, Estimate
from vision_server.trust.probability import SURE_NATS, WORTH_DOUBTING, Misfit, confidence
from vision_server.trust.ranking import FINE_REACHES_PX, refined
from vision_server.trust.stretch import misfit, stretched

TRUSTED = 0.93  # the merit is 1 there
GREYS = (0.3, 0.7, 0.2, 0.9, 0.5, 0.8)


def estimated(part: Model, model: Model) -> Estimate:
    picture = photographed(linear_picture(part, CAMERA, POSE, GREYS))
    return estimate_pose(one_image(picture), ["i1"], model, CAMERA, POSE)


def test_the_pose_of_a_true_model_is_believed(model: Model) -> None:
    assert estimated(model, model).score > 0.95


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("percent", [3.0, 10.0])
def test_the_pose_of_a_part_wider_than_its_model_is_not_believed(
    model: Model, axis: int, percent: float
) -> None:
    """Where the other lines hold it nevertheless in its place, it may be nearly believed."""
    found = estimated(stretched(model, np.log(1.0 + percent / 100.0) * np.eye(3)[axis]), model)
    assert found.pose is not None
    assert found.score < (TRUSTED if found.pose.error_to(POSE).within(*RIGHT) else TRUSTED - 0.1)


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("share", [-0.02, 0.02])
def test_a_model_that_is_too_long_or_too_short_is_told_with_its_axis(
    model: Model, axis: int, share: float
) -> None:
    other = stretched(model, np.log1p(share) * np.eye(3)[axis])
    found = estimated(model, other)
    assert found.misfit is not None
    told = found.misfit.excess
    assert told is not None
    assert told.axis == axis
    assert told.share == pytest.approx(share, abs=0.003)
    assert found.misfit.borne_out > 0.9
    assert found.score < TRUSTED


def test_nothing_is_said_of_a_true_model_nor_of_what_is_hardly_stretched(model: Model) -> None:
    found = estimated(model, model)
    assert found.misfit is not None
    assert found.misfit.excess is None
    hardly = (-0.004, 0.002, 0.002, 0.0, 0.0, 0.0)
    assert Misfit(50.0, 40.0, hardly).excess is None  # sure, but of what moves no pose
    clearly = (-0.014, 0.007, 0.007, 0.0, 0.0, 0.0)
    assert Misfit(9.0, 19.0, clearly).excess is None  # large, but not sure
    assert Misfit(0.0, 21.0, clearly).excess == pytest.approx((0, np.expm1(0.021)))


def test_nothing_is_said_where_much_speaks_against_the_better_model_but_the_pose_is_doubted(
    model: Model,
) -> None:
    found = estimated(model, model)
    assert found.support is not None
    clearly = (-0.014, 0.007, 0.007, 0.0, 0.0, 0.0)
    in_poor_light, in_good = (Misfit(0.0, 30.0, clearly, borne_out=share) for share in (0.46, 0.74))
    assert in_poor_light.excess is None
    assert in_good.excess is not None
    scores = [confidence(found.support, 0.0, 0.001, doubt) for doubt in (in_poor_light, in_good)]
    assert scores[1] < scores[0] < TRUSTED


@pytest.mark.parametrize("between", [3, 4, 5])
def test_the_pose_of_a_part_that_leans_is_not_believed(model: Model, between: int) -> None:
    leaning = stretched(model, 0.08 * np.eye(6)[between])
    assert estimated(leaning, model).score < TRUSTED - 0.1


def test_a_shear_is_the_angle_that_two_axes_lean_towards_each_other(model: Model) -> None:
    leaning = stretched(model, np.array([0.0, 0.0, 0.0, 0.02, 0.0, 0.0]))
    change = np.linalg.lstsq(model.vertices, leaning.vertices, rcond=None)[0]
    x, y, z = change
    assert np.degrees(np.arccos(x @ y / np.linalg.norm(x) / np.linalg.norm(y))) == pytest.approx(
        90.0 - np.degrees(0.02), abs=0.01
    )
    assert abs(x @ z) < 1e-12


def test_a_part_of_another_size_is_the_same_part_at_another_range(model: Model) -> None:
    larger = stretched(model, np.full(3, np.log(1.05)))
    assert np.allclose(np.ptp(larger.vertices, axis=0), 1.05 * np.ptp(model.vertices, axis=0))
    assert estimated(larger, model).score > 0.3


def test_a_pose_that_is_rather_wrong_is_compared_with_other_models_too(model: Model) -> None:
    found = estimated(stretched(model, np.log([0.8, 1.15, 1.0])), model)
    assert found.support is not None
    assert found.uncertainty is not None
    by_itself = confidence(found.support, found.ambiguity, found.uncertainty)
    assert WORTH_DOUBTING < by_itself < 0.5
    assert found.score < 0.1 * by_itself


def test_a_pose_is_told_however_much_better_another_model_fits(
    model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(judgement, "misfit", lambda _: Misfit(0.0, 60.0))
    found = estimated(model, model)
    assert found.score < LEAST_BY_LINES
    assert found.pose is not None
    assert found.pose.error_to(POSE).within(0.2, 0.002)


def test_a_stretched_model_that_fits_better_lowers_the_score(model: Model) -> None:
    estimate = estimated(model, model)
    support, spread = estimate.support, estimate.uncertainty
    assert support is not None
    assert spread is not None
    plain = confidence(support, 0.0, spread)
    none = Misfit(significance=0.0, gain=0.0)
    assert confidence(support, 0.0, spread, none) == plain
    for doubt in (replace(none, significance=100.0), replace(none, gain=6.0)):
        assert confidence(support, 0.0, spread, doubt) < plain - 0.02


def test_a_part_that_was_found_by_one_end_is_seen_to_be_longer(model: Model) -> None:
    """The other end is farther off than edges are looked for where the lines that have one hold the pose."""
    near = Pose(POSE.rotation_vector, POSE.translation * [0.25, 0.25, 0.5])
    longer = stretched(model, np.log1p(0.22) * np.eye(3)[0])
    shift = near.matrix[:, 0] * -0.22 * 0.5 * np.ptp(model.vertices[:, 0])
    channels = one_image(photographed(linear_picture(longer, CAMERA, near, GREYS))).gradients(["i1"])
    found = refined(
        PoseProblem.at_scale(channels, model, CAMERA),
        Pose(near.rotation_vector, near.translation + shift),
        FINE_REACHES_PX,
        2.0,
    )
    assert found is not None
    told = misfit(found)
    assert told.gain > SURE_NATS
    assert told.excess is not None
    assert told.excess.axis == 0
    assert told.excess.share == pytest.approx(-0.18, abs=0.01)


def test_a_part_that_was_found_by_a_side_within_it_is_seen_to_be_longer() -> None:
    """Of a patterned tee, by a side of its stem: patterns seem to hold the sides of its bar."""
    _, studio, _ = simulated(4, 20266)
    shots = drawn_set(studio, "exposed", 1, np.random.default_rng(3))
    model = stretched(studio.model, np.log(0.85) * np.eye(3)[0])
    side = 0.60 * (studio.model.vertices[:, 0] - studio.model.middle[0]).min()
    found = refined(
        PoseProblem.at_scale(image_set(shots).gradients(["i0"]), model, studio.camera),
        Pose(studio.true.rotation_vector, studio.true.translation + 0.15 * side * studio.true.matrix[:, 0]),
        FINE_REACHES_PX,
        2.0,
    )
    assert found is not None
    told = misfit(found)
    assert told.gain > SURE_NATS
    assert told.excess == pytest.approx((0, -0.15), abs=0.01)
