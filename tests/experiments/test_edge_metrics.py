"""The measures of edge maps that the benchmarks report."""

from __future__ import annotations

import numpy as np
import pytest

from experiments.edge_metrics import edge_quality, pratt_merit

NOTHING = np.zeros((60, 80), np.bool_)


def line(row: int) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    mask = NOTHING.copy()
    mask[row, 10:70] = True
    return mask


def test_an_edge_in_its_place_is_perfect() -> None:
    quality = edge_quality(line(30).astype(np.float32), line(30), NOTHING)
    assert (quality.best_f, quality.false_at_best, quality.false_at_recall_80) == (1.0, 0, 0)
    assert quality.best_merit == 1.0


def test_weaker_false_edges_do_no_harm_and_stronger_ones_do() -> None:
    true, false = line(30).astype(np.float32), line(45).astype(np.float32)
    assert edge_quality(true + 0.5 * false, line(30), NOTHING).best_f == 1.0
    harmed = edge_quality(true + 2.0 * false, line(30), NOTHING)
    assert harmed.best_f == pytest.approx(2.0 / 3.0)
    assert harmed.false_at_best == harmed.false_at_recall_80 == 60
    assert edge_quality(true + 2.0 * false, line(30), line(45)).best_f == 1.0


def test_pratts_merit_falls_with_distance_and_with_false_or_missing_edgels() -> None:
    assert edge_quality(line(33).astype(np.float32), line(30), NOTHING).best_merit == pytest.approx(0.5)
    assert pratt_merit(np.zeros(60), 60) == 1.0
    assert pratt_merit(np.zeros(30), 60) == 0.5
    assert pratt_merit(np.concatenate([np.zeros(60), np.full(60, 1e6)]), 60) == pytest.approx(0.5)
    assert pratt_merit(np.zeros(0), 60) == 0.0
