"""STL files, binary or text, as bytes that a plain reader understands."""

from __future__ import annotations

import struct

from geometry.errors import GeometryError

HEADER, TRIANGLE = 84, 50  # bytes of a binary file: its head with the count, and each triangle


def checked_stl(content: bytes) -> bytes:
    """A whole binary STL without what follows its triangles, or a text one whose letters are all plain.

    Raises
    ------
    GeometryError : neither; a binary one that is cut short says by how much.
    """
    count = struct.unpack_from("<I", content, HEADER - 4)[0] if len(content) >= HEADER else 0
    whole = HEADER + TRIANGLE * count
    if len(content) == whole:
        return content
    if content.lstrip()[:5].lower() == b"solid" or not content.strip():
        return content.decode("utf-8", "replace").encode("ascii", "replace")
    if count > 0 and whole < len(content):
        return content[:whole]
    raise GeometryError(
        f"it is no text, and of its {len(content)} bytes no binary STL: {count} triangles, as it says, take "
        f"{whole}; perhaps it was cut short"
    )
