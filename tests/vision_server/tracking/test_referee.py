"""Judging poses of a cuboid: right, wrong, and of what is not there."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.machined_parts import circle, drilled, surface_of
from benchmarks.synthetic_parts import rendered
from geometry.model import Model
from geometry.pose import RIGHT, Pose
from geometry.rotation import matrix_of
from tests.vision_server.synthetic import CAMERA, POSE, linear_picture, one_image, photographed
from tests.vision_server.tracking.films import GREYS
from vision_server.image_set import ImageSet
from vision_server.pose.covariance import share_within
from vision_server.pose.line_scales import with_line_scales
from vision_server.pose.observation import PoseProblem
from vision_server.pose.sampling import spacing_for
from vision_server.tracking import referee
from vision_server.tracking.chances import Agreement, Chance, Chances, agreement, probability
from vision_server.tracking.fitting import Habits
from vision_server.tracking.referee import LOST_BELOW, OK_FROM, Around, _on_lines, chances_of, judged
from vision_server.trust.support import evidence_at


@pytest.fixture(scope="module")
def images(model: Model) -> ImageSet:
    return one_image(photographed(linear_picture(model, CAMERA, POSE, GREYS), 0.8))


@pytest.mark.parametrize("degrees", [0.0, 0.75])
def test_a_right_pose_is_ok(model: Model, images: ImageSet, degrees: float) -> None:
    given = Pose(POSE.rotation_vector + np.radians([degrees, 0.0, 0.0]), POSE.translation)
    found = judged(images, ["i1"], model, CAMERA, given)
    assert found.state == "ok"
    assert (found.better is None) == (degrees == 0.0)


@pytest.mark.parametrize("degrees", [2.0, 8.0])
def test_a_wrong_pose_is_lost_and_a_better_one_named(model: Model, images: ImageSet, degrees: float) -> None:
    given = Pose(POSE.rotation_vector + np.radians([0.0, degrees, 0.0]), POSE.translation)
    found = judged(images, ["i1"], model, CAMERA, given)
    assert found.state == "lost"
    assert found.better is not None
    assert found.better.error_to(POSE).within(0.3, 0.003)
    assert found.better_probability is not None
    assert OK_FROM < found.better_probability <= 1.0


def test_another_pose_that_is_rather_wrong_is_not_named(
    model: Model, images: ImageSet, monkeypatch: pytest.MonkeyPatch
) -> None:
    given = Pose(POSE.rotation_vector + np.radians([0.0, 8.0, 0.0]), POSE.translation)
    monkeypatch.setattr(referee, "of_images", lambda _: 0.45)
    found = judged(images, ["i1"], model, CAMERA, given)
    assert (found.state, found.better, found.better_probability) == ("lost", None, None)
    assert (found.difference is None, found.covariance is None) == (True, False)


def test_a_pose_of_what_is_not_there_is_lost(model: Model) -> None:
    noise = np.random.default_rng(0).normal(60.0, 3.0, (CAMERA.height, CAMERA.width)).astype(np.uint8)
    found = judged(one_image(noise), ["i1"], model, CAMERA, POSE)
    assert (found.state, found.better) == ("lost", None)
    assert len(found.disagreeing) >= 7


@pytest.mark.parametrize("nats", [0.0, 1e3])
def test_a_pose_has_the_evidence_of_its_better_fit(model: Model, images: ImageSet, nats: float) -> None:
    """Not of the one that it happened to come by."""
    problem = PoseProblem.at_scale(images.gradients(["i1"]), model, CAMERA)
    start = Pose(POSE.rotation_vector, POSE.translation * 1.002)
    before = Around(start, 1e-6 * np.eye(6), nats, 1.0, 1.0)
    after = _on_lines(problem, before, Habits.of(model))
    spacing = spacing_for(model, CAMERA, start)
    assert after.pose.error_to(POSE).within(0.1, 0.001)
    fitted = evidence_at(with_line_scales(problem, start), after.pose, spacing)
    assert fitted > 10.0
    assert after.nats == max(nats, fitted)
    assert (after.quality, after.believed) == (before.quality, before.believed)


@pytest.mark.parametrize(("sides", "degrees"), [(8, 45.0), (8, 180.0), (48, 60.0)])
def test_a_regular_body_that_is_turned_is_told_by_what_stands_on_it(sides: int, degrees: float) -> None:
    boom = np.array([[0.03, -0.01], [0.16, -0.01], [0.16, 0.01], [0.03, 0.01]])
    solids = [drilled(circle(0.05, sides), [], 0.0, 0.06), drilled(boom, [], 0.02, 0.03)]
    model = Model.of_surface("probe", surface_of(solids))
    turn = matrix_of(np.radians([30.0, 20.0, 0.0]))
    true = Pose.from_matrix(turn, np.array([0.0, 0.0, 0.7]) - turn @ model.middle)
    image = one_image(rendered(model, CAMERA, true, np.random.default_rng(1)))
    assert judged(image, ["i1"], model, CAMERA, true).state == "ok"
    given = true.compose(Pose(np.radians([0.0, 0.0, degrees]), np.zeros(3)))
    found = judged(image, ["i1"], model, CAMERA, given)
    assert found.state == "lost"
    assert found.better is not None
    assert found.better.error_to(true).within(0.5, 0.005)


def test_a_pose_is_judged_alike_wherever_the_origin_of_its_file_is(model: Model, images: ImageSet) -> None:
    away = np.array([4.0, -3.0, 2.0])
    far = replace(model, vertices=model.vertices + away)
    given = Pose(POSE.rotation_vector + np.radians([0.0, 2.0, 0.0]), POSE.translation)
    to_origin = Pose(np.zeros(3), -away)
    near, found = (
        judged(images, ["i1"], one, CAMERA, pose)
        for one, pose in ((model, given), (far, given.compose(to_origin)))
    )
    assert found.probability == pytest.approx(near.probability, abs=1e-3)
    assert found.difference is not None
    assert near.difference is not None
    assert found.difference.translation_m == pytest.approx(near.difference.translation_m, abs=1e-3)
    assert found.better is not None
    assert near.better is not None
    assert found.better.error_to(near.better.compose(to_origin)).within(0.1, 0.001)


KNOWN = Around(POSE, np.diag([1e-8] * 3 + [1e-10] * 3), 30.0, 1.0, 0.98)


@pytest.mark.parametrize(("moved", "share"), [(0.0, 0.5), (1.0, 0.75)])
def test_of_two_poses_that_explain_as_much_neither_is_ok(moved: float, share: float) -> None:
    turned = replace(KNOWN, pose=POSE.stepped([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]))

    def stated(around: list[Around], pose: Pose) -> float:
        return probability(Chances(chances_of(around, pose), moved))

    alone = stated([KNOWN], POSE)
    assert alone > OK_FROM
    assert stated([KNOWN, turned], POSE) == pytest.approx(share * alone, abs=0.03)
    assert stated([replace(KNOWN, nats=60.0), turned], POSE) == pytest.approx(alone, abs=0.01)
    assert stated([KNOWN, replace(turned, nats=60.0)], POSE) < LOST_BELOW


def test_agreement_is_that_of_targets_and_given_poses_drawn_one_by_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    sizes = np.array([1.0, 3.0])  # smaller ones are seldom met by draws
    monkeypatch.setattr("vision_server.tracking.chances.GIVEN_POSE_ERRORS", sizes)
    spread = np.diag([np.radians(0.8) ** 2] * 3 + [0.003**2] * 3)
    given = POSE.stepped(np.r_[0.0, np.radians(0.5), 0.0, 0.001, 0.0, 0.0])
    rng = np.random.default_rng(2)
    drawn = [POSE.stepped(step) for step in rng.multivariate_normal(np.zeros(6), spread, 3000)]
    unit = np.repeat([np.radians(RIGHT[0]), RIGHT[1] * float(np.linalg.norm(POSE.translation))], 3)
    density, right = np.zeros(len(drawn)), np.zeros(len(drawn))
    for k, one in enumerate(drawn):
        off = np.r_[given.step_from(one)[:3], given.translation - one.translation] / unit
        variance = sizes**2 / 3.0
        density[k] = np.mean(np.exp(-0.5 * off @ off / variance) / variance**3)
        right[k] = density[k] * given.error_to(one).within(*RIGHT)
    found = agreement(RIGHT, POSE, spread, given)
    assert found.likelihood == pytest.approx(density.mean(), rel=0.1)
    assert found.right / found.likelihood == pytest.approx(right.sum() / density.sum(), abs=0.06)


def test_a_pose_from_elsewhere_that_agrees_is_believed_more_than_one_of_these_images() -> None:
    """What images leave open, a pose that was refined on them has from them."""
    vague = replace(KNOWN, covariance=np.diag([np.radians(0.6) ** 2] * 3 + [0.004**2] * 3))
    chances = chances_of([vague], POSE.stepped([0.0, 0.002, 0.0, 0.0, 0.0, 0.0]))
    elsewhere, derived = probability(Chances(chances, 2.0)), probability(Chances(chances, 0.0))
    assert elsewhere > OK_FROM
    assert derived < elsewhere - 0.2


@pytest.mark.parametrize("degrees", [0.0, 0.7, 1.2])
def test_the_share_within_limits_is_that_of_poses_drawn_one_by_one(degrees: float) -> None:
    given = POSE.stepped(np.r_[0.0, np.radians(degrees), 0.0, 0.001, 0.0, 0.0])
    spread = np.diag([np.radians(0.4) ** 2] * 3 + [0.0015**2] * 3)
    rng = np.random.default_rng(1)
    drawn = [POSE.stepped(step) for step in rng.multivariate_normal(np.zeros(6), spread, 4000)]
    expected = np.mean([given.error_to(one).within(1.0, 0.01) for one in drawn])
    assert share_within((1.0, 0.01), POSE, spread, given) == pytest.approx(expected, abs=0.06)


@pytest.mark.parametrize("moved", [0.0, 1.0])
def test_probability_grows_with_what_is_believed(moved: float) -> None:
    chances = [Chance(1.0, believed, 1.0, Agreement(0.1, 0.1)) for believed in (0.0, 0.1, 0.3, 0.6, 0.9, 1.0)]
    stated = [probability(Chances((one,), moved)) for one in chances]
    assert stated == sorted(stated)
    assert stated[0] < LOST_BELOW < OK_FROM < stated[-1]
