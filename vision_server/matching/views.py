"""What can be seen of a model from each direction, computed once per direction and search.

Which lines are visible depends on the direction from which the target is seen and hardly on the rest of the
pose, so the thousands of poses of a search share a few hundred hidden-line removals.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from geometry.visibility import solid_of, trace

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

CELL_DEG = 8.0  # width of a cell of directions
UNBOUNDED = 1e9  # px


class ViewTable(NamedTuple):
    """Samples of all directions seen so far, for the kernels.

    Attributes
    ----------
    first : (C + 1,) int64, where the samples of each view start.
    points, ends : (S, 3) float64, a sample and a point further along its line, target frame, metres.
    px : (S,) float64, image length of a sample at the seed's range.
    """

    first: Ints
    points: Floats
    ends: Floats
    px: Floats


class Views:
    """Visible samples by direction of view, filled in as directions are asked for."""

    def __init__(
        self, model: Model, camera: Camera, seed: Pose, spacing_px: float, min_line_px: float
    ) -> None:
        self._solid = solid_of(model)
        self._intrinsics = camera.intrinsics
        self._spacing_px = spacing_px
        self._min_line_px = min_line_px
        low, high = model.vertices.min(axis=0), model.vertices.max(axis=0)
        self._middle = (low + high) / 2
        along = model.vertices[model.lines[:, 1]] - model.vertices[model.lines[:, 0]]
        self._along = along
        centre = -(seed.matrix.T @ seed.translation) - self._middle
        self._range = float(np.linalg.norm(centre))
        towards = centre / self._range
        first = np.cross(towards, np.eye(3)[int(np.argmin(np.abs(towards)))])
        first /= np.linalg.norm(first)
        self._frame = np.stack([first, np.cross(towards, first), towards])
        self._view_of: dict[tuple[int, int], int] = {}
        self._parts: list[tuple[Floats, Floats, Floats, Ints]] = []
        self._table: ViewTable | None = None

    def __len__(self) -> int:
        return len(self._parts)

    def of(self, rotations: Floats, translations: Floats) -> Ints:
        """Index of the view of each pose, (N, 3, 3) and (N, 3) to (N,)."""
        cells = _cells(rotations, translations, self._middle, self._frame, math.radians(CELL_DEG))
        keys, inverse = np.unique(cells, axis=0, return_inverse=True)
        views = np.empty(len(keys), dtype=np.int64)
        for k, (row, column) in enumerate(keys.tolist()):
            if (row, column) not in self._view_of:
                self._view_of[row, column] = len(self._parts)
                self._parts.append(self._seen_from(row, column))
                self._table = None
            views[k] = self._view_of[row, column]
        out: Ints = views[inverse.reshape(-1)]
        return out

    def table(self) -> ViewTable:
        """The samples of all views so far."""
        if self._table is None:
            sizes = [len(px) for _, _, px, _ in self._parts]
            points, ends, px, _ = (np.concatenate(part) for part in zip(*self._parts, strict=True))
            self._table = ViewTable(np.concatenate([[0], np.cumsum(sizes)]), points, ends, px)
        return self._table

    def typical_line_px(self, pose: Pose) -> float:
        """Image length of a line that a random pixel of the visible lines is on, 0 when there is none, px."""
        view = int(self.of(pose.matrix[None], pose.translation[None])[0])
        line, px = self._parts[view][3], self._parts[view][2]
        lengths = np.bincount(line, weights=px) if len(line) else np.zeros(1)
        total = float(lengths.sum())
        return float((lengths**2).sum()) / total if total > 0 else 0.0

    def _seen_from(self, row: int, column: int) -> tuple[Floats, Floats, Floats, Ints]:
        a, b = math.radians(row * CELL_DEG), math.radians(column * CELL_DEG)
        angle = math.hypot(a, b)
        sine = math.sin(angle) / angle if angle > 0 else 1.0
        direction = np.array([a * sine, b * sine, math.cos(angle)]) @ self._frame
        right = np.cross(np.eye(3)[int(np.argmin(np.abs(direction)))], -direction)
        right /= np.linalg.norm(right)
        rotation = np.stack([right, np.cross(-direction, right), -direction])
        translation = -(rotation @ (self._middle + direction * self._range))
        bounds = np.array([-UNBOUNDED, -UNBOUNDED, UNBOUNDED, UNBOUNDED])
        line, points, _, _, px = trace(
            self._solid,
            rotation,
            translation,
            self._intrinsics,
            bounds,
            self._spacing_px,
            self._min_line_px,
        )
        return points, points + 0.05 * self._along[line], px, line


@njit(cache=True)
def _cells(rotations: Floats, translations: Floats, middle: Floats, frame: Floats, step: float) -> Ints:
    """Cell (N, 2) of the direction from the model's middle to the camera: an azimuthal equidistant map."""
    out = np.empty((len(rotations), 2), dtype=np.int64)
    for i in range(len(rotations)):
        turn, move = rotations[i], translations[i]
        centre = np.empty(3)
        for k in range(3):
            centre[k] = -(turn[0, k] * move[0] + turn[1, k] * move[1] + turn[2, k] * move[2]) - middle[k]
        local = frame @ centre
        across = math.hypot(local[0], local[1])
        angle = math.atan2(across, local[2])
        scale = angle / across if across > 0.0 else 0.0
        out[i, 0] = round(local[0] * scale / step)
        out[i, 1] = round(local[1] * scale / step)
    return out
