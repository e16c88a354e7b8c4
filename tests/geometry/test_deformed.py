"""What a stretched, sheared or mirrored model shares with what it was is what it would have of its own."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from geometry.camera import Camera
from geometry.coarser import coarser
from geometry.deformed import change_of, deformed
from geometry.mesh import surface_of_triangles
from geometry.model import Model, find_target, load_model
from geometry.pose import Pose
from geometry.surface import face_normals
from geometry.visibility import solid_of, visible_samples
from numerics.arrays import Floats

CAMERA = Camera(640, 480, 800.0, 800.0, 319.5, 239.5)
POSE = Pose(np.array([0.4, -0.5, 0.3]), np.array([0.02, 0.01, 1.0]))
LONGER = np.diag([1.03, 1.0, 0.98])
LEANING = np.array([[1.0, 0.02, 0.0], [0.02, 1.0, 0.0], [0.0, 0.0, 1.0]])
MIRRORED = np.diag([1.0, -1.0, 1.0])


@pytest.fixture(scope="module")
def fine() -> Model:
    ball = trimesh.creation.icosphere(5, 0.1)
    return Model.of_surface("ball", surface_of_triangles(np.array(ball.vertices), np.array(ball.faces)))


@pytest.mark.parametrize("matrix", [LONGER, LEANING, MIRRORED])
def test_a_deformed_model_is_seen_as_one_that_was_read_so(matrix: Floats) -> None:
    model = load_model(find_target("fixture"))
    out = deformed(model, matrix)
    np.testing.assert_allclose(out.face_normals, face_normals(out.vertices, out.faces), atol=1e-12)
    own = replace(out)
    assert change_of(out) is not None
    assert change_of(own) is None
    seen, seen_own = (visible_samples(one, CAMERA, POSE, 3.0) for one in (out, own))
    assert len(seen.line) > 100
    for field, one, other in zip(seen._fields, seen, seen_own, strict=True):
        np.testing.assert_array_equal(one, other, err_msg=field)


def test_what_is_made_of_a_deformed_model_shares_nothing_any_more() -> None:
    longer = deformed(load_model(find_target("fixture")), LONGER)
    fewer = replace(
        longer, lines=longer.lines[::2], line_faces=longer.line_faces[::2], smooth=longer.smooth[::2]
    )
    assert len(solid_of(fewer).chain) == len(fewer.lines)


@pytest.mark.parametrize("matrix", [LONGER, LEANING, MIRRORED])
def test_a_fine_deformed_model_has_the_fewer_facets_of_what_it_was(fine: Model, matrix: Floats) -> None:
    out, few = coarser(deformed(fine, matrix)), coarser(fine)
    assert len(out.triangles) == len(few.triangles) < 0.4 * len(fine.triangles)
    expected = fine.middle + (few.vertices - fine.middle) @ matrix.T
    np.testing.assert_allclose(out.vertices, expected, atol=1e-12)
    np.testing.assert_array_equal(out.lines, few.lines)
    corners = out.vertices[out.triangles]
    assert np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() > 0.0


def test_a_coarse_model_is_left_as_it_is_when_it_is_deformed() -> None:
    longer = deformed(load_model(find_target("fixture")), LONGER)
    assert coarser(longer) is longer
