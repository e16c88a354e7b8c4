"""Points and polygons of PLY files, text and binary."""

import struct
from pathlib import Path

import pytest

from geometry.errors import GeometryError
from geometry.model import load_model
from tests.geometry.concave import ARROW, C_SHAPE, HEIGHT, areas

FORMATS = ("ascii", "binary_little_endian", "binary_big_endian")


def write_prism(file: Path, form: str, outline: list[tuple[float, float]]) -> None:
    """The outline (in 0.1 m) as a prism, its two ends one face each; with a note, normals and colours."""
    count = len(outline)
    points = [(0.1 * x, 0.1 * y, z) for z in (0.0, HEIGHT) for x, y in outline]
    faces = [list(reversed(range(count))), list(range(count, 2 * count))]
    faces += [[k, (k + 1) % count, count + (k + 1) % count, count + k] for k in range(count)]
    head = ["ply", f"format {form} 1.0", "comment a prism", "element note 2", "property uchar number"]
    head += [f"element vertex {len(points)}", *(f"property float {name}" for name in ("nx", "x", "y", "z"))]
    head += [f"element face {len(faces)}", "property uchar red", "property list uchar int vertex_indices"]
    order = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}[form]

    def row(kinds: str, *values: float) -> bytes:
        return struct.pack(order + kinds, *values) if order else " ".join(map(str, values)).encode() + b"\n"

    rows = [row("B", 7), row("B", 8), *(row("4f", 0.5, *point) for point in points)]
    rows += [row(f"BB{len(face)}i", 200, len(face), *face) for face in faces]
    file.write_bytes("\n".join([*head, "end_header", ""]).encode() + b"".join(rows))


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize(("outline", "area", "around"), [(C_SHAPE, 0.07, 1.6), (ARROW, 0.04, 1.16833)])
def test_concave_faces_are_what_is_inside_their_sides(
    tmp_path: Path, form: str, outline: list[tuple[float, float]], area: float, around: float
) -> None:
    write_prism(tmp_path / "part.ply", form, outline)
    model = load_model(tmp_path / "part.ply")
    assert areas(model) == pytest.approx(2 * area + around * HEIGHT, rel=1e-5)
    assert len(model.lines) == 3 * len(outline)
    assert not model.two_sided.any()


@pytest.mark.parametrize("form", FORMATS)
def test_what_is_cut_short_is_said(tmp_path: Path, form: str) -> None:
    file = tmp_path / "part.ply"
    write_prism(file, form, C_SHAPE)
    whole = file.read_bytes()
    for cut in (40, 300, len(whole) - 200, len(whole) - 3):
        file.write_bytes(whole[:cut])
        with pytest.raises(GeometryError, match=r"part\.ply cannot be read as a mesh: "):
            load_model(file)


HEAD = """ply
format ascii 1.0
element vertex 3
property float x
property float y
property {z} z
element face {faces}
property list {count} int {corners}
end_header
0 0 0
1 0 0
0 1 {last}
{rows}
"""
GOOD = {"z": "float", "faces": 1, "count": "uchar", "corners": "vertex_index", "last": "0", "rows": "3 0 1 2"}


@pytest.mark.parametrize(
    ("other", "said"),
    [
        ({"rows": "3 0 1 3"}, "face 0 names a point that is not there"),
        ({"rows": "3 0 -1 2"}, "face 0 names a point that is not there"),
        ({"rows": "1.5 0 1 2"}, "face rows are cut short or no numbers"),
        ({"rows": "3 0 one 2"}, "face rows are cut short or no numbers"),
        ({"rows": "99999 0 1 2"}, "a face has at most 10000 corners"),
        ({"faces": 2_000_000}, "it has 2000000 triangles, and at most 1500000 are read.*coarser"),
        ({"z": "quad"}, "its header's line 'property quad z' cannot be read"),
        ({"corners": "edges"}, "its faces have no list vertex_indices"),
        ({"last": "nan"}, "has a point that is not finite"),
        ({"last": "inf"}, "has a point that is not finite"),
        ({"rows": "2 0 1"}, "has no faces"),
    ],
)
def test_what_is_wrong_with_a_file_is_said(tmp_path: Path, other: dict[str, object], said: str) -> None:
    file = tmp_path / "part.ply"
    file.write_text(HEAD.format(**GOOD))
    assert len(load_model(file).lines) == 3
    file.write_text(HEAD.format(**{**GOOD, **other}))
    with pytest.raises(GeometryError, match=f"part.ply.*{said}"):
        load_model(file)
