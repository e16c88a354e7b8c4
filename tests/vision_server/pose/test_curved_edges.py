"""Blur draws the edge of a curved line towards its inner side, by as much as is taken back."""

from collections.abc import Iterator

import numpy as np
import pytest

from benchmarks.machined_parts import ROUND, surface_of
from benchmarks.synthetic_parts import random_view, rendered
from geometry.camera import Camera
from geometry.model import Model
from geometry.visibility import Samples
from tests.vision_server.synthetic import one_image
from vision_server.pose.courses import courses_of
from vision_server.pose.curved_edges import BLUR_OVER_SOFTNESS, bend, drawn_in
from vision_server.pose.observation import Observation, PoseProblem, observe

CAMERA = Camera(640, 480, 768.0, 768.0, 319.5, 239.5)
STEP_PX = 2.0


def arc(radius_px: float, turn: float, count: int = 20) -> Samples:
    """An arc about (100, 80), clockwise in the image or, with ``turn`` -1, the other way."""
    angle = turn * STEP_PX / radius_px * np.arange(count)
    image = np.stack([100.0 + radius_px * np.cos(angle), 80.0 + radius_px * np.sin(angle)], axis=1)
    way = turn * np.stack([-np.sin(angle), np.cos(angle)], axis=1)
    empty, line = np.zeros((count, 3)), np.zeros(count, dtype=np.int64)
    return Samples(empty, empty, line, image, way, np.full(count, STEP_PX), line)


@pytest.mark.parametrize("turn", [1.0, -1.0])
@pytest.mark.parametrize("radius_px", [6.0, 90.0])
def test_an_arc_bends_towards_its_centre(radius_px: float, turn: float) -> None:
    samples = arc(radius_px, turn)
    centre = samples.image + samples.normal / bend(samples)[:, None]
    np.testing.assert_allclose(centre, np.tile([100.0, 80.0], (20, 1)), atol=1e-6)
    (back,) = drawn_in(samples, np.zeros(20), np.array([[2.0]]), np.array([[1.0]]))
    assert np.abs(back) == pytest.approx(0.5 * (1.0 + (2.0 * BLUR_OVER_SOFTNESS) ** 2) / radius_px)


def test_straight_and_very_short_lines_do_not_bend() -> None:
    samples = arc(90.0, 1.0)
    straight = samples._replace(image=samples.image * [0.0, 1.0])
    assert (bend(straight) == 0.0).all()
    assert (bend(arc(90.0, 1.0, count=2)) == 0.0).all()


def views_of_a_flange() -> Iterator[tuple[PoseProblem, Observation]]:
    """Problems, and what is seen in each at the true pose."""
    model = Model.of_surface("flange", surface_of(ROUND["flange"](128)))
    for number in range(4):
        rng = np.random.default_rng((9, number))
        true = random_view(rng, model, CAMERA)
        images = one_image(rendered(model, CAMERA, true, rng))
        problem = PoseProblem.at_scale(images.gradients(["i1"]), model, CAMERA)
        yield problem, observe(problem, true, 3.0, STEP_PX)


def test_rims_and_holes_are_seen_where_they_are() -> None:
    """How far inwards edges are seen, px, by how much their lines bend, 1/px: half of the squared blur."""
    rows = []
    for problem, seen in views_of_a_flange():
        bends, offset, moved_back = bend(seen.samples), seen.offset[0], seen.drawn[0]
        sharp = ~problem.model.smooth[seen.samples.line] & (np.abs(bends) > 0.002) & (np.abs(offset) < 0.3)
        weight = bends / (seen.sd[0] ** 2 + 0.02**2)
        rows.append(np.stack([offset + moved_back, offset, bends], axis=1)[sharp].T @ weight[sharp])
    inwards, left, whole = np.sum(rows, axis=0)
    assert 0.5 < inwards / whole < 1.0
    assert abs(left) < 0.3 * inwards


def test_a_rim_as_a_whole_is_where_it_is_too() -> None:
    """Its profile is read about where its edge is seen; else it tells of what blur has drawn in once more."""
    rows = []
    for problem, seen in views_of_a_flange():
        courses = courses_of(problem, seen, np.zeros((len(seen.along), 3)))
        line, place = seen.samples.line, courses.place[:, 0]
        drawn = (np.bincount(line, seen.drawn[0]) / np.maximum(np.bincount(line), 1))[courses.line]
        bent = ~problem.model.smooth[courses.line] & (np.abs(drawn) > 0.002) & (np.abs(place) < 0.3)
        weight = drawn * courses.share / (courses.noise[:, 0, 0] + courses.spread**2)
        rows.append(np.stack([place, drawn], axis=1)[bent].T @ weight[bent])
    left, whole = np.sum(rows, axis=0)
    assert abs(left) < 0.5 * whole


@pytest.mark.parametrize(("blurs", "share"), [(0.2, 1.0), (1.0, 0.92), (2.0, 0.67), (3.0, 0.35), (6.0, 0.0)])
def test_the_middle_of_a_long_facet_is_not_drawn_in(blurs: float, share: float) -> None:
    """Of facets as many blurs long, by what blurring a polygon of them does to the middle of each."""
    samples, one, softness = arc(90.0, 1.0), np.array([[1.0]]), np.array([[0.0]])
    curve, polygon = (drawn_in(samples, np.full(20, facet), softness, one) for facet in (0.0, blurs))
    np.testing.assert_allclose(polygon / curve, share, atol=0.06)
