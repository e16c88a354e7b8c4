"""STL files, binary or text, as bytes that a plain reader understands."""

from __future__ import annotations

import struct

from geometry.errors import GeometryError

HEADER, TRIANGLE = 84, 50  # bytes of a binary file: its head with the count, and each triangle
STEP = b"ISO-10303-21"  # what such a file begins with


def checked_stl(content: bytes) -> bytes:
    """A whole binary STL without what follows its triangles, or a text one whose letters are all plain.

    Raises
    ------
    GeometryError : neither, or empty; a binary one that is cut short says by how much.
    """
    if not content.strip():
        raise GeometryError("it is empty")
    if content.startswith(STEP):
        raise GeometryError("it is a STEP file; export STL from the CAD program")
    count = struct.unpack_from("<I", content, HEADER - 4)[0] if len(content) >= HEADER else 0
    whole = HEADER + TRIANGLE * count
    if len(content) == whole:
        return content
    if content.lstrip()[:5].lower() == b"solid":
        return content.decode("utf-8", "replace").encode("ascii", "replace")
    if count > 0 and whole < len(content):
        return content[:whole]
    if count == 0:
        raise GeometryError("it is no STL file: it neither begins with `solid` nor counts triangles")
    raise GeometryError(
        f"it was cut short, or is no STL file: of the {whole} bytes that its {count} triangles take it has "
        f"{len(content)}"
    )
