"""Linking edgels into chains."""

from __future__ import annotations

import numpy as np
import pytest

from tests.vision_server.edge_scenes import edge_map_of, polygon_with_shadows, step
from vision_server.baselines.linking import link_edgels
from vision_server.channels.channel import channel_statistics
from vision_server.edges.merging import merge_channels


@pytest.mark.slow
def test_a_line_is_one_chain_in_order() -> None:
    edges = merge_channels([channel_statistics(step(0.5, 0.0, 50, 150))])
    chains = link_edgels(edges, edges.strength > 30)
    lengths = np.diff(chains.groups)
    assert lengths.max() > 80
    chain = chains.points[slice(*chains.groups[int(np.argmax(lengths))])]
    along = chain @ np.array([-np.sin(0.5), np.cos(0.5)])
    assert np.all(np.diff(along) > 0) or np.all(np.diff(along) < 0)


def test_small_gaps_are_crossed_and_large_ones_not() -> None:
    row = [(x, 30, np.pi / 2) for x in range(10, 60)]
    one_missing = edge_map_of([p for p in row if p[0] != 30])
    assert len(link_edgels(one_missing, one_missing.strength > 0).groups) == 1
    many_missing = edge_map_of([p for p in row if not 28 <= p[0] <= 34])
    assert len(link_edgels(many_missing, many_missing.strength > 0).groups) == 2


def test_a_junction_does_not_turn_the_chain() -> None:
    cross = [(x, 30, np.pi / 2) for x in range(10, 60)] + [(35, y, 0.0) for y in range(5, 55) if y != 30]
    edges = edge_map_of(cross)
    chains = link_edgels(edges, edges.strength > 0)
    spans = [np.ptp(chains.points[a:b], axis=0) for a, b in chains.groups]
    assert any(span[0] == 49 and span[1] == 0 for span in spans)
    assert sum(span[1] > 15 for span in spans) >= 1


def test_every_edgel_is_used_once_at_most() -> None:
    edges = merge_channels([channel_statistics(image) for image in polygon_with_shadows(3)])
    mask = edges.strength > 3
    chains = link_edgels(edges, mask)
    assert len(chains.points) <= mask.sum()
    assert len(np.unique(chains.points, axis=0)) == len(chains.points)
    assert chains.groups[-1, 1] == len(chains.points)
    assert (chains.groups[1:, 0] == chains.groups[:-1, 1]).all()


def test_no_edgels_no_chains() -> None:
    edges = edge_map_of([])
    chains = link_edgels(edges, edges.strength > 0)
    assert len(chains.points) == 0
    assert chains.groups.shape == (0, 2)
