"""Poses compose, step and compare as rigid motions do, and refuse numbers that are none."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from geometry.errors import GeometryError
from geometry.pose import Pose, disturbed, near

number = st.floats(-3.0, 3.0)
vectors = st.tuples(number, number, number)
poses = st.builds(Pose, vectors, vectors)


@settings(deadline=None)  # the first call compiles
@given(vectors)
def test_matrix_agrees_with_scipy(vector: tuple[float, float, float]) -> None:
    np.testing.assert_allclose(
        Pose(vector, [0, 0, 1]).matrix, Rotation.from_rotvec(vector).as_matrix(), atol=1e-12
    )


@settings(deadline=None)  # the first call compiles
@given(vectors)
def test_a_matrix_gives_its_pose_back(vector: tuple[float, float, float]) -> None:
    matrix = Rotation.from_rotvec(vector).as_matrix()
    np.testing.assert_allclose(Pose.from_matrix(matrix, [0, 0, 1]).matrix, matrix, atol=1e-12)


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0.6, -0.8, 0), (-0.48, 0.6, 0.64)])
@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-7, np.pi - 1e-7, np.pi])
def test_rotation_vectors_are_exact_near_nothing_and_half_a_turn(
    axis: tuple[float, float, float], angle: float
) -> None:
    vector = np.array(axis) * angle
    pose = Pose.from_matrix(Rotation.from_rotvec(vector).as_matrix(), [0, 0, 1])
    np.testing.assert_allclose(pose.matrix, Rotation.from_rotvec(vector).as_matrix(), atol=1e-9)
    assert np.linalg.norm(pose.rotation_vector) == pytest.approx(angle, abs=1e-9)


@settings(deadline=None)  # the first call compiles
@given(poses, poses)
def test_composing_applies_one_after_the_other(first: Pose, second: Pose) -> None:
    points = np.array([[0.1, 0.2, 0.3], [-1.0, 0.5, 2.0]])
    np.testing.assert_allclose(
        first.compose(second).apply(points), first.apply(second.apply(points)), atol=1e-9
    )


@settings(deadline=None)  # the first call compiles
@given(poses)
def test_inverse_undoes(pose: Pose) -> None:
    points = np.array([[0.1, 0.2, 0.3], [-1.0, 0.5, 2.0]])
    np.testing.assert_allclose(pose.inverse().apply(pose.apply(points)), points, atol=1e-9)


@settings(deadline=None)  # the first call compiles
@given(poses, vectors, vectors)
def test_a_step_multiplies_from_the_left(
    pose: Pose, turn: tuple[float, float, float], move: tuple[float, float, float]
) -> None:
    points = np.array([[0.1, 0.2, 0.3], [-1.0, 0.5, 2.0]])
    stepped = pose.stepped([*turn, *move])
    expected = Rotation.from_rotvec(turn).apply(pose.apply(points)) + move
    np.testing.assert_allclose(stepped.apply(points), expected, atol=1e-9)
    again = pose.stepped(stepped.step_from(pose))
    np.testing.assert_allclose(again.apply(points), expected, atol=1e-6)


def test_error_is_angle_distance_and_share_of_range() -> None:
    true = Pose([0.0, 0.0, 0.5], [0.0, 0.0, 2.0])
    error = Pose([0.0, 0.0, 0.5 + np.radians(3)], [0.0, 0.02, 2.0]).error_to(true)
    assert error.rotation_deg == pytest.approx(3.0)
    assert error.translation_m == pytest.approx(0.02)
    assert error.translation_fraction_of_range == pytest.approx(0.01)
    assert error.within(3.1, 0.011)
    assert not error.within(2.9, 0.011)
    assert not error.within(3.1, 0.009)


def test_dictionary_and_back() -> None:
    pose = Pose([0.1, -0.2, 0.3], [0.4, 0.5, 0.6])
    again = Pose.from_dict(pose.to_dict())
    assert again.to_dict() == {"rotation_vector": [0.1, -0.2, 0.3], "translation": [0.4, 0.5, 0.6]}


@pytest.mark.parametrize(
    "bad", [[0, 0, float("nan")], [0, float("inf"), 0], [0, 0], [[0, 0, 0]], "abc", [0, "x", 1]]
)
def test_bad_numbers_are_refused(bad: object) -> None:
    with pytest.raises(GeometryError, match="rotation_vector"):
        Pose.from_dict({"rotation_vector": bad, "translation": [0, 0, 1]})
    with pytest.raises(GeometryError, match="translation"):
        Pose.from_dict({"rotation_vector": [0, 0, 0], "translation": bad})


def test_a_missing_key_is_named() -> None:
    with pytest.raises(GeometryError, match="no translation"):
        Pose.from_dict({"rotation_vector": [0, 0, 0]})


def test_a_pose_cannot_be_changed() -> None:
    pose = Pose([0, 0, 0], [0, 0, 1])
    with pytest.raises(ValueError, match="read-only"):
        pose.translation[0] = 1.0


def test_disturbed_poses_stay_in_the_search_range() -> None:
    pose, random = Pose([0.4, -0.3, 1.0], [0.1, 0.0, 0.8]), np.random.default_rng(3)
    drawn = [disturbed(pose, random, 25.0, 40.0, 700.0) for _ in range(300)]
    moved = np.array([each.translation - pose.translation for each in drawn])
    reach = 40.0 * 0.8 / 700.0
    assert np.abs(moved).max() <= reach
    assert np.abs(moved).max() > 0.95 * reach
    turns = Rotation.from_matrix(np.array([pose.matrix.T @ each.matrix for each in drawn]))
    angles = np.abs(turns.as_euler("XYZ", degrees=True))
    assert angles.max() <= 25.0 + 1e-9
    assert (angles.max(axis=0) > 24.0).all()


def test_many_poses_at_once_are_near_as_each_by_itself_is() -> None:
    rng, one = np.random.default_rng(4), Pose([0.3, -0.2, 2.9], [0.1, 0.2, 1.5])
    others = [one.stepped(rng.normal(size=6) * ([0.03] * 3 + [0.01] * 3)) for _ in range(200)]
    rotations, translations = np.array([p.matrix for p in others]), np.array([p.translation for p in others])
    each = [other.error_to(one).within(3.0, 0.01) for other in others]
    assert near(rotations, translations, one, 3.0, 0.01).tolist() == each
    assert 0 < sum(each) < len(each)
