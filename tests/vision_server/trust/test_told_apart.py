"""What tells two poses apart, and what lies at one place in both."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.drawn_parts import part_file
from benchmarks.synthetic_parts import rendered
from geometry.camera import Camera
from geometry.model import Model, load_model
from geometry.near_symmetries import near_symmetries
from geometry.pose import Pose
from geometry.rotation import matrix_of
from geometry.visibility import Samples
from tests.vision_server.synthetic import one_image
from vision_server.pose.observation import PoseProblem
from vision_server.trust.support import PoseSupport, support_at
from vision_server.trust.told_apart import evidence_apart

CAMERA = Camera(640, 480, 768.0, 768.0, 319.5, 239.5)
SPACING_PX = 3.0
FROM_THE_FRONT, FROM_BEHIND = np.pi - 0.5, -0.5  # about the camera's x axis; the block is in front


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Model:
    folder: Path = tmp_path_factory.mktemp("wheel")
    return load_model(part_file("wheel", folder, np.random.default_rng((4102, 4))))


def seen_turned(wheel: Model, tilt_rad: float, places: int = 1) -> tuple[PoseSupport, PoseSupport, Pose]:
    """The support of a wheel's true pose, and of that turned by so many of its sides; and the true pose."""
    rotation = matrix_of(np.array([tilt_rad, 0.0, 0.0])) @ matrix_of(np.array([0.0, 0.0, 0.3]))
    place = np.array([0.02, -0.01, CAMERA.fx * wheel.diameter / 300.0])
    true = Pose.from_matrix(rotation, place - rotation @ wheel.middle)
    images = one_image(rendered(wheel, CAMERA, true, np.random.default_rng(1)))
    problem = PoseProblem.at_scale(images.gradients(["i1"]), wheel, CAMERA)
    about = sorted(
        (turn for turn in near_symmetries(wheel) if turn.matrix[2, 2] > 0.99),
        key=lambda turn: float(np.linalg.norm(turn.rotation_vector)),
    )
    right = support_at(problem, true, SPACING_PX)
    turned = support_at(problem, true.compose(about[places - 1]), SPACING_PX)
    assert right is not None
    assert turned is not None
    return right, turned, true


@pytest.mark.parametrize("places", [1, 3])
def test_nothing_tells_a_turn_where_the_mark_is_behind(wheel: Model, places: int) -> None:
    right, turned, _ = seen_turned(wheel, FROM_BEHIND, places)
    assert evidence_apart(turned, right) == 0.0
    assert evidence_apart(turned, right, together=True) == 0.0
    assert right.evidence != turned.evidence  # their samples fall otherwise


def test_the_lines_of_a_mark_tell_a_turn(wheel: Model) -> None:
    right, turned, _ = seen_turned(wheel, FROM_THE_FRONT)
    apart = evidence_apart(right, turned)
    assert apart > 20.0
    assert evidence_apart(turned, right) == -apart
    assert apart == pytest.approx(right.evidence - turned.evidence, abs=15.0)


def test_a_pose_beside_another_has_all_its_lines_to_itself(wheel: Model) -> None:
    right, _, true = seen_turned(wheel, FROM_THE_FRONT)
    images = one_image(rendered(wheel, CAMERA, true, np.random.default_rng(1)))
    problem = PoseProblem.at_scale(images.gradients(["i1"]), wheel, CAMERA)
    aside = Pose(true.rotation_vector, true.translation + np.array([0.03, 0.02, 0.0]))
    beside = support_at(problem, aside, SPACING_PX)
    assert beside is not None
    assert evidence_apart(beside, right) == pytest.approx(beside.evidence - right.evidence)


def test_a_line_of_which_the_other_pose_shows_less_counts_for_both(wheel: Model) -> None:
    whole, _, _ = seen_turned(wheel, FROM_BEHIND)
    line = int(whole.samples.line[0])
    of_it = np.flatnonzero(whole.samples.line == line)
    kept = np.delete(np.arange(len(whole.samples.line)), of_it[: len(of_it) // 2])
    cut = replace(
        whole,
        samples=Samples(*(values[kept] for values in whole.samples)),
        distance=whole.distance[kept],
        supports=whole.supports[:, kept],
        slack=whole.slack[kept],
    )
    assert cut.evidence != whole.evidence
    assert evidence_apart(whole, cut) == pytest.approx(whole.evidence - cut.evidence)
