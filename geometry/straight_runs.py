"""The longest straight run of lines in space."""

from __future__ import annotations

import numpy as np

from numerics.arrays import Floats, Ints

PARALLEL = 0.05  # radians, about: lines so nearly parallel are looked at together (by hand)
LEAST_COVERED = 0.5  # of a run, that is on lines: the rest is gaps (by hand)
MANY_PARALLEL = 300  # of so many their whole extent is taken for a run: to look at each beside each is slow


def longest_run(lines: Floats, apart: float, least: float) -> float:
    """How long the longest run of lines is that continue each other, at least ``least``.

    Parameters
    ----------
    lines : (L, 2, 3), their ends.
    apart : how far other lines may be beside one that they continue.
    """
    length = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1)
    lines, length = lines[length > 0.0], length[length > 0.0]
    if not len(lines):
        return least
    unit = (lines[:, 1] - lines[:, 0]) / length[:, None]
    order, begin = _by_direction(unit)
    lines, length, unit = lines[order], length[order], unit[order]
    counts = np.diff(np.append(begin, len(lines)))
    place = (lines @ np.repeat(unit[begin], counts, axis=0)[:, :, None])[:, :, 0]
    extent = np.maximum.reduceat(place.max(axis=1), begin) - np.minimum.reduceat(place.min(axis=1), begin)
    most = np.minimum(extent, np.add.reduceat(length, begin) / LEAST_COVERED)  # no run of these is longer
    longest = least
    for group in np.argsort(-most):
        if most[group] <= longest:
            break
        some = slice(begin[group], begin[group] + counts[group])
        few = counts[group] <= MANY_PARALLEL
        run = _run(lines[some], unit[some], apart) if few else np.inf
        longest = max(longest, min(run, float(most[group])))
    return longest


def _by_direction(unit: Floats) -> tuple[Ints, Ints]:
    """An order of unit vectors (L, 3) with nearly parallel ones together, and where each group begins."""
    rows, columns = np.triu_indices(3)
    cell = np.round(unit[:, rows] * unit[:, columns] / PARALLEL).astype(np.int64)  # the same of -unit
    key = (cell + round(1.0 / PARALLEL)) @ (round(2.0 / PARALLEL) + 1) ** np.arange(len(rows))
    order = np.argsort(key, kind="stable")
    return order, np.flatnonzero(np.diff(key[order], prepend=-1))


def _run(lines: Floats, unit: Floats, apart: float) -> float:
    """How long the longest run of a few nearly parallel lines (M, 2, 3) of directions (M, 3) is."""
    from_start = lines[None] - lines[:, None, :1]  # of each, as seen from each: (M, M, 2, 3)
    place = np.einsum("aibk,ak->aib", from_start, unit)
    beside = np.linalg.norm(from_start - place[..., None] * unit[:, None, None], axis=-1).max(axis=-1)
    on_line = (beside < apart)[..., None]
    last = np.where(on_line, place, -np.inf).max(axis=(1, 2))
    return float((last - np.where(on_line, place, np.inf).min(axis=(1, 2))).max())
