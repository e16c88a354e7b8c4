"""ViSP's .cao model files, version 1."""

import re
from pathlib import Path
from typing import NoReturn

import numpy as np

from geometry.cao_parts import WELD_SHARE, Part, moved, united
from geometry.errors import GeometryError
from geometry.polygon import triangulate
from geometry.pose import Pose
from geometry.surface import Surface
from geometry.text_files import text_of
from numerics.arrays import Floats, Ints

ONE_SURFACE_DEG = 1.0  # adjacent faces that bend less are one surface cut in pieces (by hand)
ROUND_SIDES = 36  # of a tessellated cylinder or circle, by hand: a side is 0.004 radii beside the arc

COMMENT = re.compile(r"(#|//).*")
ATTRIBUTE = re.compile(r"\w+\s*=\s*(\"[^\"]*\"|'[^']*'|\S+)")  # name="front", useLod=1, …


def read_cao(path: Path) -> Surface:
    """Read points, lines, faces from lines, faces from points, cylinders and circles.

    Comments (`#`, `//`), attributes (`name=…`) and missing last sections are allowed. A cylinder is its
    lateral surface, a circle a disc; both are tessellated, so that a cylinder with two circles closes. Files
    that it loads are parts of it.

    Raises
    ------
    GeometryError : with file and line of what is wrong.
    """
    return united([moved(_read_alone(reader), pose) for reader, pose in _readers(path)])


def files_of_cao(path: Path) -> list[Path]:
    """A .cao file, and those that it or one of these loads, each once; raises as `read_cao`."""
    return list(dict.fromkeys(reader.path for reader, _ in _readers(path)))


def _readers(path: Path) -> list[tuple["_Reader", Pose]]:
    """Of the file itself, and of all that it and its parts load, with their poses in its frame.

    Raises
    ------
    GeometryError : a part is not beside the file or below, cannot be read, or loads a file that loads it.
    """
    folder, readers = path.parent.resolve(), list[tuple[_Reader, Pose]]()

    def add(part: Part, above: tuple[Path, ...]) -> None:
        reader = _Reader(part.file)
        readers.append((reader, part.pose))
        for row, line in reader.loads:
            where = f"{part.file}:{row}"
            try:
                loaded = Part.told(line, part.file.parent)
            except GeometryError as error:
                raise GeometryError(f"{where}: {error}") from None
            real = loaded.file.resolve()
            if not real.is_relative_to(folder):
                raise GeometryError(f"{where}: {loaded.file} is not beside {path} or below. Copy it there")
            if real in above:
                raise GeometryError(f"{where}: {loaded.file} loads itself")
            if not real.is_file():
                raise GeometryError(f"{where}: there is no file {loaded.file}")
            add(Part(loaded.file, part.pose.compose(loaded.pose)), (*above, real))

    add(Part(path, Pose(np.zeros(3), np.zeros(3))), (path.resolve(),))
    return readers


def _read_alone(reader: "_Reader") -> Surface:
    """What a file says itself."""
    reader.version()
    points = reader.points()
    vertices = np.array(points, dtype=np.float64).reshape(-1, 3)
    lines = [reader.pair(len(points)) for _ in range(reader.count("3D lines"))]
    faces = [reader.face_of_lines(lines, vertices) for _ in range(reader.count("faces from 3D lines"))]
    faces += [reader.face_of_points(vertices) for _ in range(reader.count("faces from 3D points"))]
    shape = _Shape(vertices, faces)
    for _ in range(reader.count("3D cylinders")):
        start, end = reader.pair(len(points))
        shape.cylinder(vertices[start], vertices[end], reader.positive("a radius"))
    for _ in range(reader.count("3D circles")):
        radius = reader.positive("a radius")
        centre, first, second = (vertices[reader.index(len(points), "point")] for _ in range(3))
        normal = np.cross(first - centre, second - centre)
        if not np.linalg.norm(normal) > 0:
            reader.fail("the three points of a circle are on one line")
        shape.disc(centre, normal, radius)
    reader.end()
    return Surface(
        vertices=shape.vertices,
        faces=shape.faces,
        groups=np.array(shape.groups, dtype=np.int64),
        drawn=np.array(lines, dtype=np.int64).reshape(-1, 2),
        flat_deg=ONE_SURFACE_DEG,
        sharp_deg=ONE_SURFACE_DEG,
    )


class _Reader:
    """Tokens of a file, each with its line, and the lines after its version that load others."""

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            text = text_of(path)
        except OSError as error:
            raise GeometryError(f"model {path} cannot be read: {error.strerror}") from error
        self.tokens: list[tuple[str, int]] = []
        self.loads: list[tuple[int, str]] = []
        for row, line in enumerate(text.splitlines(), start=1):
            bare = COMMENT.sub("", line)
            if len(self.tokens) == 1 and bare.lstrip().lower().startswith("load"):
                self.loads.append((row, bare))
            else:
                self.tokens += [(token, row) for token in ATTRIBUTE.sub(" ", bare).split()]
        self.position = 0
        # said in place of what fails: points end before their count does
        self.broken: tuple[int, str] | None = None

    def fail(self, what: str) -> NoReturn:
        if self.broken is not None:
            at, what = self.broken
            raise GeometryError(f"{self.path}:{at}: {what}")
        at = self.tokens[min(self.position, len(self.tokens)) - 1][1] if self.tokens else 1
        raise GeometryError(f"{self.path}:{at}: {what}")

    def token(self, what: str) -> str:
        if self.position >= len(self.tokens):
            self.fail(f"the file ends where {what} should be")
        token = self.tokens[self.position][0]
        self.position += 1
        return token

    def version(self) -> None:
        token = self.token("the version V1")
        if token.upper() != "V1":
            self.fail(f"a .cao file starts with V1, found {token!r}; only version 1 is read")

    def number(self, what: str) -> float:
        token = self.token(what)
        try:
            value = float(token)
        except ValueError:
            value = float("nan")
        if not np.isfinite(value):
            self.fail(f"{token!r} is not {what}")
        return value

    def points(self) -> list[list[float]]:
        """The first section. A point that is not in one line is likelier what follows the last one."""
        count = self.count("3D points")
        said_at = self.tokens[self.position - 1][1]
        rows = [at for _, at in self.tokens[self.position : self.position + 3 * count]]
        whole = [len(set(rows[first : first + 3])) == 1 for first in range(0, len(rows), 3)]
        if False in whole[1:] and whole[0]:
            there = whole.index(False)
            what = f"{count} 3D points are said, and {there} stand in a line each; is the count too large?"
            self.broken = said_at, what
        return [[self.number("a coordinate") for _ in range(3)] for _ in range(count)]

    def positive(self, what: str) -> float:
        value = self.number(what)
        if not value > 0:
            self.fail(f"{what} must be positive, found {value:g}")
        return value

    def whole(self, what: str) -> int:
        token = self.token(what)
        if not token.isdecimal():
            self.fail(f"{token!r} is not {what}")
        return int(token)

    def count(self, section: str) -> int:
        """The number of entries of a section; 0 when the file has ended."""
        if self.position >= len(self.tokens):
            return 0
        return self.whole(f"the number of {section}")

    def index(self, size: int, kind: str) -> int:
        value = self.whole(f"the index of a {kind}")
        if value >= size:
            self.fail(f"there is no {kind} {value}; the file has {size}, counted from 0")
        return value

    def pair(self, size: int) -> tuple[int, int]:
        a, b = self.index(size, "point"), self.index(size, "point")
        if a == b:
            self.fail(f"both ends are point {a}")
        return a, b

    def face_of_points(self, vertices: Floats) -> Ints:
        corners = [self.index(len(vertices), "point") for _ in range(self.whole("a number of points"))]
        return self._checked(corners, vertices)

    def face_of_lines(self, lines: list[tuple[int, int]], vertices: Floats) -> Ints:
        sides = [lines[self.index(len(lines), "line")] for _ in range(self.whole("a number of lines"))]
        if len(sides) < 3:
            self.fail(f"a face needs at least 3 lines, found {len(sides)}")
        chain = [*sides[0]] if sides[0][1] in sides[1] else [*sides[0]][::-1]
        for side in sides[1:]:
            if chain[-1] not in side:
                self.fail("the lines of a face do not follow each other end to end")
            chain.append(side[0] if side[1] == chain[-1] else side[1])
        if chain[0] != chain[-1]:
            self.fail("the lines of a face do not close")
        return self._checked(chain[:-1], vertices)

    def _checked(self, corners: list[int], vertices: Floats) -> Ints:
        if len(set(corners)) < len(corners):
            self.fail("a face has the same point twice")
        face = np.array(corners, dtype=np.int64)
        try:
            triangulate(vertices[face])
        except GeometryError as error:
            self.fail(str(error))
        return face

    def end(self) -> None:
        if self.position < len(self.tokens):
            self.position += 1
            self.fail(f"{self.tokens[self.position - 1][0]!r} after the last section; is a count too small?")


class _Shape:
    """Vertices and faces that grow by round parts; those share vertices where they meet."""

    def __init__(self, vertices: Floats, faces: list[Ints]) -> None:
        self.vertices = vertices
        self.faces = list(faces)
        self.groups = [-1] * len(faces)

    def _ring(self, centre: Floats, normal: Floats, radius: float) -> list[int]:
        axis = normal / np.linalg.norm(normal)
        if axis[int(np.argmax(np.abs(axis)))] < 0:
            axis = -axis  # the same phase whichever way the axis points, so that rings meet
        first = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
        first /= np.linalg.norm(first)
        second = np.cross(axis, first)
        angles = np.arange(ROUND_SIDES) * 2 * np.pi / ROUND_SIDES
        points = centre + radius * (np.outer(np.cos(angles), first) + np.outer(np.sin(angles), second))
        return [self._welded(point) for point in points]

    def _welded(self, point: Floats) -> int:
        near = np.abs(self.vertices - point).max(axis=1)
        closest = int(np.argmin(near))
        if near[closest] <= WELD_SHARE * np.abs(self.vertices).max():
            return closest
        self.vertices = np.vstack([self.vertices, point])
        return len(self.vertices) - 1

    def cylinder(self, start: Floats, end: Floats, radius: float) -> None:
        group = max(self.groups, default=-1) + 1
        lower, upper = self._ring(start, end - start, radius), self._ring(end, end - start, radius)
        for i in range(ROUND_SIDES):
            j = (i + 1) % ROUND_SIDES
            self.faces.append(np.array([lower[i], lower[j], upper[j], upper[i]]))
            self.groups.append(group)

    def disc(self, centre: Floats, normal: Floats, radius: float) -> None:
        self.faces.append(np.array(self._ring(centre, normal, radius)))
        self.groups.append(-1)
