"""First sight: the pose without a seed pose, all that fit where there are several, and what narrows it."""

import numpy as np
import pytest

from benchmarks.machined_parts import ROUND, surface_of
from benchmarks.synthetic_parts import rendered
from geometry.camera import Camera
from geometry.errors import GeometryError
from geometry.model import Model, find_target, load_model
from geometry.pose import Pose
from geometry.rotation import matrix_of
from numerics.arrays import Floats
from tests.vision_server.matching_scenes import CAMERA, segments_of
from tests.vision_server.synthetic import one_image
from vision_server.matching import Anywhere
from vision_server.matching.first_sight import match_anywhere
from vision_server.matching.looks import Look
from vision_server.matching.match import SEEN_SIZE_SHARES
from vision_server.matching.templates import Templates, sizes_px, templates, vote
from vision_server.segments.extraction import extract_segments

CASES = [
    pytest.param(name, seed, marks=[pytest.mark.slow] if (name, seed) != ("satellite", 0) else [])
    for name in ("fixture", "satellite")
    for seed in range(3)
]


def any_pose(seed: int, size: float, diameter: float, middle: Floats) -> Pose:
    """Any orientation; the target as wide as this share of the frame's height, and off its middle."""
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=3)
    rotation = matrix_of(axis / np.linalg.norm(axis) * rng.uniform(0.0, np.pi))
    range_m = CAMERA.fy * diameter / (size * CAMERA.height)
    aside = rng.uniform(-0.1, 0.1, 2) * range_m * CAMERA.height / CAMERA.fy
    return Pose.from_matrix(rotation, np.array([*aside, range_m]) - rotation @ middle)


@pytest.mark.parametrize(("name", "seed"), CASES)
def test_finds_any_orientation_in_clutter(name: str, seed: int) -> None:
    model = load_model(find_target(name))
    pose = any_pose(seed, (0.45, 0.7, 0.9)[seed], model.diameter, model.middle)
    found = match_anywhere(segments_of(model, pose, clutter=60, seed=seed), model, CAMERA, Anywhere())
    right = [one.score for one in found if one.pose.error_to(pose).within(2.0, 0.02)]
    assert right[0] > 0.99 * found[0].score  # the fixture looks nearly alike from the other side


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 3])
def test_a_part_that_shows_curves_only_is_found(seed: int) -> None:
    """Its small holes are not seen as segments, and a very small flange fits any of its edges."""
    model = Model.of_surface("flange", surface_of(ROUND["flange"](48)))
    pose = any_pose(seed, 0.65, model.diameter, model.middle)
    images = one_image(rendered(model, CAMERA, pose, np.random.default_rng(seed)))
    segments = extract_segments(images.edge_map(["i1"])).endpoints
    found = match_anywhere(segments, model, CAMERA, Anywhere())[0].pose
    axes = pose.matrix[:, 2], found.matrix[:, 2]  # it may be turned about its axis, see `spun`
    assert np.degrees(np.arccos(axes[0] @ axes[1])) < 4.0
    assert found.error_to(pose).translation_fraction_of_range < 0.02


def test_nothing_is_found_where_nothing_is() -> None:
    model = load_model(find_target("satellite"))
    assert match_anywhere(np.empty((0, 4)), model, CAMERA, Anywhere()) == []


def test_range_and_view_narrow_what_is_looked_at() -> None:
    model = load_model(find_target("cube"))  # which looks the same from six sides
    pose = any_pose(1, 0.6, model.diameter, model.middle)
    distance = float(np.linalg.norm(pose.translation))
    view = tuple(-(pose.matrix.T @ pose.translation))
    segments = segments_of(model, pose)
    known = Anywhere((0.8 * distance, 1.3 * distance), view)
    found = match_anywhere(segments, model, CAMERA, known)
    assert found
    for one in found:
        seen_from = -(one.pose.matrix.T @ one.pose.translation)
        assert seen_from @ view / np.linalg.norm(seen_from) / distance > np.cos(np.radians(80.0))
    assert len(sizes_px(CAMERA, model.diameter, known)) < len(sizes_px(CAMERA, model.diameter, Anywhere()))


@pytest.mark.parametrize(
    "values", [{"range_m": (2.0, 1.0)}, {"range_m": (0.0, 1.0)}, {"view": (0.0, 0.0, 0.0)}]
)
def test_what_narrows_nothing_sensible_is_refused(values: dict[str, tuple[float, ...]]) -> None:
    with pytest.raises(GeometryError):
        Anywhere(**values)  # type: ignore[arg-type]


def test_votes_are_sums_of_gains_at_every_second_place_and_of_chance_outside() -> None:
    rng = np.random.default_rng(0)
    gain = rng.integers(0, 256, (8, 23, 31)).astype(np.uint8)
    points = np.array([5, 12, 12])
    offset = rng.integers(-7, 8, (3, 12, 2)).astype(np.int16)
    bins = rng.integers(0, 8, (3, 12)).astype(np.int16)
    score, place = vote(gain, *Templates(offset, bins, points, np.full(3, 4.0)))
    for t in range(3):
        sums = np.zeros((12, 16))
        for row, column in np.ndindex(sums.shape):
            for p in range(points[t]):
                y, x = 2 * row + offset[t, p, 0], 2 * column + offset[t, p, 1]
                inside = 0 <= y < 23 and 0 <= x < 31
                sums[row, column] += gain[bins[t, p], y, x] if inside else round(gain[bins[t, p]].mean())
        expected = sum(gain[b].mean() for b in bins[t, : points[t]])
        assert score[t] == pytest.approx(2.0 * (sums.max() - expected) / points[t] / 255.0)
        assert sums[tuple((place[t] // 2).astype(int))] == sums.max()


@pytest.mark.parametrize(
    ("range_m", "counts"), [(None, [4, 4, 4]), ((1.0, 1.0), [1]), ((1.0, 2.06), [5]), ((1.0, 3.5), [4, 4])]
)
def test_no_grid_is_for_one_size_beside_others(
    range_m: tuple[float, float] | None, counts: list[int]
) -> None:
    sizes = sizes_px(CAMERA, 0.2, Anywhere(range_m))
    assert [len(part) for part in sizes] == counts
    whole = np.concatenate(sizes)
    least, most = (1.0, 1.3 / 0.18) if range_m is None else range_m
    assert whole[0] / whole[-1] == pytest.approx(most / least)
    np.testing.assert_allclose(np.diff(np.log(whole), 2), 0.0, atol=1e-9)


def test_no_size_is_tried_at_which_nothing_can_be_told() -> None:
    sizes = np.concatenate(sizes_px(CAMERA, 0.2, Anywhere((1e-3, 1e3))))
    side = min(CAMERA.width, CAMERA.height)
    assert sizes[0] == pytest.approx(SEEN_SIZE_SHARES[1] * side)
    assert sizes[-1] == pytest.approx(SEEN_SIZE_SHARES[0] * side)


def test_templates_turn_and_foreshorten_as_the_camera_sees() -> None:
    camera = Camera(640, 480, 800.0, 800.0, 319.5, 239.5)
    points, along = np.array([[0.1, 0.0, 0.05]] * 9), np.array([[0.0, 1.0, 0.0]] * 9)
    made = templates([Look(points, along, 9.0)], camera, 1.0, 2.0)
    column = 800.0 * 0.1 / 1.05 / 2.0
    assert made.offset[0, 0].tolist() == [0, round(column)]
    assert made.bin[0, 0] == 4  # across: 90 degrees
    quarter = len(made.points) // 4  # of the rolls is no whole number: nearest one
    angle = 2.0 * np.pi * quarter / len(made.points)
    assert made.offset[quarter, 0].tolist() == [round(column * np.sin(angle)), round(column * np.cos(angle))]
