"""A model of very many facets is searched for in fewer ones, none far from its place."""

import manifold3d
import numpy as np
import pytest
import trimesh

from geometry.coarser import MANY_FACETS, SEARCHED_OFF, coarser
from geometry.mesh import surface_of_triangles
from geometry.model import Model

RADIUS_M = 0.05


def of_mesh(mesh: trimesh.Trimesh) -> Model:
    return Model.of_surface("part", surface_of_triangles(np.array(mesh.vertices), np.array(mesh.faces)))


def test_a_fine_ball_has_fewer_facets_no_edges_and_nearly_its_surface() -> None:
    ball = of_mesh(trimesh.creation.icosphere(5, RADIUS_M))
    few = coarser(ball)
    assert len(few.triangles) < 0.4 * len(ball.triangles)
    assert few.smooth.all()
    assert (few.line_faces >= 0).all()
    assert not few.two_sided.any()
    places = {tuple(one) for one in ball.vertices.tolist()}
    assert all(tuple(one) in places for one in few.vertices.tolist())
    own, left = (np.linalg.norm(one.vertices[one.triangles].mean(axis=1), axis=1) for one in (ball, few))
    assert left.min() > own.min() - SEARCHED_OFF[0] * ball.diameter


def test_the_rims_of_a_fine_cylinder_stay_sharp() -> None:
    fine = of_mesh(trimesh.creation.cylinder(RADIUS_M, 0.1, sections=4096))
    few = coarser(fine)
    assert len(few.triangles) < 1000
    ends = few.vertices[few.lines[~few.smooth]]
    np.testing.assert_allclose(abs(ends[..., 2]), 0.05)
    round_m = np.linalg.norm(np.diff(ends, axis=1)[:, 0], axis=1).sum()
    assert round_m == pytest.approx(2.0 * 2.0 * np.pi * RADIUS_M, rel=0.01)


def test_a_model_of_few_facets_or_with_a_hole_is_left_as_it_is() -> None:
    fine, small = trimesh.creation.icosphere(5, RADIUS_M), of_mesh(trimesh.creation.icosphere(3, RADIUS_M))
    fine.update_faces(np.arange(len(fine.faces)) > 0)
    open_one = of_mesh(fine)
    assert len(open_one.triangles) > MANY_FACETS > len(small.triangles)
    assert coarser(open_one) is open_one
    assert coarser(small) is small


def test_a_plate_with_many_pockets_stays_closed() -> None:
    """Four of its facets are lines, when it has fewer: it ended with "face has no area"."""
    plate = manifold3d.Manifold.cube((0.3, 0.2, 0.005))
    pocket = manifold3d.Manifold.cylinder(4e-4, 0.0015, 0.0015, 16)
    places = [(0.005 + 0.29 * i / 18, 0.005 + 0.19 * j / 12, 0.0046) for i in range(18) for j in range(12)]
    pockets = [pocket.translate(place) for place in places]
    solid = (plate - manifold3d.Manifold.batch_boolean(pockets, manifold3d.OpType.Add)).to_mesh64()
    fine = of_mesh(trimesh.Trimesh(solid.vert_properties[:, :3], solid.tri_verts, process=False))
    few = coarser(fine)
    assert MANY_FACETS < len(fine.triangles) > 2 * len(few.triangles)
    assert (few.line_faces >= 0).all()
    assert not few.two_sided.any()


def test_a_thin_sheet_is_not_lost() -> None:
    """Of a bed that is a tenth of a millimetre thick nothing was left, and it could not be looked for."""
    sheet = of_mesh(trimesh.creation.cylinder(0.2, 1e-4, sections=3000))
    few = coarser(sheet)
    assert MANY_FACETS < len(sheet.triangles) > 2 * len(few.triangles) > 0
    outline = few.lines[~few.smooth]
    assert np.hypot(*few.vertices[outline].mean(axis=1)[:, :2].T).min() > 0.199
