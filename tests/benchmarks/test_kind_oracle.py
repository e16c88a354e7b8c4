"""What the oracle leaves out is what is not of the model, and nothing else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from benchmarks.kind_oracle import Known, drawn_scene, features, of_truth, run
from vision_server.segments.extraction import extract_segments


def row(kept: bool, otherwise: bool) -> Known:
    """Points along x at y = 20, one a pixel."""
    points = np.column_stack([np.arange(40.0), np.full(40, 20.0)])
    normals = np.tile([0.0, 1.0], (40, 1))
    return Known(cKDTree(features(points, normals)), np.full(40, kept), 2.5, otherwise)


def test_what_lies_near_and_runs_alike_is_known_and_the_rest_is_not() -> None:
    points = np.array([[10.2, 21.0], [10.2, 24.0], [10.2, 21.0]])
    normals = np.array([[0.0, -1.0], [0.0, 1.0], [1.0, 0.0]])
    assert row(True, False).keeps(points, normals).tolist() == [True, False, False]
    assert row(False, True).keeps(points, normals).tolist() == [False, True, True]


def test_a_segment_is_what_most_of_it_is() -> None:
    ends = np.array([[2.0, 20.5, 30.0, 20.5], [2.0, 30.0, 30.0, 30.0], [30.0, 20.0, 52.0, 20.0]])
    assert row(True, False).segments(ends).tolist() == [True, False, False]


def test_the_oracle_leaves_few_segments_of_a_patterned_scene_and_the_pose() -> None:
    scene = drawn_scene(0)
    ends = extract_segments(scene.images.edge_map(list(scene.images.images))).endpoints
    kept = of_truth(scene).segments(ends)
    assert 4 < kept.sum() < 0.3 * len(ends)
    found = {one["way"]: one for one in run(replace(scene, name="0"), starts=1)}
    assert len(found) == 6
    assert found["both of the model"]["right"]
