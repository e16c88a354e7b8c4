"""STL files, binary or text, as bytes that a plain reader understands."""

from __future__ import annotations

import codecs
import re
import struct

from geometry.errors import GeometryError

HEADER, TRIANGLE = 84, 50  # bytes of a binary file: its head with the count, and each triangle
NO_STL = "it is no STL file: it neither begins with `solid` and goes on as text, nor counts triangles"
STEP = b"ISO-10303-21"  # what such a file begins with
BEGINNING = re.compile(rb"(?m)^\s*solid\b")  # of a text, behind what some programs say of themselves
SOLID = re.compile(rb"solid\b.*")  # or the end of `endsolid`, and a name
CORNER = re.compile(rb"\bvertex\b[^\n]*")
NUMBERS = re.compile(rb"vertex(\s+[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?){3}\s*")  # a decimal comma makes none


def checked_stl(content: bytes) -> bytes:
    """A whole binary STL without what follows its triangles, or a text one without names.

    Raises
    ------
    GeometryError : neither, or empty; one that is cut short, of a binary one by how much.
    """
    if not content.strip():
        raise GeometryError("it is empty")
    if content.startswith(STEP):
        raise GeometryError("it is a STEP file; export STL from the CAD program")
    count = struct.unpack_from("<I", content, HEADER - 4)[0] if len(content) >= HEADER else 0
    whole = HEADER + TRIANGLE * count
    if len(content) == whole:
        return content
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):  # as PowerShell writes text
        content = content.decode("utf-16", "replace").encode()
    if b"\0" not in content[:HEADER]:  # a binary one counts less than 16 million triangles in four bytes
        return _whole_text(content)
    if count > 0 and whole < len(content):
        return content[:whole]
    if count == 0:
        raise GeometryError(NO_STL)
    raise GeometryError(
        f"it was cut short, or is no STL file: of the {whole} bytes that its {count} triangles take it has "
        f"{len(content)}"
    )


def _whole_text(content: bytes) -> bytes:
    """A text STL without names, in which any word may stand.

    Raises
    ------
    GeometryError : it has no solid, or one of them does not end.
    """
    text = b"\n".join(content.removeprefix(codecs.BOM_UTF8).lower().splitlines())
    begin = BEGINNING.search(text)
    if begin is None:
        raise GeometryError(NO_STL)
    text = text[begin.start() :]
    ends = [text.endswith(b"end", 0, found.start()) for found in SOLID.finditer(text)]
    if ends != [False, True] * max(len(ends) // 2, 1):
        raise GeometryError("it was cut short, or is no STL file: a `solid` of its text has no `endsolid`")
    return SOLID.sub(b"solid", text)


def wrong_in_text(content: bytes) -> str:
    """What is wrong with the text of `checked_stl` whose facets are not of three corners of three numbers."""
    for row in CORNER.finditer(content):
        if not NUMBERS.fullmatch(row[0]):
            said = row[0].strip().decode("ascii", "replace")
            return f"its row {said!r} is not of three numbers with decimal points"
    return "a facet of its text has not three rows `vertex X Y Z`"
