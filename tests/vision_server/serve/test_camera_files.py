"""Camera files of other programs are read as they are; each lens projects as its own program does."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from bridge.errors import BadInput
from geometry.pose import Pose, disturbed
from tests.vision_server.synthetic import CAMERA, POSE, cuboid, linear_picture, one_image, photographed
from vision_server.pipeline import estimate_pose
from vision_server.serve.inputs import read_camera, read_camera_file

MATRIX = np.array([[700.0, 0.0, 321.5], [0.0, 690.0, 238.0], [0.0, 0.0, 1.0]])
PINHOLE = (-0.25, 0.08, 0.001, -0.002, 0.01)
RATIONAL = (0.1, 0.05, 0.001, -0.002, 0.01, 0.3, -0.02, 0.004)
PRISM = (*RATIONAL, 0.002, -0.001, 0.0015, 0.0005)
SKEW = np.array([[0.0, 5.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
FISHEYE = (0.05, -0.01, 0.004, -0.001)


def points() -> np.ndarray:
    rng = np.random.default_rng(0)
    return np.column_stack([rng.uniform(-0.4, 0.4, (60, 2)), rng.uniform(0.9, 2.0, 60)])


def opencv_file(path: Path, coefficients: tuple[float, ...], **more: int) -> Path:
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    for name, value in {"image_width": 640, "image_height": 480, **more}.items():
        storage.write(name, value)
    storage.write("camera_matrix", MATRIX)
    storage.write("distortion_coefficients", np.array([coefficients]))
    storage.release()
    return path


def ros_file(path: Path, model: str, coefficients: tuple[float, ...], matrix: np.ndarray = MATRIX) -> Path:
    path.write_text(
        f"""image_width: 640
image_height: 480
camera_name: head
camera_matrix:
  rows: 3
  cols: 3
  data: {matrix.ravel().tolist()}
distortion_model: {model}
distortion_coefficients:
  rows: 1
  cols: {len(coefficients)}
  data: {list(coefficients)}
"""
    )
    return path


def message_file(path: Path, model: str, coefficients: tuple[float, ...], more: str = "") -> Path:
    """As `ros2 topic echo --once` prints it; ROS 1 has K and D."""
    k, d = ("K", "D") if "old" in path.name else ("k", "d")
    path.write_text(
        f"""header:
  frame_id: camera
height: 480
width: 640
distortion_model: {model}
{d}:
{"".join(f"- {one}{chr(10)}" for one in coefficients)}{k}:
{"".join(f"- {one}{chr(10)}" for one in MATRIX.ravel())}roi:
  height: 0
  width: 0
{more}---
"""
    )
    return path


def kalibr_file(path: Path, model: str, coefficients: tuple[float, ...], camera: str = "pinhole") -> Path:
    path.write_text(
        f"""cam0:
  cam_overlaps: [1]
  camera_model: {camera}
  distortion_coeffs: {list(coefficients)}
  distortion_model: {model}
  intrinsics: [700.0, 690.0, 321.5, 238.0]
  resolution: [640, 480]
  rostopic: /cam0/image_raw
"""
    )
    return path


def visp_file(path: Path, model: str = "perspectiveProjWithDistortion") -> Path:
    bent = "<kud>-0.21</kud><kdu>0.22</kdu>" if "With" in model and "Without" not in model else ""
    path.write_text(
        f"""<?xml version="1.0"?>
<root><camera><name>Camera</name><image_width>640</image_width><image_height>480</image_height>
<model><type>{model}</type><px>700</px><py>690</py><u0>321.5</u0><v0>238</v0>{bent}</model>
</camera></root>
"""
    )
    return path


def replaced(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


def expected(lens: str, coefficients: tuple[float, ...]) -> np.ndarray:
    none = np.zeros(3)
    if lens == "fisheye":
        seen, _ = cv2.fisheye.projectPoints(points()[:, None], none, none, MATRIX, np.array(coefficients))
        return np.asarray(seen[:, 0])
    seen, _ = cv2.projectPoints(points(), none, none, MATRIX, np.array(coefficients))
    return np.asarray(seen[:, 0])


@pytest.mark.parametrize(
    ("program", "lens", "coefficients"),
    [
        ("opencv.yaml", "pinhole", PINHOLE),
        ("opencv.xml", "pinhole", RATIONAL),
        ("opencv.yml", "pinhole", PRISM),
        ("opencv-long.yml", "pinhole", (*PRISM, 0.0, 0.0)),
        ("opencv-fisheye.yaml", "fisheye", FISHEYE),
        ("ros.yaml", "plumb_bob", PINHOLE),
        ("ros-rational.yaml", "rational_polynomial", RATIONAL),
        ("ros-fisheye.yaml", "equidistant", FISHEYE),
        ("message.yaml", "plumb_bob", PINHOLE),
        ("message-old.yaml", "equidistant", FISHEYE),
        ("kalibr.yaml", "radtan", PINHOLE[:4]),
        ("kalibr-fisheye.yaml", "equidistant", FISHEYE),
        ("visp.xml", "pinhole", (-0.21, 0.0, 0.0, 0.0)),
    ],
)
def test_each_file_projects_as_its_program_does(
    tmp_path: Path, program: str, lens: str, coefficients: tuple[float, ...]
) -> None:
    path = tmp_path / program
    if program.startswith("opencv"):
        opencv_file(path, coefficients, **({"fisheye_model": 1} if lens == "fisheye" else {}))
    elif program.startswith("ros"):
        ros_file(path, lens, coefficients)
    elif program.startswith("message"):
        message_file(path, lens, coefficients)
    elif program.startswith("kalibr"):
        kalibr_file(path, lens, coefficients)
    else:
        visp_file(path)
    camera, _ = read_camera(path)
    assert (camera.width, camera.height) == (640, 480)
    seen = camera.project(points())
    true = expected("fisheye" if lens in ("fisheye", "equidistant") else "pinhole", coefficients)
    np.testing.assert_allclose(seen, true, atol=1e-6)
    np.testing.assert_allclose(camera.undistort_points(seen), camera.ideal.project(points()), atol=1e-6)
    assert read_camera_file(path).target.range_m is None


@pytest.mark.parametrize(
    ("made", "said"),
    [
        (lambda path: opencv_file(path, (*PRISM, 0.01, 0.0)), "sensor is tilted"),
        (lambda path: kalibr_file(path, "fov", (0.9,)), "distortion_model is fov"),
        (lambda path: kalibr_file(path, "none", (), "omni"), "camera_model is omni"),
        (
            lambda path: ros_file(path, "plumb_bob", PINHOLE, MATRIX.T),
            "matrix is not fx 0 cx, 0 fy cy, 0 0 1",
        ),
        (lambda path: ros_file(path, "plumb_bob", PINHOLE, MATRIX + SKEW), "one with a skew is not known"),
        (lambda path: message_file(path, "plumb_bob", PINHOLE, "binning_x: 2\n"), "images are binned"),
        (lambda path: path.write_text("width: 640\n"), "no height"),
        (lambda path: path.write_text("a: [1, 2"), "no camera file"),
        (
            lambda path: path.write_text("%YAML:1.0\n---\nimage_width: 64\nimage_height: 48\n"),
            "no camera_matrix",
        ),
        (lambda path: path.write_text("cam0: pinhole\n"), "something in it is no"),
        (lambda path: replaced(opencv_file(path, PINHOLE), "690.", "6!9"), "something in it is no matrix"),
        (lambda path: replaced(opencv_file(path, PINHOLE), "rows: 3", "rows: 3: 3"), "no camera file"),
        (
            lambda path: path.write_text("image_width: 9\nimage_height: 9\ncamera_matrix: 3\n"),
            "something in it is no matrix",
        ),
        (lambda path: path.write_text("image_width: 640\n"), "no image_height"),
        (lambda path: path.write_text("- 1\n"), "no names"),
    ],
)
def test_what_cannot_be_read_says_why_and_what_to_write(tmp_path: Path, made: object, said: str) -> None:
    path = tmp_path / "camera.yaml"
    made(path)  # type: ignore[operator]
    with pytest.raises(BadInput, match=said) as caught:
        read_camera(path)
    assert "TOML file with [camera]" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_other_models_of_visp_are_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="ProjWithKannalaBrandtDistortion"):
        read_camera(visp_file(tmp_path / "camera.xml", "ProjWithKannalaBrandtDistortion"))


@pytest.mark.parametrize(
    ("lens", "coefficients"),
    [("fisheye", (0.2, -0.05, 0.0, 0.0)), ("pinhole", (*PRISM[:8], 0.02, 0, 0.02, 0))],
)
def test_a_pose_is_right_through_the_lens_and_wrong_without_it(
    tmp_path: Path, lens: str, coefficients: tuple[float, ...]
) -> None:
    near = Pose(POSE.rotation_vector, np.array([0.03, -0.015, 0.30]))  # out to the frame's rim
    model = cuboid(tmp_path)
    camera = replace(CAMERA, distortion=coefficients, lens=lens)
    wide = replace(CAMERA, width=480, height=400, cx=239.5, cy=199.5)
    straight = linear_picture(model, wide, near, (0.3, 0.7, 0.2, 0.9, 0.5, 0.8), blur_px=0.4)
    y, x = np.mgrid[: camera.height, : camera.width].astype(np.float64)
    places = camera.undistort_points(np.column_stack([x.ravel(), y.ravel()])) + 80.0
    u, v = places.reshape(camera.height, camera.width, 2).astype(np.float32).transpose(2, 0, 1)
    bent = cv2.remap(straight, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    images = one_image(photographed(np.asarray(bent, np.float64)))
    start = disturbed(near, np.random.default_rng(1), 8.0, 8.0, camera.fx)
    found = estimate_pose(images, ["i1"], model, camera, start)
    assert found.pose is not None
    assert 1e3 * float(np.linalg.norm(found.pose.translation - near.translation)) < 0.15
    without = estimate_pose(images, ["i1"], model, CAMERA, start)
    assert without.pose is None or (
        1e3 * float(np.linalg.norm(without.pose.translation - near.translation)) > 0.6
    )
