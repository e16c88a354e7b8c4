"""STL files are read, binary or text, whatever their heads and names say; what is cut short says so."""

import re
from pathlib import Path

import numpy as np
import pytest
import trimesh

from geometry.errors import GeometryError
from geometry.model import load_model

BOX = trimesh.creation.box((0.1, 0.08, 0.06))
BINARY: bytes = BOX.export(file_type="stl")
SOLID = b"solid part of a CAD program".ljust(80) + BINARY[80:]
TEXT: str = BOX.export(file_type="stl_ascii")


def must_be_the_box(file: Path, content: bytes) -> None:
    file.write_bytes(content)
    model = load_model(file)
    assert len(model.lines) == 12
    assert np.ptp(model.vertices, axis=0) == pytest.approx([0.1, 0.08, 0.06])


@pytest.mark.parametrize("whole", [BINARY, SOLID])
@pytest.mark.parametrize("more", [b"", b"\0\0", b"made by a CAD program"])
def test_what_follows_the_triangles_of_a_binary_file_is_left(
    tmp_path: Path, whole: bytes, more: bytes
) -> None:
    must_be_the_box(tmp_path / "box.stl", whole + more)


@pytest.mark.parametrize("whole", [BINARY, SOLID])
@pytest.mark.parametrize("short", [1, 70, 600])
def test_a_binary_file_that_is_cut_short_says_by_how_much(tmp_path: Path, whole: bytes, short: int) -> None:
    (tmp_path / "box.stl").write_bytes(whole[:-short])
    said = rf"cut short, or is no STL file: of the 684 bytes that its 12 triangles take it has {684 - short}"
    with pytest.raises(GeometryError, match=said):
        load_model(tmp_path / "box.stl")


def test_a_step_file_is_told_so(tmp_path: Path) -> None:
    (tmp_path / "box.stl").write_bytes(b"ISO-10303-21;\nHEADER;\n" + BINARY)
    with pytest.raises(GeometryError, match="it is a STEP file; export STL"):
        load_model(tmp_path / "box.stl")


@pytest.mark.parametrize("name", ["Gehäuse", "vertex endsolid solid", "facet normal", ""])
def test_a_text_may_have_any_name(tmp_path: Path, name: str) -> None:
    text = TEXT.replace("solid", f"solid {name}", 1).replace("endsolid", f"endsolid {name}")
    must_be_the_box(tmp_path / "box.stl", text.encode("latin-1"))


@pytest.mark.parametrize(
    "content",
    [
        b"\xef\xbb\xbf" + TEXT.encode(),
        TEXT.upper().encode(),
        TEXT.replace("\n", "\r\n").encode(),
        TEXT.replace("\n", "\r").encode(),
        TEXT.replace("endfacet\nendsolid", "endfacet endsolid").encode(),
        b"\n" + TEXT.encode() + b"\n\n" + TEXT.encode(),
        b"# a solid box\n; made by hand\n\n" + TEXT.encode(),
        TEXT.encode("utf-16"),
        b"\xfe\xff" + TEXT.encode("utf-16-be"),
    ],
)
def test_a_text_is_read_however_it_is_written(tmp_path: Path, content: bytes) -> None:
    must_be_the_box(tmp_path / "box.stl", content)


@pytest.mark.parametrize(
    "content",
    [
        TEXT[: TEXT.index("endsolid")],
        TEXT[: TEXT.rindex("vertex")],
        TEXT[:40],
        TEXT + TEXT[: TEXT.rindex("vertex")],
        TEXT[: TEXT.rindex("facet")] + TEXT,
    ],
)
def test_a_text_that_is_cut_short_says_so(tmp_path: Path, content: str) -> None:
    """It had no faces, or was read without those of its last solid."""
    (tmp_path / "box.stl").write_text(content)
    with pytest.raises(GeometryError, match="cut short, or is no STL file: a `solid` of its text has no"):
        load_model(tmp_path / "box.stl")


@pytest.mark.parametrize(
    "content", [b"<!DOCTYPE html>".ljust(200, b"x"), b"version https://git-lfs".ljust(130)]
)
def test_another_text_is_no_stl_file(tmp_path: Path, content: bytes) -> None:
    """It was said to be cut short, of two thousand million triangles."""
    (tmp_path / "box.stl").write_bytes(content)
    with pytest.raises(GeometryError, match="it is no STL file: it neither begins with `solid`"):
        load_model(tmp_path / "box.stl")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (r"(\d)\.(\d)", r"\1,\2", r"its row 'vertex -?0,05 -?0,04 -?0,03' is not of three numbers with dec"),
        (r"vertex (\S+) (\S+) (\S+)", r"vertex \1 \2", r"its row 'vertex \S+ \S+' is not of three numbers"),
        ("vertex", "point", "a facet of its text has not three rows `vertex X Y Z`"),
    ],
)
def test_a_text_whose_corners_are_no_numbers_says_which(
    tmp_path: Path, old: str, new: str, said: str
) -> None:
    (tmp_path / "box.stl").write_text(re.sub(old, new, TEXT, count=0 if "," in new else 1))
    with pytest.raises(GeometryError, match=said):
        load_model(tmp_path / "box.stl")
