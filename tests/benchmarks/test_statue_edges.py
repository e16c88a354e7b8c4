"""The measure of outlines of statues."""

from __future__ import annotations

import cv2
import numpy as np

from benchmarks.statue_edges import score


def test_the_contour_alone_is_perfect_and_what_is_inside_is_false() -> None:
    mask = np.zeros((120, 120), np.bool_)
    mask[20:100, 30:90] = True
    ridge = np.zeros(mask.shape, np.float32)
    contours, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    for x, y in contours[0][:, 0]:
        ridge[y, x] = 10.0
    assert score(ridge, mask) == (1.0, 0)
    ridge[60, 40:80] = 20.0  # stronger than the contour: no threshold leaves it out
    found = score(ridge, mask)
    assert found.best_f < 1.0
    assert found.false_px == 40
