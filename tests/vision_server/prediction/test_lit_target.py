"""A target as its lights show it: what stands before a light shades what is behind it."""

from pathlib import Path

import numpy as np
import pytest

from geometry.model import Model
from geometry.pose import Pose
from numerics.arrays import Field
from tests.vision_server.synthetic import CAMERA, boxes
from vision_server.prediction.lit_target import LitTarget
from vision_server.prediction.new_edges import NEW, NEW_BESIDE_SHADOWS, new_edges
from vision_server.prediction.response import LitImage
from vision_server.prediction.small_pictures import SMALLER, faces_seen

FACING = Pose(np.array([np.pi, 0.0, 0.0]), np.array([0.0, 0.0, 0.5]))  # the target's z towards the camera
LEFT, RIGHT = np.array([-0.4, 0.0, 0.0]), np.array([0.4, 0.0, 0.0])


@pytest.fixture(scope="module")
def mast(tmp_path_factory: pytest.TempPathFactory) -> Model:
    """A plate of 20 x 16 cm with a mast of 6 cm on its middle."""
    plate = np.array([-0.10, -0.08, -0.01]), np.array([0.10, 0.08, 0.0])
    post = np.array([-0.008, -0.03, 0.0]), np.array([0.008, 0.03, 0.06])
    return boxes(tmp_path_factory.mktemp("mast"), [plate, post])


def pictures(model: Model, lights: list[tuple[float, float]]) -> list[Field]:
    return LitTarget(model, CAMERA, FACING, [LEFT, RIGHT]).under([np.array(row) for row in lights])


def at(picture: Field, x_m: float) -> float:
    """Brightness on the plate so far right of its middle in the picture."""
    column, row = CAMERA.project(FACING.apply(np.array([[x_m, 0.0, 0.0]])))[0]
    return float(picture[round(row / SMALLER), round(column / SMALLER)])


def test_a_mast_shades_the_plate_on_the_side_away_from_the_light(mast: Model) -> None:
    left, right, both, dark = pictures(mast, [(1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (0.0, 0.0)])
    assert at(left, 0.03) == at(right, -0.03) == 0.0
    assert at(left, -0.03) > 0.3
    assert at(left, 0.09) > 0.1  # beyond the shadow's end
    assert np.allclose(both, left + right)
    assert not dark.any()


def test_a_block_at_the_far_end_of_a_plate_is_seen_before_it(tmp_path: Path) -> None:
    plate = np.array([-0.10, -0.10, -0.01]), np.array([0.10, 0.10, 0.0])
    block = np.array([-0.03, 0.06, 0.0]), np.array([0.03, 0.10, 0.03])
    model = boxes(tmp_path, [plate, block])
    turned = Pose(np.array([2.2, 0.0, 0.0]), np.array([0.0, 0.0, 0.5]))
    face = faces_seen(model, CAMERA, turned)
    for point, normal in (
        ([0.0, 0.08, 0.03], [0, 0, 1]),
        ([0.0, 0.06, 0.015], [0, -1, 0]),
        ([0, 0, 0], [0, 0, 1]),
    ):
        column, row = CAMERA.project(turned.apply(np.array([point])))[0]
        front = face[round(row / SMALLER), round(column / SMALLER)]
        assert model.face_normals[front].tolist() == normal
        assert abs(normal @ (model.vertices[model.faces[front][0]] - point)) < 1e-9  # that one of them


def test_nothing_is_drawn_where_a_light_stands_nobody_knows(mast: Model) -> None:
    assert LitTarget(mast, CAMERA, FACING, [LEFT, None]).under([np.ones(2)]) == []
    assert LitTarget(mast, CAMERA, FACING).under([np.ones(0)]) == []


def photographed(model: Model, lights: tuple[float, float], arm: bool = False) -> LitImage:
    """A full-sized image under these lights and a weak sun, perhaps with a bar across the plate."""
    small = 0.6 * pictures(model, [lights])[0] + 0.1 * (faces_seen(model, CAMERA, FACING) >= 0)
    linear = np.kron(small, np.ones((SMALLER, SMALLER))).astype(np.float32)
    if arm:
        linear[:, 110:122] = 0.5
    return LitImage(linear, 1.0, np.array(lights), 0.7)


def test_the_edges_of_the_own_shadow_of_a_light_not_seen_before_are_not_new(mast: Model) -> None:
    before, after = photographed(mast, (0.0, 1.0)), photographed(mast, (1.0, 0.0))
    assert new_edges(LitTarget(mast, CAMERA, FACING), [before, after]) > NEW
    target = LitTarget(mast, CAMERA, FACING, [LEFT, RIGHT])
    assert new_edges(target, [before, after]) < 0.5 * NEW_BESIDE_SHADOWS
    behind = photographed(mast, (1.0, 0.0), arm=True)
    assert new_edges(target, [before, behind]) > 2.0 * NEW_BESIDE_SHADOWS
