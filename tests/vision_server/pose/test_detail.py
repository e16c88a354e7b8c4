"""Poses of a model of very many lines are found by the longest of them; what is told is of all."""

from typing import Any

import numpy as np
import pytest

from benchmarks.synthetic_parts import estimated, random_part, random_view, rendered
from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import disturbed
from vision_server.pose.observation import Observation, PoseProblem, observe
from vision_server.trust.ranking import MOST_COMPARED_CURVES, fewer_lines

CAMERA = Camera(640, 480, 768.0, 768.0, 319.5, 239.5)


def part(lines: int) -> Model:
    return Model.of_surface("part", random_part(np.random.default_rng(5), lines))


def test_the_longest_lines_are_kept_with_their_softness() -> None:
    model = part(1200)
    scale = np.arange(len(model.lines))[None]
    problem = PoseProblem([], model, CAMERA, scale)
    sparse = fewer_lines(problem)
    assert MOST_COMPARED_CURVES <= len(sparse.model.lines) < 0.7 * len(model.lines)
    kept = sparse.scale[0]
    np.testing.assert_array_equal(sparse.model.lines, model.lines[kept])
    np.testing.assert_array_equal(sparse.model.line_faces, model.line_faces[kept])
    length = np.linalg.norm(np.diff(model.vertices[model.lines], axis=1)[:, 0], axis=1)
    left_out = np.setdiff1d(np.arange(len(length)), kept)
    assert np.median(length[left_out]) < 0.7 * np.median(length[kept])
    assert sparse.model.triangles is model.triangles
    few = PoseProblem([], part(100), CAMERA, np.zeros((0, 100), dtype=np.int64))
    assert fewer_lines(few) is few


@pytest.mark.slow
def test_one_look_takes_in_all_lines(monkeypatch: pytest.MonkeyPatch) -> None:
    model, rng = part(1200), np.random.default_rng(1)
    true = random_view(rng, model, CAMERA)
    pixels = rendered(model, CAMERA, true, rng)
    looks: list[int] = []

    def noted(problem: PoseProblem, *others: Any, **named: Any) -> Observation:
        looks.append(len(problem.model.lines))
        return observe(problem, *others, **named)

    for module in ("trust.support", "pose.refinement"):
        monkeypatch.setattr(f"vision_server.{module}.observe", noted)
    found = estimated(pixels, model, CAMERA, disturbed(true, rng, 25.0, 40.0, CAMERA.fx))
    assert found.pose is not None
    assert found.pose.error_to(true).within(0.2, 0.002)
    assert max(line.line for line in found.lines) > MOST_COMPARED_CURVES
    assert looks.count(len(model.lines)) == 1  # what is told of them
    assert len(looks) > 10
