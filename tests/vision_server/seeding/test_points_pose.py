"""A pose from pairs of points: the truth comes back, through any lens; what cannot tell one is said."""

from pathlib import Path

import numpy as np
import pytest

from bridge.errors import BadInput
from geometry.camera import Camera
from geometry.model import Model, load_model
from geometry.pose import Pose
from geometry.visibility import visible_samples
from numerics.arrays import Ints
from tests.vision_server.synthetic import CAMERA, POSE, cuboid, linear_picture, photographed
from vision_server.seeding.corners import corners_of
from vision_server.seeding.pairs import Pairs, parsed_pairs, read_lines
from vision_server.seeding.points_pose import pose_of_points, wrong_pair

BENT = Camera(320, 240, 300.0, 305.0, 157.0, 121.0, (-0.3, 0.1, 0.001, -0.002, 0.0))
FISHEYE = Camera(320, 240, 200.0, 200.0, 159.5, 119.5, (0.02, -0.01, 0.0, 0.0), "fisheye")
BLANK = np.zeros((240, 320))


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Model:
    return cuboid(tmp_path_factory.mktemp("seeding"))


def seen_corners(model: Model, camera: Camera, pose: Pose) -> Ints:
    """Vertices that a person could click."""
    lines = visible_samples(model, camera, pose).image
    at = camera.project(pose.apply(model.vertices))
    return np.flatnonzero(np.linalg.norm(at[:, None] - lines, axis=2).min(axis=1) < 2.0)


def pairs_of(model: Model, camera: Camera, pose: Pose, corners: Ints) -> Pairs:
    return Pairs(camera.project(pose.apply(model.vertices[corners])), model.vertices[corners])


@pytest.mark.parametrize("camera", [CAMERA, BENT, FISHEYE])
@pytest.mark.parametrize("corners", [[0, 1, 2, 3], [0, 1, 2, 3, 5, 6]], ids=["on one face", "of several"])
def test_the_truth_comes_back(model: Model, camera: Camera, corners: list[int]) -> None:
    for vector in ([0.5, -0.4, 0.2], [-0.3, 0.6, 1.5], [2.0, 1.0, -0.4]):
        true = Pose(np.array(vector), np.array([0.03, -0.02, 0.4]))
        found = pose_of_points(pairs_of(model, camera, true, np.array(corners)), model, camera, BLANK)
        assert found.pose.error_to(true).within(1e-4, 1e-6)
        assert found.rms_px < 1e-4


def test_points_that_are_a_pixel_off_are_fitted_best(model: Model) -> None:
    corners = seen_corners(model, BENT, POSE)
    exact = pairs_of(model, BENT, POSE, corners)
    noise = np.random.default_rng(3).normal(0.0, 1.0, (len(corners), 2))
    found = pose_of_points(Pairs(exact.pixels + noise, exact.points), model, BENT, BLANK)
    assert found.rms_px < np.sqrt(np.mean(np.sum(noise**2, axis=1)))  # better than the truth
    assert found.pose.error_to(POSE).within(4.0, 0.02)


def test_of_the_poses_that_fit_three_points_the_image_tells_which(model: Model) -> None:
    rng = np.random.default_rng(1)
    ambiguous = 0
    for _ in range(8):
        vector = rng.standard_normal(3)
        true = Pose(rng.uniform(0.2, 3.0) * vector / np.linalg.norm(vector), np.array([0.01, 0.02, 0.42]))
        picture = photographed(linear_picture(model, CAMERA, true))
        corners = rng.permutation(seen_corners(model, CAMERA, true))[:3]
        found = pose_of_points(pairs_of(model, CAMERA, true, corners), model, CAMERA, picture)
        assert found.pose.error_to(true).within(0.1, 0.001)
        ambiguous += bool(found.others)
    assert ambiguous > 0


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        (["10,10 0,0,0", "20,20 0.05,0,0"], "2 of at least 3"),
        (["10,10 0,0,0", "20,20 0.05,0,0", "20,30 0.05,0"], "is not a pair"),
        (["10,10 0,0,0", "20,20 0.05,0,0", "20,x 0.05,0,0.1"], "is not a pair"),
        (["10,10 0,0,0", "20,20 0.05,0,0", "20,nan 0.05,0,0.1"], "not finite"),
        (["10,10 0,0,0", "20,20 0.01,0,0", "20,30 0.02,0,0", "9,9 0.04,0,0"], "model lie on one line"),
        (["10,10 0,0,0", "20,20 0.01,0,0", "30,30 0,0.02,0"], "image lie on one line"),
        (["10,10 0,0,0", "10,10 0.01,0,0", "10,10 0,0.02,0"], "image lie on one line"),
        (["10,10 0,0,0", "20,20 0.01,0,0", "400,30 0,0.02,0"], "outside of the image"),
        (["10,10 0,0,0", "20,20 50,0,0", "20,30 0,40,0"], "far from the model"),
    ],
)
def test_pairs_that_tell_no_pose_are_said(model: Model, lines: list[str], words: str) -> None:
    with pytest.raises(BadInput, match=words):
        pose_of_points(parsed_pairs(lines), model, CAMERA, BLANK)


def test_points_that_only_a_camera_behind_them_sees_so_are_refused(model: Model) -> None:
    """Seen the wrong way round: mirrored in the image, with the face's depth to tell."""
    pairs = pairs_of(model, CAMERA, Pose(np.array([0.5, 0.4, 0.0]), np.array([0.0, 0.0, -0.3])), np.arange(3))
    assert np.isnan(pairs.pixels).all()
    points = Pose(np.array([0.5, 0.4, 0.0]), np.array([0.0, 0.0, -0.3])).apply(model.vertices)
    through = 420.0 * points[:, :2] / points[:, 2:] + [159.5, 119.5]  # as if there were no behind
    kept = [k for k in range(8) if 0 <= through[k, 0] < 320 and 0 <= through[k, 1] < 240]
    found = pose_of_points(Pairs(through[kept], model.vertices[kept]), model, CAMERA, BLANK)
    assert (found.pose.apply(model.vertices[kept])[:, 2] > 0.0).all()  # in front, and so a poor fit
    assert found.rms_px > 2.0


def test_a_file_of_pairs_is_read_in_the_model_s_unit(tmp_path: Path) -> None:
    file = tmp_path / "points.txt"
    file.write_text("# u,v x,y,z\n10,20 1,2,3\n\n 11 21 4 5 6  # the corner with the hole\n")
    pairs = parsed_pairs(read_lines(file), "mm")
    assert pairs.pixels.tolist() == [[10.0, 20.0], [11.0, 21.0]]
    assert np.allclose(pairs.points, [[0.001, 0.002, 0.003], [0.004, 0.005, 0.006]])


def test_corners_are_where_lines_meet_at_an_angle(model: Model) -> None:
    assert corners_of(model).tolist() == list(range(8))


def test_of_a_rounded_corner_one_point_is_given(tmp_path: Path) -> None:
    turn = np.radians(np.arange(0, 360, 15))
    middles = np.column_stack(
        [np.where(np.cos(turn - 1e-6) > 0, 0.5, -0.5), np.where(np.sin(turn + 1e-6) > 0, 0.3, -0.3)]
    )
    rim = middles + 0.03 * np.column_stack([np.cos(turn), np.sin(turn)])
    count = len(rim)
    rows = [f"v {x} {y} {z}" for z in (0.0, 0.1) for x, y in rim]
    ahead = [(k, (k + 1) % count) for k in range(count)]
    faces = [face for k, m in ahead for face in ((k, m, m + count), (k, m + count, k + count))]
    faces += [face for k, m in ahead[1:-1] for face in ((0, m, k), (count, k + count, m + count))]
    rows += ["f " + " ".join(str(corner + 1) for corner in face) for face in faces]
    file = tmp_path / "plate.obj"
    file.write_text("\n".join(rows))
    plate = load_model(file)
    found = plate.vertices[corners_of(plate)]
    quadrants = sorted((x > 0, y > 0, z > 0.05) for x, y, z in found)
    assert len(found) == 8 and len(set(quadrants)) == 8


def test_the_wrong_pair_is_named_though_right_ones_are_farther_off(model: Model) -> None:
    rng = np.random.default_rng(5)
    named = farther = 0
    for _ in range(12):
        exact = pairs_of(model, BENT, POSE, rng.permutation(len(model.vertices))[:5])
        assert wrong_pair(pose_of_points(exact, model, BENT, BLANK), exact, model, BENT) is None
        pixels = exact.pixels.copy()
        wrong = int(rng.integers(5))
        pixels[wrong] += 40.0 * np.sign([157.0, 121.0] - pixels[wrong])  # towards the middle
        pairs = Pairs(pixels, exact.points)
        found = pose_of_points(pairs, model, BENT, BLANK)
        said = wrong_pair(found, pairs, model, BENT)
        assert said is not None
        named += f"without pair {wrong + 1} the others fit to 0.0 px" in said
        farther += int(found.errors_px.argmax()) != wrong
    assert named == 12
    assert farther > 2
