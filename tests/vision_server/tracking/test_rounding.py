"""Rounded edges of a told radius are looked for where they are seen."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.printed_boxes import Box, sharp
from geometry.model import Model
from geometry.pose import Pose
from geometry.rotation import matrix_of
from geometry.visibility import visible_samples
from numerics.arrays import Grey
from tests.vision_server.synthetic import CAMERA
from tests.vision_server.tracking.boxes import TURNS, framed_box, pictured, seen_at
from vision_server.pose.line_scales import with_line_scales
from vision_server.pose.observation import observe
from vision_server.pose.roundings import onto_roundings, slack_px
from vision_server.tracking.frame import Tone, Window, problem_of
from vision_server.tracking.lines import rounding_shifts
from vision_server.tracking.tracker import Tracker
from vision_server.trust.support import PoseSupport, support_at

RADIUS_M, TONE, SPACING_PX = 0.0025, Tone.of(0.9, 0.01), 2.0


def box(radius_m: float) -> Box:
    """Printed to where the roundings begin."""
    return framed_box(8)._replace(radius=radius_m)


def rounded(model: Model) -> Model:
    return replace(model, edge_radius_m=RADIUS_M)


def support(model: Model, pixels: Grey, pose: Pose) -> PoseSupport:
    problem = with_line_scales(problem_of(Window(pixels, CAMERA), model, TONE), pose)
    found = support_at(problem, pose, SPACING_PX)
    assert found is not None
    return found


def film(radius_m: float, frames: int) -> Iterator[tuple[Grey, Pose]]:
    """Of a box that turns slowly, with its true poses."""
    start = seen_at(TURNS[0])
    for k in range(frames):
        turn = matrix_of(np.array([0.004, 0.01, 0.0]) * k) @ start.matrix
        pose = Pose.from_matrix(turn, start.translation + k * np.array([0.0004, 0.0, 0.0002]))
        yield pictured(box(radius_m), pose, seed=k), pose


@pytest.mark.parametrize("turn", TURNS)
def test_outlines_of_a_rounded_model_are_where_its_roundings_are_seen(turn: list[float]) -> None:
    model, pose = sharp(box(RADIUS_M)), seen_at(turn)
    at_edges = visible_samples(model, CAMERA, pose, SPACING_PX)
    inside = visible_samples(rounded(model), CAMERA, pose, SPACING_PX)
    problem = problem_of(Window(pictured(box(RADIUS_M), pose), CAMERA), model, TONE)
    shift, _ = rounding_shifts(problem, pose, observe(problem, pose, 3.0, SPACING_PX))
    moved = ((inside.image - at_edges.image) * at_edges.normal).sum(axis=1)
    assert np.abs(moved).max() > 1.0
    np.testing.assert_allclose(moved, RADIUS_M * shift, atol=0.1)
    np.testing.assert_array_equal(inside.points, at_edges.points)


def test_the_true_pose_of_a_rounded_box_is_supported() -> None:
    """Along the lines of the sharp model little is seen."""
    shares = []
    for turn in TURNS:
        pose = seen_at(turn)
        pixels, model = pictured(box(RADIUS_M), pose), sharp(box(RADIUS_M))
        shares.append([support(one, pixels, pose).evidence for one in (model, rounded(model))])
    without, told = np.sum(shares, axis=0)
    assert told > 1.5 * without


def test_what_is_beside_an_end_of_a_rounded_crease_is_taken_for_that_end() -> None:
    pose = seen_at(TURNS[0])
    model = rounded(sharp(box(RADIUS_M)))
    samples = visible_samples(model, CAMERA, pose, SPACING_PX)
    slack = slack_px(model, CAMERA, pose, samples)
    creased = slack > 0.0
    assert creased.any() and not creased.all()
    for side in (-1.0, 1.0):
        offset = np.where(creased, 0.8 * side * slack, 0.3)[None].copy()
        unsure = onto_roundings(samples.line, offset, slack, 0.5)
        np.testing.assert_allclose(offset[0, ~creased], 0.3)
        assert np.abs(offset[0, creased]).max() < 0.2 * slack.max()
        assert not unsure[~creased].any()
        assert np.all(unsure[creased] < 0.5 * slack[creased])


def test_of_a_told_radius_a_box_is_followed_surely() -> None:
    told = []
    shown = list(film(RADIUS_M, 12))
    tracker = Tracker(sharp(box(RADIUS_M)), CAMERA, shown[0][1], 0.9, edge_radius_m=RADIUS_M)
    for pixels, pose in shown:
        one = tracker.step(pixels)
        right = one.pose is not None and one.pose.error_to(pose).within(1.0, 0.01)
        told.append(right and one.state == "sure")
    assert sum(told) >= 9
