"""Growing lines through edgels."""

from __future__ import annotations

import numpy as np

from tests.vision_server.edge_scenes import edge_map_of
from vision_server.segments.growing import MAX_GAP_PX, grow_lines


def test_a_row_of_edgels_is_one_group() -> None:
    edges = edge_map_of([(x, 30, np.pi / 2) for x in range(10, 60)])
    edgels = grow_lines(edges, edges.strength > 0, 8.0)
    assert edgels.groups.tolist() == [[0, 50]]
    assert sorted(edgels.points[:, 0]) == list(range(10, 60))


def test_it_goes_straight_on_over_junctions_gaps_and_wiggles() -> None:
    rng = np.random.default_rng(0)
    row = [(x, 30 + int(rng.random() < 0.25), np.pi / 2 + rng.normal(0, 0.1)) for x in range(10, 70)]
    row = [point for point in row if not 40 <= point[0] < 40 + MAX_GAP_PX]
    crossing = [(35, y, 0.0) for y in range(5, 55)]
    edges = edge_map_of(row + crossing)
    edgels = grow_lines(edges, edges.strength > 0, 8.0)
    spans = [np.ptp(edgels.points[a:b], axis=0) for a, b in edgels.groups]
    assert max(span[0] for span in spans) >= 55
    assert max(span[1] for span in spans) >= 45


def test_wider_gaps_end_a_line() -> None:
    row = [(x, 30, np.pi / 2) for x in range(5, 75) if not 35 <= x < 36 + MAX_GAP_PX]
    edges = edge_map_of(row)
    assert len(grow_lines(edges, edges.strength > 0, 8.0).groups) == 2


def test_edgels_of_another_direction_do_not_join() -> None:
    edges = edge_map_of([(x, 30, 0.0 if x >= 40 else np.pi / 2) for x in range(10, 70)])
    edgels = grow_lines(edges, edges.strength > 0, 8.0)
    assert len(edgels.groups) == 1
    assert edgels.points[:, 0].max() == 39


def test_the_two_sides_of_a_thin_bar_stay_apart() -> None:
    edges = edge_map_of([(x, y, np.pi / 2) for x in range(10, 70) for y in (30, 33)])
    edgels = grow_lines(edges, edges.strength > 0, 8.0)
    assert len(edgels.groups) == 2
    for a, b in edgels.groups:
        assert np.ptp(edgels.points[a:b, 1]) == 0


def test_steep_and_flat_lines_alike() -> None:
    points = [(x, 20 + round(0.5 * (x - 10)), np.arctan(0.5) + np.pi / 2) for x in range(10, 60)]
    for flip in (False, True):
        turned = [(y, x, np.pi / 2 - n) if flip else (x, y, n) for x, y, n in points]
        edges = edge_map_of(turned, shape=(80, 80))
        edgels = grow_lines(edges, edges.strength > 0, 8.0)
        assert edgels.groups.tolist() == [[0, 50]]


def test_short_lines_are_dropped() -> None:
    edges = edge_map_of([(x, 30, np.pi / 2) for x in range(10, 16)])
    assert len(grow_lines(edges, edges.strength > 0, 8.0).groups) == 0
    nothing = edge_map_of([])
    assert len(grow_lines(nothing, nothing.strength > 0, 8.0).groups) == 0
