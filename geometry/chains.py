"""Lines that continue each other: the facets of a rim, of a hole, of a curved surface's outline."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from geometry.model import Model
from numerics.arrays import Flags, Floats, Ints
from numerics.groups import root
from numerics.kernels import kernel

Run = list[tuple[int, bool]]  # lines that follow each other, and which of them run backwards

BEND_COSINE = float(np.cos(np.radians(46.0)))  # sharp lines that bend less are a curve: of eight facets on
CURVE_DEG = 20.0  # by which an arc may bend and be seen as one line, whose edge is nearly straight (by hand)
SHORT, SHORT_CURVE_DEG = 0.06, 90.0  # of the diameter: arcs of a small hole may bend by more (by hand)
CHORD_DEG = 11.0  # by which the arc of a chord bends: it is 0.005 radii off, and a circle has 36


@dataclass(frozen=True, eq=False)
class Arcs:
    """Sharp lines that follow each other with little bend, as if they were one line.

    Attributes
    ----------
    leader : (L,) int64, of each line the first line of its arc; its own index where it is alone.
    place : (L,) int64, of each line in its arc, in the order in which they follow each other.
    backwards : (L,) bool, lines that run against that order.
    """

    leader: Ints
    place: Ints
    backwards: Flags


@lru_cache(maxsize=8)
def chains(model: Model) -> Ints:
    """Chain (L,) of each line, the index of one of its lines; a line that nothing continues has its own.

    Sharp lines are chained where just two of them meet and bend little, lines of curved surfaces wherever
    they meet: which of them are the outline depends on the view. Shared, not to be written to.
    """
    own = np.flatnonzero(model.smooth)
    ends = model.lines[own].ravel()
    order = np.argsort(ends, kind="stable")
    beside = np.flatnonzero(np.diff(ends[order]) == 0)  # lines of curved surfaces that meet
    meeting = own[np.stack([order[beside], order[beside + 1]], axis=1) // 2]
    return joined(len(model.lines), np.concatenate([followers(model), meeting]))


@kernel()
def joined(count: int, pairs: Ints) -> Ints:
    """The group (count,) of each item, named after one of its own, when pairs (P, 2) are of one group."""
    parent = np.arange(count)
    for p in range(len(pairs)):
        parent[root(parent, pairs[p, 1])] = root(parent, pairs[p, 0])
    for item in range(count):
        parent[item] = root(parent, item)
    return parent


def longest_chains(vertices: Floats, lines: Ints, smooth: Flags, chain: Ints, most: int) -> Flags:
    """Which lines (L, 2) belong to so many of the longest chains (L,) of sharp ones; all smooth ones do."""
    length = np.linalg.norm(np.diff(vertices[lines], axis=1)[:, 0], axis=1)
    names, curve = np.unique(chain, return_inverse=True)
    whole = np.bincount(curve, np.where(smooth, 0.0, length))
    sharp = np.flatnonzero(whole > 0.0)
    if len(sharp) <= most:
        return np.asarray(smooth | (whole[curve] > 0.0))
    among_equals = np.random.default_rng(0).uniform(1.0, 1.25, len(sharp))
    kept = np.zeros(len(names), dtype=bool)
    kept[sharp[np.argsort(-whole[sharp] * among_equals, kind="stable")[:most]]] = True
    return np.asarray(smooth | kept[curve])


def arcs(model: Model) -> Arcs:
    """Cut the chains of sharp lines into arcs that bend by less than CURVE_DEG."""
    count = len(model.lines)
    out = Arcs(np.arange(count), np.zeros(count, dtype=np.int64), np.zeros(count, dtype=bool))
    for run in runs(model, CURVE_DEG):
        first = min(line for line, _ in run)
        for place, (line, backwards) in enumerate(run):
            out.leader[line], out.place[line], out.backwards[line] = first, place, backwards
    return out


def chords(model: Model) -> tuple[Ints, Ints]:
    """Arcs that bend by less than CHORD_DEG made straight, and the lines (M,) that are of none.

    Returns
    -------
    (K, 3), a line in the middle of each arc, and the vertices that its chord is between; without what closes.
    """
    pieces: list[tuple[int, int, int]] = []
    followed: list[int] = []
    for run in runs(model, CHORD_DEG):
        (first, first_back), (last, last_back) = run[0], run[-1]
        ends = model.lines[first, int(first_back)], model.lines[last, int(not last_back)]
        pieces.append((run[len(run) // 2][0], *ends))
        followed += [line for line, _ in run]
    found = np.array(pieces, dtype=np.int64).reshape(-1, 3)
    return found[found[:, 1] != found[:, 2]], np.setdiff1d(np.arange(len(model.lines)), followed)


def runs(model: Model, bend_deg: float) -> Iterator[Run]:
    """Sharp lines that follow each other and bend by less than that from first to last, two or more."""
    beside: dict[int, list[int]] = {}
    for one, other in followers(model).tolist():
        beside.setdefault(one, []).append(other)
        beside.setdefault(other, []).append(one)
    if not beside:
        return
    steps = model.vertices[model.lines[:, 1]] - model.vertices[model.lines[:, 0]]
    length = np.linalg.norm(steps, axis=1)
    unit, own = steps / length[:, None], np.array(list(beside))
    ends = dict(zip(own.tolist(), model.lines[own].tolist(), strict=True))
    straight, bent = np.cos(np.radians([bend_deg, max(bend_deg, SHORT_CURVE_DEG)])).tolist()
    short, seen = SHORT * model.diameter, set()
    for start in sorted(beside, key=lambda line: len(beside[line])):  # ends of open chains first
        if start in seen:
            continue
        run: Run = []
        line, last = start, _loose_end(ends, start, beside[start])
        total, first = 0.0, unit[start]
        while True:
            seen.add(line)
            backwards = ends[line][1] == last
            along = -unit[line] if backwards else unit[line]
            if run and float(along @ first) < (bent if total + length[line] < short else straight):
                if len(run) > 1:
                    yield run
                run = []
            if not run:
                first, total = along, 0.0
            run.append((line, backwards))
            total += float(length[line])
            last = ends[line][0] if backwards else ends[line][1]
            onward = [other for other in beside[line] if other not in seen and last in ends[other]]
            if not onward:
                break
            line = onward[0]
        if len(run) > 1:
            yield run


def _loose_end(ends: dict[int, list[int]], line: int, beside: list[int]) -> int:
    """The vertex of a line from which to walk along its chain: one that nothing continues, if there is."""
    a, b = ends[line]
    return a if not any(a in ends[other] for other in beside) or len(beside) > 1 else b


def followers(model: Model) -> Ints:
    """Pairs (P, 2) of sharp lines that continue each other: just two meet, and they bend little."""
    own = np.flatnonzero(~model.smooth)
    ends = model.lines[own].ravel()
    order = np.argsort(ends, kind="stable")
    starts = np.flatnonzero(np.r_[True, np.diff(ends[order]) != 0, True])
    pairs = starts[:-1][np.diff(starts) == 2]
    one, other = own[order[pairs] // 2], own[order[pairs + 1] // 2]
    corner = ends[order[pairs]]
    steps = []
    for line in (one, other):
        a, b = model.lines[line].T
        step = model.vertices[np.where(a == corner, b, a)] - model.vertices[corner]
        steps.append(step / np.linalg.norm(step, axis=1, keepdims=True))
    cosine = (steps[0] * steps[1]).sum(axis=1)
    good = (cosine <= -BEND_COSINE) & (one != other)
    return np.stack([one[good], other[good]], axis=1)
