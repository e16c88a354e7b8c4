"""What is seen of a target from all over the sphere: points of its lines, of which templates are made."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from geometry.camera import Camera
from geometry.model import Model
from numerics.arrays import Floats, Ints
from vision_server.matching.match import Anywhere
from vision_server.matching.views import Views, frame_towards

LOOK_DIRECTIONS = 320  # on the sphere, 11 degrees apart; time is in proportion to it and to points (by hand)
LOOK_POINTS = 64  # of a look
TARGET_CELLS_ACROSS = 40  # of the largest target of a grid


class Look(NamedTuple):
    """Some points of the visible lines from one direction, evenly along their image length.

    Attributes
    ----------
    points, along : (N, 3), at most LOOK_POINTS: about the target's middle, and the lines' directions there,
        in the camera's axes, metres.
    length : of all visible lines in the image, cells.
    """

    points: Floats
    along: Floats
    length: float


@dataclass(frozen=True, eq=False)
class Looks:
    """What is seen of a target from directions all around, from one distance of its middle, metres.

    Attributes
    ----------
    frames : (V, 3, 3), target to camera axes, one for each direction.
    seen : what is seen from each direction.
    """

    distance: float
    frames: Floats
    seen: list[Look]


def directions_on_sphere(count: int) -> Floats:
    """Unit vectors (N, 3), evenly: a Fibonacci lattice."""
    number = np.arange(count) + 0.5
    height = 1.0 - 2.0 * number / count
    turn = math.pi * (3.0 - math.sqrt(5.0)) * number
    across = np.sqrt(1.0 - height**2)
    return np.column_stack([across * np.cos(turn), across * np.sin(turn), height])


def directions_of(anywhere: Anywhere) -> Floats:
    """The directions (V, 3) from which the target may be seen, in its frame."""
    directions = directions_on_sphere(LOOK_DIRECTIONS)
    seen: Floats = directions[anywhere.sees(directions)]
    return seen


def looks_of(views: Views, model: Model, distance: float, directions: Floats, cell_px: float) -> Looks:
    """The target from directions (V, 3), unit, in its frame, at a distance of its middle.

    ``cell_px`` is the width of a grid's cells in the image of the views.
    """
    frames = np.array([frame_towards(-one) for one in directions])
    translations = np.array([0.0, 0.0, distance]) - frames @ model.middle
    numbers = views.of(frames, translations)
    table = views.table()
    seen = []
    for frame, number in zip(frames, numbers.tolist(), strict=True):
        runs = slice(table.first[number], table.first[number + 1])
        first = table.run[runs.start : runs.stop + 1]
        px = table.px[first[0] : first[-1]]
        some = evenly(px, LOOK_POINTS)
        steps = np.diff(table.ends[runs], axis=1)[np.searchsorted(first, first[0] + some, "right") - 1, 0]
        along = steps / np.linalg.norm(steps, axis=1, keepdims=True)
        points = table.points[first[0] : first[-1]][some] - model.middle
        seen.append(Look(points @ frame.T, along @ frame.T, float(px.sum()) / cell_px))
    return Looks(distance, frames, seen)


def evenly(px: Floats, most: int) -> Ints:
    """Indices of at most so many samples, evenly along the image length (N,) they stand for."""
    if len(px) == 0:
        return np.empty(0, np.int64)
    ends = np.cumsum(px)
    kept = min(most, len(px))
    return np.unique(np.searchsorted(ends, (np.arange(kept) + 0.5) * ends[-1] / kept))


def cell_px_of(sizes: Floats) -> float:
    """Width, px, of the cells of a grid that sizes (S,), px, share."""
    return float(sizes[0]) / TARGET_CELLS_ACROSS


def range_of(model: Model, camera: Camera, size_px: float) -> float:
    """How far the middle of a target is that is so wide in the image, metres."""
    return model.diameter * camera.fx / size_px
