"""How well an edge map separates true outlines from everything else, whatever its threshold."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_dilation, distance_transform_edt

from numerics.arrays import Field, Flags, Floats

TOLERANCE_PX = 3.0  # between an edgel and the outline it belongs to
THRESHOLDS = 150  # tried, at even quantiles of the magnitude
PRATT_SCALE = 1.0 / 9.0  # of the squared distance: an edgel 3 px off counts half
MARGIN_PX = 6  # frame that does not count


@dataclass(frozen=True)
class EdgeQuality:
    """Quality of an edge map over all thresholds.

    Attributes
    ----------
    best_f, false_at_best
        Best F, and the false pixels there.
    false_at_recall_80
        False pixels at the highest threshold that reaches 80 % recall; None where none does.
    best_merit
        Best figure of merit of Pratt (1978), see `pratt_merit`.
    """

    best_f: float
    false_at_best: int
    false_at_recall_80: int | None
    best_merit: float


def outline_of(inside: Flags) -> Flags:
    """Pixels of an area that touch its outside."""
    return np.asarray(inside & binary_dilation(~inside))


def pratt_merit(distance: Floats, true_count: int) -> float:
    """Figure of merit of Pratt (1978): sum of 1 / (1 + d^2 / 9) over edgels, over the larger count.

    Parameters
    ----------
    distance
        float64 (N,), of each edgel found from the nearest true edge pixel, px.
    true_count
        True edge pixels.

    Returns
    -------
    0 (nothing found, or all of it far off) to 1 (as many edgels as there should be, all in their places).
    """
    return float(np.sum(1.0 / (1.0 + PRATT_SCALE * distance**2)) / max(len(distance), true_count, 1))


def edge_quality(magnitude: Field, outline: Flags, ignored: Flags) -> EdgeQuality:
    """Quality of thinned edges against known outlines.

    Parameters
    ----------
    magnitude
        float32 (H, W), 0 off the ridges.
    outline
        bool (H, W), true edges.
    ignored
        bool (H, W), where an edge is neither right nor wrong (veins inside a leaf); near the outline all
        count.
    """
    frame = np.zeros(outline.shape, np.bool_)
    frame[MARGIN_PX:-MARGIN_PX, MARGIN_PX:-MARGIN_PX] = True
    outline = outline & frame
    distance = distance_transform_edt(~outline)
    near = (distance <= TOLERANCE_PX) & frame
    wrong = frame & ~near & ~ignored
    values = np.where(frame, magnitude, 0.0)
    best, at_best, at_80, merit = 0.0, 0, None, 0.0
    for threshold in np.unique(np.quantile(values[values > 0], np.linspace(0, 1, THRESHOLDS)))[::-1]:
        found = values >= threshold
        recall = float(np.mean(distance_transform_edt(~found)[outline] <= TOLERANCE_PX))
        right, false = int(np.sum(found & near)), int(np.sum(found & wrong))
        precision = right / max(right + false, 1)
        f = 2.0 * precision * recall / max(precision + recall, 1e-9)
        if f > best:
            best, at_best = f, false
        if at_80 is None and recall >= 0.8:
            at_80 = false
        merit = max(merit, pratt_merit(distance[found & (near | wrong)], int(outline.sum())))
    return EdgeQuality(best, at_best, at_80, merit)
