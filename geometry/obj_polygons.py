"""Faces of an OBJ file as readers take them: counted from the file's beginning, and none of them concave.

Readers cut polygons into fans, which is wrong for concave ones, and take `-1`, the last point so far, for the
last one of the file, which is wrong where points and faces take turns.
"""

import re

import numpy as np

from geometry.errors import GeometryError
from geometry.polygon import MOST_CORNERS, to_cut, triangulate

COMMENT = re.compile("#.*")
NO_SUCH_POINT = "a face names a point that the file does not have"


def cut_polygons(text: str) -> str:
    """An OBJ file's text with its concave faces, and those of many corners, cut into triangles.

    Comments go, and words are one space apart: the reader of the text takes neither comments after a face
    nor tabs. Indices that count back are counted from one. What cannot be cut, as a face whose sides cross,
    or is no face at all, stays as it is.

    Raises
    ------
    GeometryError : a face of more than MOST_CORNERS corners, or of a point 0; no point at all.
    """
    lines = COMMENT.sub("", text).replace("\\\n", " ").splitlines()
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
