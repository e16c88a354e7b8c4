"""Settings by search: from the best of some, one knob at a time to where its score rises most."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from numerics.arrays import Floats, Ints

MOST_ROUNDS = 8  # the score has risen by less than a bit's tenth after so many; chosen by hand
LEAST_RISE = 0.01  # bits, for which another round is worth its time


def climb(
    score: Callable[[Ints], Floats], start: Ints, tops: Sequence[int], steps: Sequence[Sequence[int]]
) -> tuple[Ints, Floats]:
    """Coordinate ascent over whole numbers; all that was looked at, (M, D), and its scores, (M,), best first.

    Parameters
    ----------
    score
        Of knobs (M, D).
    start
        (D,) where to begin.
    tops, steps
        Of each knob its greatest value (the least is 0), and by how much it is turned at a time: none for one
        that stays.
    """
    turns = [(knob, step) for knob, by in enumerate(steps) for step in by]
    looked, scores = start[None], score(start[None])
    best = 0
    for _ in range(MOST_ROUNDS if turns else 0):
        around = np.repeat(looked[best][None], len(turns), axis=0)
        for row, (knob, step) in enumerate(turns):
            around[row, knob] = min(max(around[row, knob] + step, 0), tops[knob])
        looked = np.vstack([looked, around])
        scores = np.concatenate([scores, score(around)])
        before, best = best, int(np.argmax(scores))
        if scores[best] < scores[before] + LEAST_RISE:
            break
    _, first = np.unique(looked, axis=0, return_index=True)
    order = first[np.argsort(-scores[first], kind="stable")]
    return looked[order], scores[order]
