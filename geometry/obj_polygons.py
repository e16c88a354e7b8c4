"""Polygons of an OBJ file as triangles: readers cut them into fans, which is wrong for concave ones."""

import numpy as np
from numpy.typing import NDArray

from geometry.errors import GeometryError
from geometry.polygon import area_vectors, triangulate

Array = NDArray[np.float64]

SOME_CORNERS = 8  # a fan of more has slivers, between which rays are slow to find
MOST_CORNERS = 10_000  # of one face: its triangles take seconds to find


def cut_polygons(text: str) -> str:
    """An OBJ file's text with its concave faces, and those of many corners, cut into triangles.

    What cannot be cut, as a face whose sides cross, or is no face at all, stays as it is.

    Raises
    ------
    GeometryError : a face of more than MOST_CORNERS corners.
    """
    lines = text.replace("\\\n", " ").splitlines()
    points: list[list[str]] = []
    polygons: dict[int, tuple[list[str], list[int]]] = {}
    for number, line in enumerate(lines):
        words = line.split("#")[0].split()
        if words[:1] == ["v"]:
            points.append(words[1:4])
        elif words[:1] == ["f"] and len(words) > 4:
            if len(words) - 1 > MOST_CORNERS:
                raise GeometryError(f"line {number + 1}: a face has at most {MOST_CORNERS} corners")
            polygons[number] = words[1:], _corners(words[1:], len(points))
    if polygons:
        vertices = np.array(points, dtype=np.float64)
        for number in _to_cut(vertices, polygons):
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


def _to_cut(vertices: Array, polygons: dict[int, tuple[list[str], list[int]]]) -> list[int]:
    """Numbers of the polygons that are concave or have many corners."""
    faces = [np.array(corners) for _, corners in polygons.values()]
    normals = area_vectors(vertices, faces)
    counts = np.array([len(face) for face in faces])
    last = np.cumsum(counts) - 1
    corner = np.concatenate(faces)
    following, before = np.arange(1, len(corner) + 1), np.arange(-1, len(corner) - 1)
    following[last] = last - counts + 1
    before[last - counts + 1] = last
    places = vertices[corner]
    bends = np.cross(places - places[before], places[following] - places)
    turned = (bends * np.repeat(normals, counts, axis=0)).sum(axis=1)
    size = np.repeat((normals**2).sum(axis=1), counts)
    concave = np.logical_or.reduceat(turned < -1e-9 * size, last - counts + 1)
    return [number for number, cut in zip(polygons, concave | (counts > SOME_CORNERS), strict=True) if cut]
