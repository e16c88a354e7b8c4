"""Lines of the overlay lie where the projection says, and only those that can be seen."""

from dataclasses import replace

import numpy as np
import pytest

from bridge.errors import BadInput
from geometry.camera import Camera
from geometry.pose import Pose
from geometry.visibility import visible_samples
from geometry.wireframe import visible_runs
from report.overlay import draw_overlay
from tests.report.run_folders import GREY, Bench, blue, distance_to, orange


def hidden_corner(bench: Bench) -> int:
    """The corner farthest from the camera: the three lines that meet there are hidden."""
    return int(np.argmax(np.linalg.norm(bench.pose.apply(bench.model.vertices), axis=1)))


def ends(bench: Bench, camera: Camera) -> np.ndarray:
    """Image ends (L, 2, 2) of all the cube's lines."""
    return camera.project(bench.pose.apply(bench.model.vertices))[bench.model.lines]


def test_every_visible_line_is_drawn_within_a_pixel(bench: Bench) -> None:
    drawn = draw_overlay(bench.image(), bench.model, bench.camera, bench.pose)
    rows, columns = np.nonzero(blue(drawn))
    pixels = np.stack([columns, rows], axis=1).astype(float)
    away = hidden_corner(bench)
    shown = [
        line
        for line, pair in zip(ends(bench, bench.camera), bench.model.lines, strict=True)
        if away not in pair
    ]
    assert len(shown) == 9
    for start, end in shown:
        along = start + np.linspace(0, 1, 60)[:, None] * (end - start)
        nearest = np.linalg.norm(along[:, None] - pixels[None], axis=2).min(axis=1)
        assert nearest.max() <= 1.0
    distances = np.min([distance_to(pixels, start, end) for start, end in shown], axis=0)
    assert distances.max() <= 1.5  # a blue pixel is at most the width of an anti-aliased line away


def test_hidden_lines_are_not_drawn(bench: Bench) -> None:
    drawn = draw_overlay(bench.image(), bench.model, bench.camera, bench.pose)
    away = hidden_corner(bench)
    for line, pair in zip(ends(bench, bench.camera), bench.model.lines, strict=True):
        if away in pair:
            middle = line.mean(axis=0).round().astype(int)
            patch = drawn[middle[1] - 1 : middle[1] + 2, middle[0] - 1 : middle[0] + 2]
            assert (patch == GREY).all()


def test_lines_follow_the_lens(bench: Bench) -> None:
    bent = replace(bench.camera, distortion=(-0.3, 0.1, 0.0, 0.0, 0.0))
    near = Pose(bench.pose.rotation_vector, np.array([0.03, 0.02, 0.28]))
    drawn = draw_overlay(bench.image(), bench.model, bent, near)
    rows, columns = np.nonzero(blue(drawn))
    pixels = np.stack([columns, rows], axis=1).astype(float)
    assert max(len(run.points) for run in visible_runs(bench.model, bent, near)) > 2
    places = visible_samples(bench.model, bent, near, 4.0).image
    assert np.linalg.norm(places[:, None] - pixels[None], axis=2).min(axis=1).max() <= 1.0


def test_unsupported_lines_are_orange(bench: Bench) -> None:
    lines = sorted({run.line for run in visible_runs(bench.model, bench.camera, bench.pose)})
    support = dict.fromkeys(lines[1:], 1.0)
    drawn = draw_overlay(bench.image(), bench.model, bench.camera, bench.pose, support)
    rows, columns = np.nonzero(orange(drawn))
    start, end = ends(bench, bench.camera)[lines[0]]
    assert len(rows) > 10
    assert distance_to(np.stack([columns, rows], axis=1).astype(float), start, end).max() <= 1.5
    everything = draw_overlay(bench.image(), bench.model, bench.camera, bench.pose, {})
    assert not blue(everything).any()


def test_lines_are_wider_in_a_large_image(bench: Bench) -> None:
    scaled = bench.camera.scaled(12.0)
    grey = np.full((scaled.height, scaled.width), GREY, dtype=np.uint8)
    small, large = (
        blue(draw_overlay(image, bench.model, camera, bench.pose)).sum()
        for image, camera in ((bench.image(), bench.camera), (grey, scaled))
    )
    assert large > 1.5 * 12 * small  # twelve times as long


def test_a_small_target_gets_an_inset(bench: Bench) -> None:
    far = Pose(bench.pose.rotation_vector, np.array([-0.3, -0.2, 1.2]))
    with_inset = draw_overlay(bench.image(), bench.model, bench.camera, far)
    without = draw_overlay(bench.image(), bench.model, bench.camera, far, inset=False)
    lower_right = (slice(130, None), slice(180, None))
    assert blue(with_inset)[lower_right].sum() > 100
    assert not blue(without)[lower_right].any()


def test_it_leaves_the_image_alone(bench: Bench) -> None:
    image = bench.image()
    drawn = draw_overlay(image, bench.model, bench.camera, bench.pose)
    assert drawn.shape == (240, 320, 3)
    assert drawn.dtype == np.uint8
    assert (image == GREY).all()


def test_without_a_pose_the_image_stays(bench: Bench) -> None:
    assert (draw_overlay(bench.image(), bench.model, bench.camera, None) == GREY).all()


def test_a_target_out_of_view_draws_nothing(bench: Bench) -> None:
    aside = Pose(bench.pose.rotation_vector, np.array([5.0, 0.0, 1.0]))
    assert (draw_overlay(bench.image(), bench.model, bench.camera, aside) == GREY).all()


@pytest.mark.parametrize(
    ("image", "words"),
    [
        (np.zeros((240, 320), np.float64), "uint8"),
        (np.zeros((240, 320, 4), np.uint8), "shape"),
        (np.zeros((120, 320), np.uint8), "320×120"),
    ],
)
def test_wrong_images_are_named(bench: Bench, image: np.ndarray, words: str) -> None:
    with pytest.raises(BadInput, match=words):
        draw_overlay(image, bench.model, bench.camera, bench.pose)
