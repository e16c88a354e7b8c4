"""How well an edge map separates true outlines from everything else, whatever its threshold."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, distance_transform_edt

TOLERANCE_PX = 3.0  # between an edgel and the outline it belongs to
THRESHOLDS = 150  # tried, at even quantiles of the magnitude
MARGIN_PX = 6  # frame that does not count


@dataclass(frozen=True)
class EdgeQuality:
    """Best F over thresholds, false pixels there, and false pixels at the threshold that reaches 80 %
    recall."""

    best_f: float
    false_at_best: int
    false_at_recall_80: int | None


def outline_of(inside: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Pixels of an area that touch its outside."""
    return np.asarray(inside & binary_dilation(~inside))


def edge_quality(
    magnitude: NDArray[np.float32], outline: NDArray[np.bool_], ignored: NDArray[np.bool_]
) -> EdgeQuality:
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
    near = (distance_transform_edt(~outline) <= TOLERANCE_PX) & frame
    wrong = frame & ~near & ~ignored
    values = np.where(frame, magnitude, 0.0)
    best, at_best, at_80 = 0.0, 0, None
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
    return EdgeQuality(best, at_best, at_80)
