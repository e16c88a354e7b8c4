"""Projection agrees with OpenCV, and undistortion undoes it."""

import cv2
import numpy as np
import pytest

from geometry.camera import Camera
from geometry.errors import GeometryError

LENS = Camera(640, 480, 700.0, 690.0, 319.5, 239.5, (-0.25, 0.08, 0.001, -0.002, 0.01))


def points(seed: int = 0) -> np.ndarray:
    random = np.random.default_rng(seed)
    return np.column_stack([random.uniform(-0.3, 0.3, (50, 2)), random.uniform(0.8, 2.0, 50)])


def test_projection_agrees_with_opencv() -> None:
    matrix = np.array([[LENS.fx, 0, LENS.cx], [0, LENS.fy, LENS.cy], [0, 0, 1]])
    expected, _ = cv2.projectPoints(points(), np.zeros(3), np.zeros(3), matrix, np.array(LENS.distortion))
    np.testing.assert_allclose(LENS.project(points()), expected[:, 0], atol=1e-9)


@pytest.mark.parametrize("count", [4, 5, 8, 12])
def test_cameras_of_opencv_are_read_with_all_their_coefficients(count: int) -> None:
    coefficients = [-0.2, 0.05, 0.001, -0.002, 0.01, 0.03, -0.02, 0.004, 0.002, -0.001, 0.0015, 0.0005][
        :count
    ]
    lens = Camera.from_dict(LENS.to_dict() | {"distortion": coefficients})
    matrix = np.array([[lens.fx, 0, lens.cx], [0, lens.fy, lens.cy], [0, 0, 1]])
    expected, _ = cv2.projectPoints(points(), np.zeros(3), np.zeros(3), matrix, np.array(coefficients))
    seen = lens.project(points())
    np.testing.assert_allclose(seen, expected[:, 0], atol=1e-9)
    back = lens.undistort_points(seen)
    np.testing.assert_allclose(back, lens.ideal.project(points()), atol=1e-6)


def test_undistortion_undoes_the_lens() -> None:
    np.testing.assert_allclose(
        LENS.undistort_points(LENS.project(points())), LENS.ideal.project(points()), atol=1e-6
    )


def test_a_point_that_is_not_in_front_has_no_pixel() -> None:
    pixels = LENS.project(np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 0.0], [0.1, 0.0, -1.0]]))
    assert np.isnan(pixels[1:]).all()
    np.testing.assert_allclose(pixels[0], [319.5, 239.5])


def test_dictionary_and_back() -> None:
    assert Camera.from_dict(LENS.to_dict()) == LENS


def test_a_camera_table_among_other_things_is_read() -> None:
    table = {"camera": {**LENS.to_dict(), "gain": 2.0, "shutters_s": [0.1]}, "target": {}}
    assert Camera.from_dict(table) == LENS


def test_no_distortion_may_be_left_out() -> None:
    table = LENS.to_dict()
    del table["distortion"]
    assert Camera.from_dict(table) == LENS.ideal
    assert not LENS.ideal.distorted


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"fx": 0}, "focal"),
        ({"fy": -1.0}, "focal"),
        ({"width": 0}, "size"),
        ({"cx": float("nan")}, "finite"),
        ({"cx": "left"}, "numbers"),
        ({"distortion": [0.1]}, "four, five, eight or twelve"),
        ({"distortion": [0.1] * 14}, "got 14"),
        ({"distortion": [0, 0, 0, 0, float("inf")]}, "finite"),
        ({"fx": 1e300}, "fx must be at most"),
        ({"cy": -1e7}, "cy must be at most"),
        ({"fx": 10**400}, "needs numbers"),
        ({"fx": 8.0}, "no pinhole camera sees. It is the focal length in px"),
    ],
)
def test_bad_values_are_refused(change: dict[str, object], message: str) -> None:
    with pytest.raises(GeometryError, match=message):
        Camera.from_dict({**LENS.to_dict(), **change})


def test_missing_values_are_named() -> None:
    with pytest.raises(GeometryError, match="fx, cy"):
        Camera.from_dict({"width": 640, "height": 480, "fy": 1.0, "cx": 1.0})


def test_a_fisheye_is_read_from_its_table_and_written_back() -> None:
    lens = Camera.from_dict(LENS.to_dict() | {"distortion": [0.05, -0.01, 0.004, -0.001], "lens": "fisheye"})
    assert lens.distorted
    assert Camera.from_dict(lens.to_dict()) == lens
    with pytest.raises(GeometryError, match="four of a fisheye"):
        Camera.from_dict(lens.to_dict() | {"distortion": [0.1] * 5})
    untold = lens.to_dict() | {"distortion": [0.0] * 5}  # as a typed table has it
    assert Camera.from_dict(untold).distortion == (0.0,) * 4
    with pytest.raises(GeometryError, match="lens must be"):
        Camera.from_dict(lens.to_dict() | {"lens": "mirror"})


def test_the_rim_of_a_fisheye_is_finite() -> None:
    lens = Camera(640, 480, 200.0, 200.0, 319.5, 239.5, (0.0, 0.0, 0.0, 0.0), "fisheye")
    assert np.isfinite(lens.undistort_points(np.array([[0.0, 0.0], [639.0, 479.0], [319.5, 239.5]]))).all()


def test_the_camera_of_a_part_of_the_image_sees_the_same() -> None:
    part = LENS.part((30, 20, 330, 260))
    assert (part.width, part.height) == (300, 240)
    np.testing.assert_allclose(part.project(points()) + np.array([30, 20]), LENS.project(points()))


def test_the_camera_of_a_smaller_image_sees_the_same() -> None:
    small = LENS.scaled(0.25)
    assert (small.width, small.height) == (160, 120)
    np.testing.assert_allclose((small.project(points()) + 0.5) / 0.25 - 0.5, LENS.project(points()))


@pytest.mark.parametrize("distortion", [(-1.4, 0.0, 0.0, 0.0, 0.0), (100.0, 1.0, 0.0, 0.0, 0.0)])
def test_a_distortion_that_cannot_be_undone_is_refused(distortion: tuple[float, ...]) -> None:
    with pytest.raises(GeometryError, match=r"distortion cannot be undone at 0, 0 px"):
        Camera.from_dict(LENS.to_dict() | {"distortion": distortion})
