"""The parts of a .cao file: others that it loads, each moved and turned."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from geometry.errors import GeometryError
from geometry.pose import Pose
from geometry.surface import Surface
from numerics.arrays import Ints

LOAD = re.compile(r'\s*load\s*\(\s*"([^"]+)"\s*((?:,[^,]*)*)\)\s*', re.IGNORECASE)
PLACED = re.compile(r"\s*(tu?)\s*=\s*\[([^\[\]]*)\]\s*")
ANGLE = re.compile(r"(.*?)\s*(deg|rad|)", re.DOTALL)
WELD_SHARE = 1e-9  # points of parts, or round ones, closer than this fraction of the model's size are one


@dataclass(frozen=True)
class Part:
    """A file that another one loads, and where it is in that one's frame."""

    file: Path
    pose: Pose

    @classmethod
    def told(cls, line: str, folder: Path) -> "Part":
        """The part of a line `load("FILE", t=[X; Y; Z], tu=[X; Y; Z])` in a file of this folder.

        `t` is in the unit of the file, `tu` the rotation vector, in radians or, of numbers that end in
        `deg`, degrees; both may be left out.

        Raises
        ------
        GeometryError : the line is not of this form.
        """
        found = LOAD.fullmatch(line)
        if found is None:
            raise GeometryError(f'{line.strip()!r} is not load("FILE.cao", t=[X; Y; Z], tu=[X; Y; Z])')
        placed = {"t": np.zeros(3), "tu": np.zeros(3)}
        for words in found[2].split(",")[1:]:
            one = PLACED.fullmatch(words)
            numbers = [] if one is None else one[2].split(";")
            try:
                if one is None or len(numbers) != 3:
                    raise ValueError
                placed[one[1]] = np.array([_number(number, angle=one[1] == "tu") for number in numbers])
            except ValueError:
                raise GeometryError(f"{words.strip()!r} is neither t=[X; Y; Z] nor tu=[X; Y; Z]") from None
        return cls(folder / found[1], Pose(placed["tu"], placed["t"]))


def _number(word: str, angle: bool) -> float:
    if not angle:
        return float(word)
    found = ANGLE.fullmatch(word.strip())
    assert found is not None  # anything matches
    return float(np.radians(float(found[1])) if found[2] == "deg" else float(found[1]))


def moved(surface: Surface, pose: Pose) -> Surface:
    """A surface in the frame in which it has this pose."""
    if not (pose.rotation_vector.any() or pose.translation.any()):
        return surface
    return replace(surface, vertices=pose.apply(surface.vertices))


def united(surfaces: Sequence[Surface]) -> Surface:
    """Several surfaces as one; points of them that are at one place are one."""
    if len(surfaces) == 1:
        return surfaces[0]
    points = np.concatenate([surface.vertices for surface in surfaces])
    cell = WELD_SHARE * float(np.abs(points).max(initial=0.0)) or 1.0
    _, first, which = np.unique(np.rint(points / cell), axis=0, return_index=True, return_inverse=True)
    number = which.reshape(-1)
    begin = np.cumsum([0, *(len(surface.vertices) for surface in surfaces)])
    faces: list[Ints] = []
    groups, drawn = [np.empty(0, dtype=np.int64)], [np.empty((0, 2), dtype=np.int64)]
    for surface, start in zip(surfaces, begin, strict=False):
        faces += [number[start + face] for face in surface.faces]
        above = 1 + max(int(group.max(initial=-1)) for group in groups)
        groups.append(np.where(surface.groups >= 0, surface.groups + above, -1))
        drawn.append(number[start + surface.drawn])
    return replace(
        surfaces[0],
        vertices=points[first],
        faces=faces,
        groups=np.concatenate(groups),
        drawn=np.concatenate(drawn),
    )
