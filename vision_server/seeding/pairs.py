"""Pairs of points, read from words or a file, and whether they can tell a pose."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bridge.errors import BadInput
from geometry.camera import Camera
from geometry.model import UNITS_M, Model
from numerics.arrays import Floats

FEWEST = 3  # six unknowns, two numbers of each
MOST = 1000  # more than anybody clicks
# Chosen by hand where nothing else is said.
THIN = 0.01  # of the model's size: points nearer than this to one line leave the turn about it open
THIN_PX = 2.0  # the same in the image: about what a click is off by


@dataclass(frozen=True, eq=False)
class Pairs:
    """Where points of the model are in the image.

    Attributes
    ----------
    pixels : (N, 2) float64, px, as the lens shows them.
    points : (N, 3) float64, target frame, metres.
    """

    pixels: Floats
    points: Floats


def parsed_pairs(lines: Sequence[str], unit: str = "m") -> Pairs:
    """Pairs of lines like ``u,v x,y,z``: px, then the model file's coordinates in its unit.

    Raises
    ------
    BadInput
        A line that is not five finite numbers.
    """
    rows = []
    for line in lines:
        try:
            row = [float(word) for word in re.split(r"[\s,;]+", line.strip())]
        except ValueError:
            row = []
        if len(row) != 5:
            raise BadInput(f"{line.strip()[:80]!r} is not a pair.", "Write u,v x,y,z: px, then the model's.")
        if not np.isfinite(row).all():
            raise BadInput(f"The pair {line.strip()[:80]!r} has a number that is not finite.")
        rows.append(row)
    numbers = np.array(rows, dtype=np.float64).reshape(-1, 5)
    return Pairs(numbers[:, :2], UNITS_M.get(unit, 1.0) * numbers[:, 2:])


def read_lines(path: Path) -> list[str]:
    """Lines of a file of pairs, without empty ones and what stands behind ``#``; BadInput if unreadable."""
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise BadInput(f"Cannot read {path}: {error.strerror}.", "Check the path.") from error
    except UnicodeDecodeError as error:
        raise BadInput(f"{path} is not a text file.", "Give one pair a line: u,v x,y,z.") from error
    return [kept for line in text.splitlines() if (kept := line.partition("#")[0].strip())]


def must_tell_a_pose(pairs: Pairs, model: Model, camera: Camera) -> None:
    """Look at whether pairs can tell a pose.

    Raises
    ------
    BadInput
        Too few or too many, outside of the image, far from the model, or all on one line.
    """
    count = len(pairs.points)
    if count < FEWEST:
        raise BadInput(f"{count} of at least {FEWEST} pairs are given.", "A fourth makes it sure.")
    if count > MOST:
        raise BadInput(f"{count} pairs are more than {MOST}.")
    beyond = (pairs.pixels < -0.5) | (pairs.pixels > [camera.width - 0.5, camera.height - 0.5])
    for number in np.flatnonzero(beyond.any(axis=1)):
        u, v = pairs.pixels[number]
        size = f"{camera.width}x{camera.height}"
        raise BadInput(
            f"Pair {number + 1}: ({u:g}, {v:g}) is outside of the image of {size} px.",
            "Correct it, or leave it out.",
        )
    low, high = model.vertices.min(axis=0) - model.diameter, model.vertices.max(axis=0) + model.diameter
    for number in np.flatnonzero(((pairs.points < low) | (pairs.points > high)).any(axis=1)):
        place = ", ".join(f"{value:g}" for value in pairs.points[number])
        raise BadInput(
            f"Pair {number + 1}: ({place}) m is far from the model, which is {model.diameter:.3g} m across.",
            "Points are of the model file's unit (--unit).",
        )
    if _width(pairs.points[list(wide_triple(pairs.points))]) < THIN * model.diameter:
        raise BadInput("The points of the model lie on one line.", "Give one beside it.")
    if _width(pairs.pixels[list(wide_triple(pairs.pixels))]) < THIN_PX:
        raise BadInput("The points of the image lie on one line.", "Give one beside it.")


def wide_triple(points: Floats) -> tuple[int, int, int]:
    """Three of points (N, 2) or (N, 3), N >= 3, that are far apart: two, and one far from their line."""
    first = int(np.linalg.norm(points - points.mean(axis=0), axis=1).argmax())
    second = int(np.linalg.norm(points - points[first], axis=1).argmax())
    third = int(_off_line(points, points[first], points[second]).argmax())
    return first, second, third


def _width(triple: Floats) -> float:
    """Distance of the third of three points from the line through the others."""
    return float(_off_line(triple[2:], triple[0], triple[1])[0])


def _off_line(points: Floats, start: Floats, end: Floats) -> Floats:
    along = end - start
    along = along / max(float(np.linalg.norm(along)), np.finfo(float).tiny)
    offset = points - start
    return np.asarray(np.linalg.norm(offset - (offset @ along)[:, None] * along, axis=1))
