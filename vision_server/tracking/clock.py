"""When frames were taken, and what is strange about that."""

from __future__ import annotations

import numpy as np

from vision_server.channels.depth import Pixels

PERIOD_S = 1.0 / 30.0  # between frames, where nothing tells
COMPARED_ROW_STEP = 48  # Two pictures are compared at each so many-th row first, to notice a frozen camera.


class Clock:
    """Time from frame to frame."""

    def __init__(self) -> None:
        self._time_s = 0.0
        self._last: Pixels | None = None

    def passed(self, pixels: Pixels, time_s: float | None) -> tuple[str, float]:
        """What is strange about a frame, mostly nothing, and seconds since the one before.

        Without ``time_s`` it was taken PERIOD_S after the one before.
        """
        before, self._time_s = self._time_s, self._time_s + PERIOD_S if time_s is None else time_s
        last, self._last = self._last, pixels
        if last is not None and not self._time_s > before:
            return f"its time goes back, from {before:g} s to {self._time_s:g} s", PERIOD_S
        frozen = last is not None and _are_same(last, pixels)
        note = "the same picture as the frame before: the camera may be frozen" if frozen else ""
        return note, self._time_s - before


def _are_same(one: Pixels, other: Pixels) -> bool:
    """Whether two pictures are; of most pairs some rows tell."""
    return np.array_equal(one[::COMPARED_ROW_STEP], other[::COMPARED_ROW_STEP]) and np.array_equal(one, other)
