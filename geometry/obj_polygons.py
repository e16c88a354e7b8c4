"""Polygons of an OBJ file as triangles: readers cut them into fans, which is wrong for concave ones."""

import numpy as np

from geometry.errors import GeometryError
from geometry.polygon import MOST_CORNERS, to_cut, triangulate


def cut_polygons(text: str) -> str:
    """An OBJ file's text with its concave faces, and those of many corners, cut into triangles.

    What cannot be cut, as a face whose sides cross, or is no face at all, stays as it is.

    Raises
    ------
    GeometryError : a face of more than MOST_CORNERS corners, or of a point 0; no point at all.
    """
    lines = text.replace("\\\n", " ").splitlines()
    points: list[list[str]] = []
    polygons: dict[int, tuple[list[str], list[int]]] = {}
    for number, line in enumerate(lines):
        words = line.split("#")[0].split()
        if words[:1] == ["v"]:
            points.append(words[1:4])
        elif words[:1] == ["f"] and " 0" in line and any(word.split("/")[0] == "0" for word in words):
            raise GeometryError(f"line {number + 1}: a face names point 0; the first is 1")
        elif words[:1] == ["f"] and len(words) > 4:
            if len(words) - 1 > MOST_CORNERS:
                raise GeometryError(f"line {number + 1}: a face has at most {MOST_CORNERS} corners")
            polygons[number] = words[1:], _corners(words[1:], len(points))
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


def _corners(words: list[str], count: int) -> list[int]:
    """Places in the list of points of `7/1/2`, counted from one, or of `-1`, the last of so many so far."""
    indices = [int(word.split("/")[0]) for word in words]
    return [index - 1 if index > 0 else count + index for index in indices]
