"""Visible samples agree with a ray cast for each sample, and lie where the camera sees them."""

from pathlib import Path

import numpy as np
import pytest

from geometry.camera import Camera
from geometry.errors import GeometryError
from geometry.model import Model, find_target, load_model
from geometry.pose import Pose
from geometry.visibility import visible_samples
from tests.geometry.plain_visibility import hidden, turned_to_camera

CAMERA = Camera(640, 480, 700.0, 690.0, 319.5, 239.5)
WIDE = Camera(6400, 4800, 700.0, 690.0, 3199.5, 2399.5)

NOTCHED = """V1
8
0 0 0
3 0 0
3 3 0
2 3 0
2 1 0
1 1 0
1 3 0
0 3 0
0
0
1
8 0 1 2 3 4 5 6 7
0
0
"""


def random_pose(seed: int, distance: float = 1.0) -> Pose:
    random = np.random.default_rng(seed)
    return Pose(random.uniform(-2.5, 2.5, 3), np.array([*random.uniform(-0.05, 0.05, 2), distance]))


def model_of(text: str, folder: Path) -> Model:
    file = folder / "model.cao"
    file.write_text(text)
    return load_model(file)


def in_front(model: Model, pose: Pose) -> dict[int, np.ndarray]:
    """Dense points on each line that is turned to the camera, away from its ends."""
    along = np.linspace(0.013, 0.987, 41)[:, None]
    ends = model.vertices[model.lines]
    return {
        i: ends[i, 0] + along * (ends[i, 1] - ends[i, 0])
        for i in range(len(model.lines))
        if turned_to_camera(model, pose, i)
    }


def crown(seed: int, folder: Path) -> Model:
    """A prism over a star-shaped polygon with random corners: mostly re-entrant, each time another."""
    random = np.random.default_rng(seed)
    corners = 9
    angles = 2 * np.pi * (np.arange(corners) + random.uniform(-0.3, 0.3, corners)) / corners
    outline = random.uniform(0.04, 0.2, corners)[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    points = [(x, y, z) for z in (-0.06, 0.06) for x, y in outline.tolist()]
    sides = [(i, (i + 1) % corners, (i + 1) % corners + corners, i + corners) for i in range(corners)]
    faces = [tuple(range(corners))[::-1], tuple(range(corners, 2 * corners)), *sides]
    text = ["V1", str(len(points)), *(" ".join(map(repr, point)) for point in points), "0", "0"]
    text += [str(len(faces)), *(" ".join(map(str, (len(face), *face))) for face in faces), "0", "0"]
    return model_of("\n".join(text), folder)


@pytest.mark.parametrize("seed", range(8))
def test_random_shapes_with_re_entrant_corners_agree_with_ray_casting(seed: int, tmp_path: Path) -> None:
    must_agree_with_ray_casting(crown(seed, tmp_path), random_pose(100 + seed))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cube", "fixture", "satellite"])
@pytest.mark.parametrize("seed", range(6))
def test_agrees_with_ray_casting(name: str, seed: int) -> None:
    must_agree_with_ray_casting(load_model(find_target(name)), random_pose(seed))


def must_agree_with_ray_casting(model: Model, pose: Pose) -> None:
    """Every sample can be seen, and every point of a line that can be seen has a sample."""
    samples = visible_samples(model, WIDE, pose, spacing_px=0.5)
    assert not hidden(model, pose, samples.points[::9]).any()
    for line, points in in_front(model, pose).items():
        pixels = WIDE.project(pose.apply(points))
        if np.hypot(*(pixels[-1] - pixels[0])) < 6:
            continue
        mine = samples.image[samples.line == line]
        seen = ~hidden(model, pose, points)
        gap = np.array([np.hypot(*(mine - p).T).min() if len(mine) else np.inf for p in pixels])
        steps = np.abs(np.diff(seen.astype(int)))
        edge = np.convolve(np.concatenate([[0], steps, [0]]), np.ones(3), "same")[: len(seen)] > 0
        clear = ~edge & ~np.roll(edge, 1)
        assert (gap[seen & clear] < 1.0).all()
        assert (gap[~seen & clear] > 0.2).all()


def test_lines_of_faces_that_look_away_are_hidden() -> None:
    model = load_model(find_target("cube"))
    samples = visible_samples(model, CAMERA, Pose([0.5, 0.4, 0.2], [0, 0, 1.2]))
    assert len(set(samples.line.tolist())) == 9


def test_a_block_on_a_plate_shows_its_foot() -> None:
    model = load_model(find_target("fixture"))
    pose = Pose([0.0, 0.0, 0.0], [0.0, 0.0, 0.8])  # straight from -z, where posts stand up from the plate
    samples = visible_samples(model, CAMERA, pose)
    foot = np.flatnonzero((np.abs(model.vertices[model.lines][:, :, 2]) == 0).all(axis=1))
    shown = set(samples.line.tolist())
    beside_post = [i for i in foot if np.abs(model.vertices[model.lines[i], :2]).max() < 0.08]
    assert len(beside_post) == 4
    assert shown.issuperset(beside_post)


def test_samples_lie_on_their_lines_and_stand_for_their_length() -> None:
    model, pose = load_model(find_target("cube")), Pose([0.5, 0.4, 0.2], [0.02, 0, 1.2])
    samples = visible_samples(model, CAMERA, pose, spacing_px=3.0)
    ends = model.vertices[model.lines[samples.line]]
    off = np.cross(samples.points - ends[:, 0], samples.direction)
    assert np.abs(off).max() < 1e-12
    np.testing.assert_allclose(CAMERA.project(pose.apply(samples.points)), samples.image, atol=1e-9)
    for line in set(samples.line.tolist()):
        first, last = CAMERA.project(pose.apply(model.vertices[model.lines[line]]))
        length = np.hypot(*(last - first))
        assert samples.px[samples.line == line].sum() == pytest.approx(length)
        turned = samples.image_direction[samples.line == line] @ ((last - first) / length)
        np.testing.assert_allclose(np.abs(turned), 1.0, atol=1e-9)


def test_samples_stay_in_the_image() -> None:
    model = load_model(find_target("satellite"))
    samples = visible_samples(model, CAMERA, Pose([0.3, 0.5, 0.1], [0.2, 0.1, 0.5]))
    assert len(samples.px) > 0
    assert (samples.image >= 0).all()
    assert (samples.image <= [639, 479]).all()


def test_a_model_around_the_camera_is_cut_at_the_near_plane() -> None:
    model = load_model(find_target("satellite"))
    samples = visible_samples(model, CAMERA, Pose([0.3, 0.8, 0.1], [0.0, 0.15, 0.1]))
    depth = Pose([0.3, 0.8, 0.1], [0.0, 0.15, 0.1]).apply(samples.points)[:, 2]
    assert (depth > 0).all()
    assert np.isfinite(samples.image).all()


def test_a_model_behind_the_camera_shows_nothing() -> None:
    model = load_model(find_target("cube"))
    assert len(visible_samples(model, CAMERA, Pose([0.5, 0.4, 0.2], [0, 0, -1.2])).px) == 0


def test_lines_too_short_in_the_image_are_left_out() -> None:
    model = load_model(find_target("cube"))
    assert len(visible_samples(model, CAMERA, Pose([0.5, 0.4, 0.2], [0, 0, 60.0])).px) == 0


def test_a_concave_face_hides_only_what_is_behind_it(tmp_path: Path) -> None:
    notched = model_of(NOTCHED, tmp_path)
    through = np.array([[1.5, 2.5, 1.0], [0.5, 2.5, 1.0], [2.5, 2.5, 1.0], [1.5, 0.5, 1.0]])
    text = NOTCHED.replace("V1\n8\n", "V1\n16\n").replace(
        "0 3 0\n0\n0\n1\n",
        "0 3 0\n"
        + "".join(f"{x} {y - d} 1\n{x} {y + d} 1\n" for x, y, _ in through for d in (0.2,))
        + "4\n8 9\n10 11\n12 13\n14 15\n0\n1\n",
    )
    model = model_of(text, tmp_path)
    pose = Pose([0, 0, 0], [-1.5, -1.5, 30.0])  # from -z: the notched face at z = 0, the bars behind it
    shown = set(visible_samples(model, CAMERA, pose, 0.5).line.tolist())
    bars = [i for i in range(len(model.lines)) if (model.vertices[model.lines[i], 2] == 1).all()]
    seen = [abs(model.vertices[model.lines[i], 0].mean() - 1.5) < 0.1 for i in bars if i in shown]
    assert seen == [True]
    assert model.vertices[model.lines[next(i for i in bars if i in shown)], 1].mean() > 2
    assert len(notched.triangles) == 6


CYLINDER = """V1
2
0 0 -0.2
0 0 0.2
0
0
0
1
0 1 0.1
{circles}
"""


def test_a_cylinder_shows_two_sides_and_its_rims(tmp_path: Path) -> None:
    model = model_of(CYLINDER.format(circles="0"), tmp_path)
    samples = visible_samples(model, CAMERA, Pose([np.pi / 2, 0, 0], [0, 0, 2.0]))
    sides = [i for i in set(samples.line.tolist()) if model.smooth[i]]
    assert len(sides) == 2
    across = np.abs(model.vertices[model.lines[sides], :2]).max()
    assert across == pytest.approx(0.1, rel=0.02)
    assert set(samples.line.tolist()) - set(sides)


def test_a_lens_bends_samples_as_it_bends_points() -> None:
    lens = Camera(640, 480, 700.0, 690.0, 319.5, 239.5, (-0.25, 0.08, 0.001, -0.002, 0.01))
    model, pose = load_model(find_target("satellite")), Pose([0.5, 0.4, 0.2], [0.05, 0, 0.8])
    samples = visible_samples(model, lens, pose)
    np.testing.assert_allclose(lens.project(pose.apply(samples.points)), samples.image, atol=1e-9)
    step = 1e-6
    ahead = lens.project(pose.apply(samples.points + step * samples.direction))
    turned = (ahead - samples.image) / np.linalg.norm(ahead - samples.image, axis=1, keepdims=True)
    assert np.abs(np.abs(np.sum(turned * samples.image_direction, axis=1)) - 1).max() < 1e-5
    straight = visible_samples(model, lens.ideal, pose)
    assert samples.px.sum() < straight.px.sum()  # this lens shrinks the image


@pytest.mark.parametrize("spacing", [0.0, -1.0, float("nan")])
def test_spacing_must_be_positive(spacing: float) -> None:
    model = load_model(find_target("cube"))
    with pytest.raises(GeometryError, match="spacing"):
        visible_samples(model, CAMERA, Pose([0, 0, 0], [0, 0, 1]), spacing)
