"""What lines that are shown for the first time will speak for a pose, on the account of its score."""

from __future__ import annotations

import math

import numpy as np

from geometry.visibility import Samples
from numerics.arrays import Floats
from vision_server.trust.probability import FITTED, MOST_CONFIRMED, SOME_MISSING
from vision_server.trust.support import BY_CHANCE, MISSING_SUPPORT, MOST_RUNS, RUN_PX, SEEN


class Belief:
    """Log odds of a pose by the lines that are confirmed and missing (`pose.trust`), and what images add.

    Parameters
    ----------
    samples
        N of the visible lines.
    seen
        (N,), share of each sample's line that the set shows, 0..1.
    """

    def __init__(self, samples: Samples, seen: Floats) -> None:
        lines, number = np.unique(samples.line, return_inverse=True)
        px = (number[:, None] == np.arange(len(lines))) * samples.px[:, None]
        self._px = px.sum(axis=0)
        self._mean = px / self._px
        self._share = seen @ self._mean
        self._runs = np.minimum(self._px / RUN_PX, MOST_RUNS)
        self._before = self._log_odds(np.zeros((1, len(lines))))

    def gains(self, shown: Floats) -> Floats:
        """Bits (M,) of M images that show the samples with these probabilities, (M, N)."""
        return np.asarray((self._log_odds(shown @ self._mean) - self._before) / math.log(2.0))

    def _log_odds(self, shown: Floats) -> Floats:
        """Of the pose, (M,), but for a constant, with lines shown with these probabilities, (M, lines)."""
        seen, unseen = math.log(SEEN / BY_CHANCE), math.log((1.0 - SEEN) / (1.0 - BY_CHANCE))
        share = self._share + (1.0 - self._share) * shown
        confirmed = np.maximum(self._runs * (share * seen + (1.0 - share) * unseen), 0.0).sum(axis=1)
        missing = ((self._share < MISSING_SUPPORT) * (1.0 - shown)) @ self._px / self._px.sum()
        return np.asarray(
            FITTED.log2_confirmed * np.log2(1.0 + np.minimum(confirmed, MOST_CONFIRMED))
            + FITTED.log2_missing * np.log2(1.0 + missing / SOME_MISSING)
        )
