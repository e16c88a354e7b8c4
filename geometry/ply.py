"""PLY files, text or binary: their points, and their faces as polygons of any number of corners."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from geometry.errors import GeometryError
from geometry.polygon import MOST_CORNERS, as_triangles
from numerics.arrays import Floats, Ints

TYPES = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
CORNERS = ("vertex_indices", "vertex_index")
COORDINATES = ("x", "y", "z")
LONGEST_HEADER = 100_000  # bytes


class Property(NamedTuple):
    """A number of each row of an element; with ``count_type`` a list of them."""

    name: str
    type: str
    count_type: str | None = None


class Element(NamedTuple):
    """Rows of a PLY file: its points, its faces, or anything else."""

    name: str
    rows: int
    properties: list[Property]


def read_ply(path: Path, most_faces: int) -> tuple[Floats, Ints]:
    """Points (V, 3) and triangles (T, 3) of a PLY file; concave faces are cut as they are, not into fans.

    Raises
    ------
    GeometryError : what is no PLY file of points and faces; a point that is not finite; more than
        ``most_faces``.
    """
    content = path.read_bytes()
    head, end = _header(content)
    order, elements = _elements(head)
    text = content[end:].split() if order == "" else None
    points, faces, at = np.empty((0, 3)), [], 0 if text is not None else end
    for element in elements:
        if element.name == "face":
            must_be_few(element.rows, most_faces)
        try:
            if text is not None:
                rows, at = _text_rows(text, at, element)
            else:
                rows, at = _binary_rows(content, at, element, order)
        except GeometryError:
            raise
        except (ValueError, IndexError, OverflowError) as error:
            raise GeometryError(f"its {element.name} rows are cut short or no numbers") from error
        if element.name == "vertex":
            points = _points(rows)
        elif element.name == "face":
            faces = _faces(rows)
    if not np.isfinite(points).all():
        raise GeometryError("it has a point that is not finite")
    for number, face in enumerate(faces):
        if face.min() < 0 or face.max() >= len(points):
            raise GeometryError(f"face {number} names a point that is not there")
    return points, as_triangles(points, faces)


def must_be_few(triangles: int, most: int) -> None:
    """Raise GeometryError, with what to do, when a mesh has more triangles than are read."""
    if triangles > most:
        raise GeometryError(
            f"it has {triangles} triangles, and at most {most} are read. Export it with a coarser tolerance "
            "(0.1 % of its size will do), or simplify it"
        )


def _header(content: bytes) -> tuple[list[list[str]], int]:
    """The words of its lines, and where it ends."""
    end = content.find(b"end_header", 0, LONGEST_HEADER)
    start = content.find(b"\n", end) + 1
    if not content.startswith(b"ply") or end < 0 or start == 0:
        raise GeometryError("it does not begin as a PLY file does")
    return [line.split() for line in content[:end].decode("ascii", "replace").splitlines()[1:]], start


def _elements(head: list[list[str]]) -> tuple[str, list[Element]]:
    """Byte order, empty for text, and what the file holds, in order."""
    order, found = None, list[Element]()
    for words in head:
        try:
            if words[:1] == ["format"]:
                order = ORDERS[words[1]]
            elif words[:1] == ["element"]:
                found.append(Element(words[1], int(words[2]), []))
            elif words[:2] == ["property", "list"]:
                found[-1].properties.append(Property(words[4], TYPES[words[3]], TYPES[words[2]]))
            elif words[:1] == ["property"]:
                found[-1].properties.append(Property(words[2], TYPES[words[1]]))
        except (KeyError, ValueError, IndexError) as error:
            raise GeometryError(f"its header's line {' '.join(words)!r} cannot be read") from error
    if order is None or any(element.rows < 0 for element in found):
        raise GeometryError("its header says no format, or less than no rows")
    return order, found


Columns = dict[str, Floats | list[Floats]]


def _text_rows(words: list[bytes], at: int, element: Element) -> tuple[Columns, int]:
    """The columns of an element from the word ``at`` on, lists of their own length; where it ends."""
    names, width = [one.name for one in element.properties], len(element.properties)
    if not any(one.count_type for one in element.properties):
        end = at + element.rows * width
        table = np.array(words[at:end], dtype=np.float64).reshape(element.rows, width)
        return dict(zip(names, table.T, strict=True)), end
    out: dict[str, list[Floats]] = {name: [] for name in names}
    for _ in range(element.rows):
        for one in element.properties:
            count = 1
            if one.count_type:
                count, at = _counted(float(words[at])), at + 1
            if at + count > len(words):
                raise ValueError
            out[one.name].append(np.array(words[at : at + count], dtype=np.float64))
            at += count
    return dict(out), at


def _binary_rows(content: bytes, at: int, element: Element, order: str) -> tuple[Columns, int]:
    """`_text_rows` from the byte ``at`` on."""
    if not any(one.count_type for one in element.properties):
        kind = np.dtype([(one.name, order + one.type) for one in element.properties])
        table = np.frombuffer(content, kind, element.rows, at)
        return {name: table[name].astype(np.float64) for name in kind.names or ()}, at + table.nbytes
    out: dict[str, list[Floats]] = {one.name: [] for one in element.properties}
    kinds = [
        (out[one.name], np.dtype(order + one.type), one.count_type and np.dtype(order + one.count_type))
        for one in element.properties
    ]
    for _ in range(element.rows):
        for column, kind, count_kind in kinds:
            count = 1
            if count_kind:
                count = _counted(float(np.frombuffer(content, count_kind, 1, at)[0]))
                at += count_kind.itemsize
            column.append(np.frombuffer(content, kind, count, at).astype(np.float64))
            at += count * kind.itemsize
    return dict(out), at


def _counted(number: float) -> int:
    if number != int(number) or number < 0:
        raise ValueError
    if number > MOST_CORNERS:
        raise GeometryError(f"a face has at most {MOST_CORNERS} corners")
    return int(number)


def _points(rows: Columns) -> Floats:
    if not all(name in rows for name in COORDINATES):
        raise GeometryError("its points have no x, y and z")
    return np.column_stack([np.asarray(rows[name], dtype=np.float64) for name in COORDINATES])


def _faces(rows: Columns) -> list[Ints]:
    """Corners of the faces that have three or more."""
    name = next((name for name in CORNERS if name in rows), None)
    if name is None:
        raise GeometryError(f"its faces have no list {CORNERS[0]}")
    return [np.asarray(face, dtype=np.int64) for face in rows[name] if len(face) >= 3]
