"""A model of very many facets is searched for in fewer ones, none far from its place."""

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
    assert left.min() > own.min() - SEARCHED_OFF * ball.diameter


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
