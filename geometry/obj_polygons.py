"""Faces of an OBJ file as readers take them: counted from the file's beginning, and none of them concave.

Readers cut polygons into fans, which is wrong for concave ones, and take `-1`, the last point so far, for the
last one of the file, which is wrong where points and faces take turns. Its lines (`l`) they leave out: these
are the model where there is no face.
"""

import re
from itertools import pairwise

import numpy as np

from geometry.errors import GeometryError
from geometry.polygon import MOST_CORNERS, to_cut, triangulate
from numerics.arrays import Floats, Ints

COMMENT = re.compile("#.*")
LINE, FACE = re.compile(r"(?m)^\s*l\s"), re.compile(r"(?m)^\s*f\s")
NO_SUCH_POINT = "a face or line names a point that the file does not have"


def cut_polygons(text: str) -> str:
    """An OBJ file's text with its concave faces, and those of many corners, cut into triangles.

    Comments go, and words are one space apart: the reader of the text takes neither comments after a face
    nor tabs. Indices that count back are counted from one. What cannot be cut, as a face whose sides cross,
    or is no face at all, stays as it is.

    Raises
    ------
    GeometryError : a face of more than MOST_CORNERS corners, or of a point 0; no point at all.
    """
    lines = _rows(text)
    points: list[list[str]] = []
    so_far = dict.fromkeys(("v", "vt", "vn"), 0)
    polygons: dict[int, tuple[list[str], list[int]]] = {}
    for number, written in enumerate(lines):
        words = written.split()
        if words[:1] == ["f"] and "-" in written:
            words = ["f", *(_from_one(word, so_far) for word in words[1:])]
        elif words and words[0] in so_far:
            so_far[words[0]] += 1
        line = lines[number] = " ".join(words)
        if words[:1] == ["v"]:
            points.append(words[1:4])
        elif words[:1] == ["f"] and " 0" in line and any(word.split("/")[0] == "0" for word in words):
            raise GeometryError(f"line {number + 1}: a face names point 0; the first is 1")
        elif words[:1] == ["f"] and len(words) > 4:
            if len(words) - 1 > MOST_CORNERS:
                raise GeometryError(f"line {number + 1}: a face has at most {MOST_CORNERS} corners")
            polygons[number] = words[1:], [int(word.split("/")[0]) - 1 for word in words[1:]]
    if not points:
        raise GeometryError("it is not an OBJ file: none of its lines is a point (v X Y Z)")
    if polygons:
        vertices = np.array(points, dtype=np.float64)
        cut = to_cut(vertices, [np.array(corners) for _, corners in polygons.values()])
        for number in np.array(list(polygons))[cut].tolist():
            words, corners = polygons[number]
            try:
                triangles = triangulate(vertices[corners])
            except GeometryError:
                continue
            lines[number] = "\n".join(" ".join(["f", *(words[k] for k in t)]) for t in triangles)
    return "\n".join(lines) + "\n"


def lines_alone(text: str) -> tuple[Floats, Ints]:
    """Points (V, 3) of an OBJ file's text, and the lines (L, 2) between them; none where it has faces.

    Raises
    ------
    GeometryError : what is no number, or a point that the file does not have.
    """
    points, lines = list[list[float]](), list[tuple[int, int]]()
    if FACE.search(text) or not LINE.search(text):
        return np.empty((0, 3)), np.empty((0, 2), dtype=np.int64)
    for number, row in enumerate(_rows(text), 1):
        kind, *words = row.split() or [""]
        try:
            if kind == "v":
                points.append([float(word) for word in words[:3]])
            elif kind == "l":
                named = [int(word.split("/")[0]) for word in words]
                along = [name - 1 if name >= 0 else len(points) + name for name in named]
                lines += [ends for ends in pairwise(along) if ends[0] != ends[1]]
        except ValueError as error:
            raise GeometryError(f"line {number}: not all of it are numbers") from error
    if any(not 0 <= end < len(points) for ends in lines for end in ends):
        raise GeometryError(NO_SUCH_POINT)
    return np.array(points, dtype=np.float64), np.array(lines, dtype=np.int64).reshape(-1, 2)


def _rows(text: str) -> list[str]:
    """Its lines without comments; one that goes on in the next is one with it."""
    return COMMENT.sub("", text).replace("\\\n", " ").splitlines()


def _from_one(word: str, so_far: dict[str, int]) -> str:
    """`-1/-2/3` of a face, in its lists of points, texture points and normals, counted from one."""
    places = []
    for index, count in zip(word.split("/"), so_far.values(), strict=False):
        back = index.startswith("-")
        place = count + 1 + int(index) if back else index
        if back and int(place) < 1:
            raise GeometryError(NO_SUCH_POINT)
        places.append(str(place))
    return "/".join(places)
