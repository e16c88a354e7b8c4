"""Faces that are seen narrow: which lines are beside them, and what else they leave open."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from benchmarks.films import CAMERA as film_camera  # noqa: N811
from benchmarks.films import film
from geometry.camera import Camera
from geometry.model import TARGETS, Model, load_model
from geometry.pose import RIGHT, Pose
from geometry.rotation import matrix_of
from numerics.arrays import Floats
from tests.vision_server.synthetic import CAMERA, POSE, linear_picture, photographed
from tests.vision_server.tracking.films import GREYS
from vision_server.tracking.acceptance import is_exact
from vision_server.tracking.fitting import MOST_SEEN_LINES, Habits
from vision_server.tracking.following import Found, Sight, turned_about
from vision_server.tracking.frame import Tone
from vision_server.tracking.narrow import NARROW_PX, firmest, narrow_px2

BEHIND = 0.08  # as dark as what is behind the target
LEARNT_OFF_PX = 0.1  # what lines of a true model are off, as its frames show


def seen_at(*degrees: float) -> Pose:
    return Pose.from_matrix(matrix_of(np.radians(degrees)), POSE.translation)


def front_alone(model: Model, pose: Pose) -> list[float]:
    """Greys of faces of which one is seen, the others are as dark as what is behind them."""
    front = int(np.argmin((model.face_normals @ pose.matrix.T)[:, 2]))
    return [0.9 if face == front else BEHIND for face in range(len(model.faces))]


def looked_at(model: Model, pose: Pose, greys: list[float], start: Pose) -> tuple[Found, Found, bool]:
    """What is found from a start, what that becomes, and whether it is clear."""
    sight, habits = Sight(model, CAMERA, Tone.of(1.0, 0.01)), Habits.of(model)
    pixels = photographed(linear_picture(model, CAMERA, pose, greys), 0.8, seed=1)
    found = sight.near(pixels, start, habits)
    assert found is not None
    return found, *firmest(found, sight, habits)


def plain_narrow_px2(model: Model, camera: Camera, pose: Pose) -> Floats:
    """One line after the other."""
    out = np.zeros(len(model.lines))
    for line, ends in enumerate(model.vertices[model.lines]):
        along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        seen = camera.project(pose.apply(ends))
        normal = np.array([-1.0, 1.0]) * (seen[1] - seen[0])[::-1] / np.linalg.norm(seen[1] - seen[0])
        middle = ends.mean(axis=0)
        for face in model.line_faces[line]:
            if face < 0 or model.smooth[line]:
                continue
            off = model.vertices[model.faces[face]] - ends[0]
            off = off - np.outer(off @ along, along)
            far = middle + off[np.argmax((off**2).sum(axis=1))]
            at = camera.project(pose.apply(np.array([middle, far])))
            whole = camera.fy * np.linalg.norm(far - middle) / pose.apply(middle[None])[0, 2]
            if abs((at[1] - at[0]) @ normal) < NARROW_PX:
                out[line] = max(out[line], min(whole, NARROW_PX) ** 2)
    return out


@pytest.mark.parametrize("target", ["satellite", "fixture"])
def test_lines_beside_narrow_faces_are_uncertain_by_what_these_are_across(target: str) -> None:
    model, rng = load_model(TARGETS / f"{target}.cao"), np.random.default_rng(1)
    for _ in range(20):
        turn = matrix_of(rng.normal(size=3))
        pose = Pose.from_matrix(turn, np.array([0.0, 0.0, 3.0 * model.diameter]) - turn @ model.middle)
        variance = narrow_px2(model, CAMERA, pose)
        assert variance == pytest.approx(plain_narrow_px2(model, CAMERA, pose))
        assert variance.any()


def test_a_square_look_at_a_box_has_narrow_sides_and_one_at_its_corner_has_none(model: Model) -> None:
    assert np.count_nonzero(narrow_px2(model, CAMERA, seen_at(5.0, 5.0, 10.0))) >= 4
    assert not narrow_px2(model, CAMERA, POSE).any()


def test_an_outline_that_sits_on_a_crease_is_noticed(model: Model) -> None:
    pose = seen_at(5.0, 5.0, 10.0)
    found, told, clear = looked_at(model, pose, front_alone(model, pose), seen_at(5.0, 8.0, 10.0))
    assert not found.pose.error_to(pose).within(2.0, 0.02)
    assert told is found  # what is better is hardly believed
    assert not clear


def test_the_pose_that_such_an_outline_is_beside_is_found() -> None:
    model, frames = film(80078, "fast", 120)
    shown = next(itertools.islice(frames, 105, None))
    sight, habits = Sight(model, film_camera, Tone.of(1.0, 0.01)), Habits.of(model)
    habits = habits._replace(off_px2=LEARNT_OFF_PX**2, seen=MOST_SEEN_LINES)
    start = turned_about(shown.pose, model.middle, np.radians([0.0, 3.0, 0.0]))
    found = sight.near(shown.pixels, start, habits)
    assert found is not None
    assert not found.pose.error_to(shown.pose).within(3.0, 0.02)
    better, clear = firmest(found, sight, habits)
    assert better.pose.error_to(shown.pose).within(0.3, 0.003)
    assert clear


def test_what_nothing_but_lines_beside_narrow_faces_tells_is_not_clear(model: Model) -> None:
    pose = seen_at(5.0, 5.0, 10.0)
    found, same, clear = looked_at(model, pose, front_alone(model, pose), pose)
    assert is_exact(found.pose, found.covariance)
    assert same is found
    assert not clear


def test_what_hangs_on_lines_beside_narrow_faces_is_clear_only_where_these_hold_it_to_what_is_right() -> None:
    model, frames = film(96018, "fast", 120)
    shown = next(itertools.islice(frames, 19, None))
    sight, habits = Sight(model, film_camera, Tone.of(1.0, 0.01)), Habits.of(model)
    found = sight.near(shown.pixels, shown.pose, habits)
    assert found is not None
    same, clear = firmest(found, sight, habits)
    assert same is found  # nothing else is found aside
    assert not found.pose.error_to(shown.pose).within(*RIGHT)
    assert is_exact(found.pose, found.covariance)
    assert not clear


def test_a_pose_that_other_lines_hold_is_clear_and_stays(model: Model) -> None:
    found, same, clear = looked_at(model, POSE, list(GREYS), POSE)
    assert same is found
    assert clear
