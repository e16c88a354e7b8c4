"""At first sight a pose is looked at from the other sides and turned, and what a view leaves open is said."""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from benchmarks.cad_parts import CAD
from benchmarks.drawn_parts import part_file
from benchmarks.machined_parts import ROUND, circle, drilled, surface_of
from benchmarks.synthetic_parts import error_of, estimated, rendered
from geometry.camera import Camera
from geometry.model import Model, load_model
from geometry.near_symmetries import near_symmetries
from geometry.pose import Pose
from geometry.rotation import matrix_of
from geometry.symmetries import symmetry_of
from geometry.turns import half_turns, near_symmetries_and_products, other_sides, rim_middle, round_axes
from tests.vision_server.synthetic import one_image
from vision_server.pose.observation import PoseProblem
from vision_server.trust.all_sides import of_most_evidence

CAMERA = Camera(640, 480, 768.0, 768.0, 319.5, 239.5)


@pytest.fixture(scope="module")
def flange() -> Model:
    return Model.of_surface("flange", surface_of(ROUND["flange"](48)))


def tilted(model: Model, degrees: float, size_px: float) -> Pose:
    """The axis so far from the line of sight, the hub towards the camera."""
    rotation = matrix_of(np.array([math.pi - math.radians(degrees), 0.0, 0.0])) @ matrix_of(
        np.array([0.0, 0.0, 0.3])
    )
    place = np.array([0.02, -0.01, CAMERA.fx * model.diameter / size_px])
    return Pose.from_matrix(rotation, place - rotation @ model.middle)


def problem_of(model: Model, pose: Pose) -> PoseProblem:
    images = one_image(rendered(model, CAMERA, pose, np.random.default_rng(1)))
    return PoseProblem.at_scale(images.gradients(["i1"]), model, CAMERA)


def nowhere(models: Sequence[Model], _: Pose) -> list[list[tuple[float, Pose]]]:
    """A matcher that finds nothing."""
    return [[] for _ in models]


@pytest.mark.slow
@pytest.mark.parametrize("side", range(3))
def test_a_rim_seen_from_the_wrong_side_leads_to_the_right_one(flange: Model, side: int) -> None:
    true = tilted(flange, 35.0, 300.0)
    ((axis, centre),) = round_axes(flange)
    wrong = other_sides(true, axis, rim_middle(flange, axis, centre))[side]
    found = of_most_evidence(problem_of(flange, true), [wrong], nowhere)
    assert error_of(found[0].pose, true, symmetry_of(flange)).within(1.0, 0.01)


def test_what_was_lost_beside_its_hypothesis_is_matched_once_more(flange: Model) -> None:
    """A hypothesis at twice the range, of which the fit to edges makes nothing."""
    true = tilted(flange, 35.0, 300.0)
    far = Pose.from_matrix(true.matrix, 2.0 * true.translation)
    problem, symmetry = problem_of(flange, true), symmetry_of(flange)

    def there(models: Sequence[Model], _: Pose) -> list[list[tuple[float, Pose]]]:
        return [[(1.0, true)] for _ in models]

    lost = of_most_evidence(problem, [far], nowhere)
    assert not any(error_of(one.pose, true, symmetry).within(1.0, 0.01) for one in lost)
    found = of_most_evidence(problem, [far], there)
    assert error_of(found[0].pose, true, symmetry).within(1.0, 0.01)


def test_the_rim_stays_where_it_is_from_the_other_sides(flange: Model) -> None:
    ((axis, centre),) = round_axes(flange)
    middle = rim_middle(flange, axis, centre)
    assert middle == pytest.approx([0.0, 0.0, 0.0075])  # of a disc of 15 mm
    pose = tilted(flange, 35.0, 300.0)
    turn = 2.0 * np.pi * np.arange(360) / 360
    rim = middle + 0.08 * np.column_stack([np.cos(turn), np.sin(turn), 0.0 * turn])
    seen = CAMERA.project(pose.apply(rim))
    for other in other_sides(pose, axis, middle):
        assert other.error_to(pose).rotation_deg > 60.0
        apart = np.linalg.norm(CAMERA.project(other.apply(rim))[:, None] - seen, axis=2).min(axis=1)
        assert apart.max() < 15.0  # px of 300: what perspective changes


@pytest.mark.parametrize(("tilt", "unseen"), [(90.0, True), (35.0, False)])
def test_a_turn_that_a_view_does_not_show_is_said(flange: Model, tilt: float, unseen: bool) -> None:
    """With a seed pose, too."""
    true = tilted(flange, tilt, 300.0)
    found = estimated(rendered(flange, CAMERA, true, np.random.default_rng(1)), flange, CAMERA, true)
    assert found.pose is not None
    assert [axis.tolist() for axis in found.free] == ([[0.0, 0.0, 1.0]] if unseen else [])


def test_a_wheel_is_turned_over_and_about_its_axis_at_once(tmp_path: Path) -> None:
    model = load_model(part_file("wheel", tmp_path, np.random.default_rng((4102, 0))))
    turns = near_symmetries_and_products(model)
    over = [turn for turn in turns if turn.matrix[2, 2] < -0.99]
    about = [turn for turn in turns if turn.matrix[2, 2] > 0.99]
    assert (len(over), len(about)) == (11, 10)  # eleven teeth
    for number, one in enumerate(turns):
        assert all(one.error_to(other).rotation_deg > 3.9 for other in turns[:number])


def test_a_bracket_is_looked_at_turned_by_half_however_little_that_brings_back() -> None:
    bracket = Model.of_surface("bracket", surface_of(CAD["bracket"](np.random.default_rng(3), 48)))
    assert near_symmetries(bracket) == ()
    true = tilted(bracket, 145.0, 300.0)
    _, _, about_z = half_turns(bracket)
    found = of_most_evidence(problem_of(bracket, true), [true.compose(about_z)], nowhere)
    assert found[0].pose.error_to(true).within(1.0, 0.01)


def test_a_side_that_many_turns_fit_leaves_room_for_the_other(tmp_path: Path) -> None:
    """The block is on the side that is seen; ten turns of the other side fit nearly as well."""
    model = load_model(part_file("wheel", tmp_path, np.random.default_rng((4102, 0))))
    true = tilted(model, 35.0, 300.0)
    about = [turn for turn in near_symmetries_and_products(model) if turn.matrix[2, 2] > 0.99]
    flat = model.vertices[:, 2].min() * 0.5  # of the wheel without its block
    flip = matrix_of(np.array([0.0, math.pi, 0.0]))
    over = true.compose(Pose.from_matrix(flip, np.array([0.0, 0.0, flat]) - flip @ [0.0, 0.0, flat]))
    starts = [over.compose(turn) for turn in about] + [true.compose(about[2])]
    found = of_most_evidence(problem_of(model, true), starts, nowhere)
    assert found[0].pose.error_to(true).within(1.0, 0.01)


@pytest.mark.slow
def test_all_turns_of_a_gear_are_found_when_its_key_seat_is_not_seen() -> None:
    model = Model.of_surface("gear", surface_of(CAD["gear"](np.random.default_rng((501, 5)), 96)))
    true, teeth = tilted(model, 75.0, 300.0), 40
    turns = [matrix_of(np.array([0.0, 0.0, 2.0 * math.pi * k / teeth])) for k in range(teeth)]
    turned = [true.compose(Pose.from_matrix(turn, np.zeros(3))) for turn in turns]
    found = [one.pose for one in of_most_evidence(problem_of(model, true), [turned[7]], nowhere)]
    listed = [any(pose.error_to(one).within(1.0, 0.01) for pose in found) for one in turned]
    assert listed[0]
    assert sum(listed) > 0.8 * teeth


def test_a_pipe_is_turned_by_what_its_nut_allows() -> None:
    """Its collar comes back after a sixth of a turn, its branch does not; the pipe has no near symmetry."""
    lug = np.array([[0.0, -0.01], [0.05, -0.01], [0.05, 0.01], [0.0, 0.01]])
    solids = [
        drilled(circle(0.02, 24), [], 0.0, 0.16),
        drilled(circle(0.035, 6), [], 0.0, 0.02),
        drilled(lug, [], 0.08, 0.1),
    ]
    model = Model.of_surface("pipe", surface_of(solids))
    turn = matrix_of(np.array([math.radians(100.0), 0.0, 0.0])) @ matrix_of(np.array([0.0, 0.0, 0.4]))
    true = Pose.from_matrix(turn, np.array([0.0, 0.0, 0.45]) - turn @ model.middle)
    wrong = true.compose(Pose(np.radians([0.0, 0.0, 60.0]), np.zeros(3)))
    found = of_most_evidence(problem_of(model, true), [wrong], nowhere)
    assert found[0].pose.error_to(true).within(1.0, 0.01)
