"""What can be seen of a model from each direction, computed once per direction and search.

Which lines are visible depends on the direction from which the target is seen and hardly on the rest of the
pose, so the thousands of poses of a search share a few hundred hidden-line removals.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from geometry.camera import Camera
from geometry.chains import chords, longest_chains
from geometry.coarser import coarser
from geometry.hidden_lines import Trace, trace
from geometry.model import Model
from geometry.occluders import Solid
from geometry.pose import Pose
from geometry.straight_runs import longest_run
from geometry.visibility import MIN_LINE_PX, solid_of
from numerics.arrays import Floats, Ints
from numerics.kernels import kernel
from numerics.two_cores import both

VIEW_CELLS = 11  # cells of directions across each side of a cube around the model, odd (by hand)
VIEW_CELL_DEG = 90.0 / VIEW_CELLS  # width of one
UNBOUNDED_PX = 1e9  # of a view, that the frame does not cut
MOST_SEARCHED_CURVES = 200  # lines and curves of a search (by hand): more make it slower, not better
LEAST_SEARCHED_LINE_PX = 14.0  # of so many: as fine a texture has hardly a segment; 10 found fewer poses
# Shares of the diameter, by hand: lines no farther apart are one, and what is shorter may be part of a bend.
ONE_LINE_SHARE, LITTLE_BENT_SHARE = 0.005, 0.3
TANGENT_STEP_SHARE = 0.01  # of the diameter, between two points that tell an outline's direction


@lru_cache(maxsize=8)
def sparse_solid(model: Model) -> Solid:
    """The model with its longest MOST_SEARCHED_CURVES, arcs made straight; outlines all stay.

    Everything still hides what is behind it. More lines make a search slower, not better.
    """
    model = coarser(model)
    solid = solid_of(model)
    arcs, alone = chords(model)
    line = np.concatenate([alone, arcs[:, 0]])
    ends = np.concatenate([solid.lines[alone], arcs[:, 1:]])
    kept = longest_chains(model.vertices, ends, solid.smooth[line], solid.chain[line], MOST_SEARCHED_CURVES)
    line = line[kept]
    leader = np.arange(len(line))
    return solid._replace(
        lines=ends[kept],
        line_faces=solid.line_faces[line],
        smooth=solid.smooth[line],
        chain=solid.chain[line],
        leader=leader,
        place=np.zeros_like(leader),
        backwards=np.zeros(len(leader), dtype=bool),
    )


@lru_cache(maxsize=8)
def least_line_px(model: Model) -> float:
    """Lines and chains that are shorter in the image are left out: longer ones of a model of very many.

    They would be missed by the right pose, of which most are seen, and not by a wrong one that shows few.
    """
    solid = sparse_solid(model)
    many = len(np.unique(solid.chain[~solid.smooth])) >= MOST_SEARCHED_CURVES
    return LEAST_SEARCHED_LINE_PX if many else MIN_LINE_PX


class ViewTable(NamedTuple):
    """Samples of all directions seen so far, for the kernels.

    Attributes
    ----------
    first : (C + 1,) int64, where the runs of each view start; a run is the visible samples of one line.
    run : (Q + 1,) int64, where the samples of each run start.
    ends : (Q, 2, 3) float64, both ends of the line of each run, or two points on an outline's tangent,
        target frame, metres.
    points : (S, 3) float64, the samples, target frame, metres.
    px : (S,) float64, image length that a sample stands for at the seed's range.
    """

    first: Ints
    run: Ints
    ends: Floats
    points: Floats
    px: Floats


class Views:
    """Visible samples by direction of view, filled in as directions are asked for."""

    def __init__(self, model: Model, camera: Camera, seed: Pose, spacing_px: float) -> None:
        self._solid = sparse_solid(model)
        self._intrinsics = camera.intrinsics
        self._spacing_px, self._least_px = spacing_px, least_line_px(model)
        self._middle = model.middle
        centre = -(seed.matrix.T @ seed.translation) - self._middle
        self._range = float(np.linalg.norm(centre))
        self._frame = frame_towards(centre / self._range)
        self._view_of = np.full(6 * VIEW_CELLS**2, -1, dtype=np.int64)
        self._parts: list[tuple[Ints, Floats, Floats, Floats]] = []  # runs: starts and ends; points, px
        self._table: ViewTable | None = None

    def __len__(self) -> int:
        return len(self._parts)

    def of(self, rotations: Floats, translations: Floats) -> Ints:
        """Index of the view of each pose, (N, 3, 3) and (N, 3) to (N,)."""
        rotations = np.ascontiguousarray(rotations)  # one kernel, not one for each way they may lie
        cells = cells_of(rotations, np.array(translations, order="C"), self._middle, self._frame)
        new = np.unique(cells[self._view_of[cells] < 0])
        if len(new):
            self._view_of[new] = len(self._parts) + np.arange(len(new))
            half = (len(new) + 1) // 2
            for some in both(lambda: self._seen(new[:half]), lambda: self._seen(new[half:])):
                self._parts += some
            self._table = None
        out: Ints = self._view_of[cells]
        return out

    def _seen(self, cells: Ints) -> list[tuple[Ints, Floats, Floats, Floats]]:
        """What is seen from the middle of each of these cells."""
        return [
            _seen_from(
                self._solid,
                cell,
                self._middle,
                self._frame,
                self._range,
                self._intrinsics,
                self._spacing_px,
                self._least_px,
            )
            for cell in cells.tolist()
        ]

    def table(self) -> ViewTable:
        """The samples of all views so far."""
        if self._table is None:
            firsts, ends, points, px = zip(*self._parts, strict=True)
            before = np.cumsum([0, *map(len, points)])
            self._table = ViewTable(
                first=np.cumsum([0, *map(len, ends)]),
                run=np.concatenate(
                    [*(first[:-1] + start for first, start in zip(firsts, before, strict=False)), before[-1:]]
                ),
                ends=np.concatenate(ends),
                points=np.concatenate(points),
                px=np.concatenate(px),
            )
        return self._table

    def typical_line_px(self, pose: Pose) -> float:
        """Image length of a line that a random pixel of the visible lines is on, 0 when there is none, px."""
        first, _, _, px = self._parts[int(self.of(pose.matrix[None], pose.translation[None])[0])]
        lengths = np.bincount(np.repeat(np.arange(len(first) - 1), np.diff(first)), weights=px)
        total = float(lengths.sum())
        return float((lengths**2).sum()) / total if total > 0 else 0.0


@lru_cache(maxsize=8)
def longest_straight_m(model: Model) -> float:
    """How long the longest straight run of a model's lines is, gaps included; at least a bend's share.

    Lines that continue each other are linked to one segment in an image, and so are lines that bend little.
    """
    lines = model.vertices[sparse_solid(model).lines]
    return longest_run(lines, ONE_LINE_SHARE * model.diameter, LITTLE_BENT_SHARE * model.diameter)


def frame_towards(direction: Floats) -> Floats:
    """A right-handed frame (3, 3), in rows, whose third axis is the unit vector given."""
    out = np.empty((3, 3))
    x, y, z = direction[0], direction[1], direction[2]
    if abs(x) <= abs(y) and abs(x) <= abs(z):  # across the axis that is farthest from the direction
        across = (0.0, z, -y)
    elif abs(y) <= abs(z):
        across = (-z, 0.0, x)
    else:
        across = (y, -x, 0.0)
    length = math.sqrt(across[0] ** 2 + across[1] ** 2 + across[2] ** 2)
    a, b, c = across[0] / length, across[1] / length, across[2] / length
    out[0, 0], out[0, 1], out[0, 2] = a, b, c
    out[1, 0], out[1, 1], out[1, 2] = y * c - z * b, z * a - x * c, x * b - y * a
    out[2, 0], out[2, 1], out[2, 2] = x, y, z
    return out


_frame_towards = kernel()(frame_towards)


@kernel()
def cells_of(rotations: Floats, translations: Floats, middle: Floats, frame: Floats) -> Ints:
    """Cell (N,) of the direction from the model's middle to the camera, by equal angles on a cube's sides.

    The cube stands in ``frame``, whose third axis goes through the middle of a cell.
    """
    step = math.radians(VIEW_CELL_DEG)
    out = np.empty(len(rotations), dtype=np.int64)
    centre, towards = np.empty(3), np.empty(3)
    for i in range(len(rotations)):
        for k in range(3):
            centre[k] = -middle[k]
            for c in range(3):
                centre[k] -= rotations[i, c, k] * translations[i, c]
        for k in range(3):
            towards[k] = frame[k, 0] * centre[0] + frame[k, 1] * centre[1] + frame[k, 2] * centre[2]
        axis = int(np.argmax(np.abs(towards)))
        ahead, u, v = abs(towards[axis]), towards[(axis + 1) % 3], towards[(axis + 2) % 3]
        side = 2 * axis + (towards[axis] < 0.0)
        row = min(math.floor(math.atan2(u, ahead) / step + 0.5 * VIEW_CELLS), VIEW_CELLS - 1)
        column = min(math.floor(math.atan2(v, ahead) / step + 0.5 * VIEW_CELLS), VIEW_CELLS - 1)
        out[i] = (side * VIEW_CELLS + row) * VIEW_CELLS + column
    return out


@kernel()
def middle_of_cell(cell: int, frame: Floats) -> Floats:
    """Unit direction (3,) of the middle of a cell, see `cells_of`."""
    step, middle = math.radians(VIEW_CELL_DEG), 0.5 * (VIEW_CELLS - 1)
    side, row, column = (cell // VIEW_CELLS**2, cell // VIEW_CELLS % VIEW_CELLS, cell % VIEW_CELLS)
    axis = side // 2
    u, v = math.tan(step * (row - middle)), math.tan(step * (column - middle))
    length = math.sqrt(1.0 + u * u + v * v)
    ahead = -1.0 if side % 2 else 1.0
    out = np.empty(3)
    for k in range(3):
        across = u * frame[(axis + 1) % 3, k] + v * frame[(axis + 2) % 3, k]
        out[k] = (ahead * frame[axis, k] + across) / length
    return out


@kernel()
def _seen_from(
    solid: Solid,
    cell: int,
    middle: Floats,
    frame: Floats,
    distance: float,
    intrinsics: Floats,
    spacing_px: float,
    min_line_px: float,
) -> tuple[Ints, Floats, Floats, Floats]:
    """Starts and ends of the runs, points (N, 3) and px (N,) of the samples, from the middle of a cell."""
    towards = middle_of_cell(cell, frame)
    centre, translation = middle + distance * towards, np.empty(3)
    rotation = _frame_towards(-towards)
    for k in range(3):
        translation[k] = -(
            rotation[k, 0] * centre[0] + rotation[k, 1] * centre[1] + rotation[k, 2] * centre[2]
        )
    bounds = np.array([-UNBOUNDED_PX, -UNBOUNDED_PX, UNBOUNDED_PX, UNBOUNDED_PX])
    seen = trace(solid, rotation, translation, intrinsics, bounds, spacing_px, spacing_px, min_line_px)
    first, ends = runs_of(solid, seen)
    return first, ends, seen.points, seen.px


@kernel()
def runs_of(solid: Solid, seen: Trace) -> tuple[Ints, Floats]:
    """Where the samples of each line start, (Q + 1,), and both ends of these lines, (Q, 2, 3)."""
    count, runs = len(seen.own), 0
    first, ends = np.empty(count + 1, dtype=np.int64), np.empty((count, 2, 3))
    for i in range(count):
        line = seen.own[i]
        if i > 0 and line == seen.own[i - 1]:
            continue
        first[runs] = i
        for k in range(3):
            if seen.outline[i]:
                ends[runs, 0, k] = seen.points[i, k]
                ends[runs, 1, k] = seen.points[i, k] + TANGENT_STEP_SHARE * solid.diameter * seen.along[i, k]
            else:
                ends[runs, 0, k] = solid.vertices[solid.lines[line, 0], k]
                ends[runs, 1, k] = solid.vertices[solid.lines[line, 1], k]
        runs += 1
    first[runs] = count
    return first[: runs + 1], ends[:runs]
