"""A tree of boxes holds every triangle once, and hides of a line what all triangles, one by one, hide."""

import numpy as np
import pytest

from geometry.occluders import Hiders, hidden_parts, hidden_point
from geometry.triangle_tree import MOST_IN_LEAF, TriangleTree, tree_of
from numerics.arrays import Floats
from tests.geometry.triangles import soup


def in_one_box(tree: TriangleTree) -> TriangleTree:
    """The same triangles, all looked at."""
    box = np.array([[0.0, 0.0, 0.0, 1e3, 1e3, 1e3]])
    one, count = np.array([1]), np.array([len(tree.triangle)])
    return tree._replace(boxes=box, after=one, first=0 * one, last=count)


def hidden(tree: TriangleTree, centre: Floats, start: Floats, end: Floats, touch: float) -> Floats:
    """The intervals (N, 2) of a line that are hidden, in order."""
    before = tree.plane[:, :3] @ centre - tree.plane[:, 3]
    out = np.empty((len(before), 2))
    count = hidden_parts(Hiders(tree, before, centre, touch), start, end, out)
    return out[:count][np.lexsort(out[:count].T)]


@pytest.mark.parametrize("seed", range(3))
def test_each_triangle_is_in_one_leaf_and_in_all_boxes_around_that(seed: int) -> None:
    vertices, triangles = soup(seed)
    tree = tree_of(vertices, triangles, 2.0)
    assert sorted(tree.triangle) == list(range(len(triangles)))
    held = [n for box in range(len(tree.after)) for n in range(tree.first[box], tree.last[box])]
    assert held == list(range(len(triangles)))
    assert (tree.last - tree.first).max() <= MOST_IN_LEAF
    for box, after in enumerate(tree.after):
        inside = [
            n for other in range(box, after) for n in range(tree.first[other], tree.last[other])
        ]  # those in a box and in the boxes in it
        assert inside
        aside = abs(tree.corners[inside] - tree.boxes[box, :3]) - tree.boxes[box, 3:]
        assert aside.max() <= 0.0


@pytest.mark.parametrize("seed", range(3))
def test_what_the_tree_hides_of_lines_is_what_all_triangles_hide(seed: int) -> None:
    random = np.random.default_rng(seed)
    tree = tree_of(*soup(seed), 2.0)
    found = 0
    for _ in range(200):
        centre = random.normal(size=3)
        centre *= random.uniform(0.3, 5.0) / np.linalg.norm(centre)
        start = random.uniform(-1.0, 1.0, 3)
        end = start + 10.0 ** random.uniform(-3.0, 0.0) * random.normal(size=3)
        ours = hidden(tree, centre, start, end, 1e-4)
        np.testing.assert_array_equal(ours, hidden(in_one_box(tree), centre, start, end, 1e-4))
        found += len(ours)
    assert found > 200


@pytest.mark.parametrize("seed", range(3))
def test_a_point_is_hidden_where_the_part_of_its_line_is(seed: int) -> None:
    random = np.random.default_rng(seed)
    tree, told = tree_of(*soup(seed), 2.0), []
    for number in range(300):
        centre = random.normal(size=3)
        centre *= random.uniform(0.3, 5.0) / np.linalg.norm(centre)
        start = random.uniform(-1.0, 1.0, 3)
        end = start + 10.0 ** random.uniform(-3.0, 0.0) * random.normal(size=3)
        if number % 10 == 0:
            end[0] = start[0] = centre[0]  # the line of sight lies in two planes of the boxes' sides
        parts, at = hidden(tree, centre, start, end, 1e-4), random.uniform()
        before = tree.plane[:, :3] @ centre - tree.plane[:, 3]
        point = hidden_point(Hiders(tree, before, centre, 1e-4), start + at * (end - start))
        assert point == bool(((parts[:, 0] <= at) & (at <= parts[:, 1])).any())
        told.append(point)
    assert 30 < sum(told) < 270


def test_a_line_on_a_triangle_is_not_hidden_and_one_behind_it_is() -> None:
    vertices = np.array([[-1.0, -1.0, 1.0], [1.0, -1.0, 1.0], [0.0, 1.0, 1.0]])
    tree = tree_of(vertices, np.array([[0, 1, 2]]), 2.0)
    camera = np.zeros(3)
    on = np.array([[-2.0, 0.0, 1.0], [2.0, 0.0, 1.0]])
    assert len(hidden(tree, camera, *on, 1e-4)) == 0
    np.testing.assert_allclose(hidden(tree, camera, *(2.0 * on), 1e-4), [[0.375, 0.625]])
    slanted = np.array([[0.1, 0.0, 0.5], [0.1, 0.0, 1.5]])
    np.testing.assert_allclose(hidden(tree, camera, *slanted, 0.0), [[0.5, 1.0]])


@pytest.mark.parametrize("count", [1, 5, 1000])
def test_triangles_that_are_all_alike_are_sorted_too(count: int) -> None:
    vertices = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]])
    tree = tree_of(vertices, np.tile([[0, 1, 2]], (count, 1)), 1.0)
    behind = np.array([[0.4, 0.4, 2.0], [0.5, 0.4, 2.0]])
    assert len(hidden(tree, np.zeros(3), *behind, 1e-4)) == count
