"""Hypotheses of the matcher, refined: what lies beside them, and turned onto near symmetries."""

import math
from pathlib import Path

import numpy as np
import pytest

from benchmarks.drawn_parts import part_file
from benchmarks.synthetic_parts import rendered
from geometry.camera import Camera
from geometry.model import load_model
from geometry.near_symmetries import near_symmetries
from geometry.pose import RIGHT, Pose
from geometry.rotation import matrix_of
from tests.vision_server.synthetic import one_image
from vision_server.matching.draws import in_range_of
from vision_server.matching.match import SearchRange
from vision_server.pose.observation import PoseProblem
from vision_server.trust.ranking import best_first, nowhere
from vision_server.trust.rivals import turned

CAMERA = Camera(640, 480, 768.0, 768.0, 319.5, 239.5)


@pytest.mark.parametrize("number", [0, 4])
def test_a_wheel_that_is_turned_by_a_tooth_is_told_by_its_block(tmp_path: Path, number: int) -> None:
    """The search range holds both poses, the matcher gave the wrong one."""
    model = load_model(part_file("wheel", tmp_path, np.random.default_rng((4102, number))))
    rotation = matrix_of(np.array([math.pi - 0.5, 0.0, 0.0])) @ matrix_of(np.array([0.0, 0.0, 0.3]))
    place = np.array([0.02, -0.01, CAMERA.fx * model.diameter / 300.0])
    true = Pose.from_matrix(rotation, place - rotation @ model.middle)
    images = one_image(rendered(model, CAMERA, true, np.random.default_rng(1)))
    problem = PoseProblem.at_scale(images.gradients(["i1"]), model, CAMERA)
    about = [turn for turn in near_symmetries(model) if turn.matrix[2, 2] > 0.99]
    one_tooth = min(about, key=lambda turn: float(np.linalg.norm(turn.rotation_vector)))
    wrong = true.compose(one_tooth)

    left = best_first(problem, [wrong], searched=nowhere)[0]
    assert left.pose.error_to(wrong).within(*RIGHT)
    assert any(pose.error_to(true).within(*RIGHT) for pose, _ in turned(left))

    searched = in_range_of(true, CAMERA, SearchRange(90.0, 40.0))
    assert best_first(problem, [wrong], searched=searched)[0].pose.error_to(true).within(*RIGHT)
