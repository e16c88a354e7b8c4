"""Faces of an OBJ file that have many corners, or are concave."""

import re
from pathlib import Path

import numpy as np
import pytest

from geometry.errors import GeometryError
from geometry.model import Model, load_model
from tests.geometry.concave import ARROW, C_SHAPE, HEIGHT, areas


def prism(file: Path, outline: list[tuple[float, float]], word: str = "{0}") -> Model:
    """The outline (in 0.1 m) as an OBJ file's prism, its two ends one face each."""
    count = len(outline)
    lines = [f"v {0.1 * x} {0.1 * y} {z}" for z in (0.0, HEIGHT) for x, y in outline]
    lines += ["vt 0 0", "vn 0 0 1"]
    faces = [list(reversed(range(count))), list(range(count, 2 * count))]
    faces += [[k, (k + 1) % count, count + (k + 1) % count, count + k] for k in range(count)]
    lines += ["f " + " ".join(word.format(k + 1, k - 2 * count) for k in face) for face in faces]
    file.write_text("\n".join(lines) + "\n")
    return load_model(file)


@pytest.mark.parametrize(("outline", "area", "around"), [(C_SHAPE, 0.07, 1.6), (ARROW, 0.04, 1.16833)])
@pytest.mark.parametrize("word", ["{0}", "{1}", "{0}/1/1", "{0}//1", "{0}\\\n"])
def test_concave_faces_are_what_is_inside_their_sides(
    tmp_path: Path, outline: list[tuple[float, float]], area: float, around: float, word: str
) -> None:
    model = prism(tmp_path / "part.obj", outline, word)
    assert areas(model) == pytest.approx(2 * area + around * HEIGHT, rel=1e-5)
    assert len(model.lines) == 3 * len(outline)
    assert not model.two_sided.any()


def test_indices_count_back_from_where_they_stand(tmp_path: Path) -> None:
    """Points and faces take turns, as programs write them that export face by face."""
    whole = prism(tmp_path / "whole.obj", C_SHAPE)
    text = ["vn 0 0 1"]
    for face in whole.faces:
        corners = whole.vertices[face]
        text += [f"v {x} {y} {z}" for x, y, z in corners.tolist()]
        text += ["vt 0 0", "f " + " ".join(f"{k - len(corners)}/-1/1" for k in range(len(corners)))]
    (tmp_path / "turns.obj").write_text("\n".join(text) + "\n")
    turns = load_model(tmp_path / "turns.obj")
    assert len(turns.lines) == len(whole.lines)
    np.testing.assert_allclose(turns.diameter, whole.diameter)
    assert areas(turns) == pytest.approx(areas(whole))


@pytest.mark.parametrize(
    ("written", "instead"),
    [
        (r"$", r" # as exported"),
        (r"^(f.*)$", r"\1# \\"),
        (r" ", "\t"),
        (r" ", "  "),
        (r"^", " \t"),
        (r"$", r" \t"),
        (r" (\S+)$", r" \\\n\1"),
        (r"\A", "# of C:\\\\parts\\\\\n"),
    ],
)
@pytest.mark.parametrize("word", ["{0}", "{1}", "{0}//1"])
@pytest.mark.parametrize("ends", ["\n", "\r\n"])
def test_a_file_is_the_same_with_other_spaces_and_with_comments(
    tmp_path: Path, written: str, instead: str, word: str, ends: str
) -> None:
    file = tmp_path / "part.obj"
    plain = prism(file, C_SHAPE, word)
    text = re.sub(written, instead, file.read_text().strip(), flags=re.MULTILINE)
    file.write_text(text + "\n", newline=ends)
    other = load_model(file)
    np.testing.assert_array_equal(other.vertices, plain.vertices)
    np.testing.assert_array_equal(other.lines, plain.lines)


@pytest.mark.slow
def test_a_face_of_thousands_of_corners_has_no_fan_of_slivers(tmp_path: Path) -> None:
    """Rays look at each triangle whose box they meet: boxes that overlap cost time."""
    turn = np.arange(2000) * 2 * np.pi / 2000
    model = prism(tmp_path / "disc.obj", list(zip(np.cos(turn).tolist(), np.sin(turn).tolist(), strict=True)))
    corners = model.vertices[model.triangles]
    boxes = np.ptp(corners, axis=1)
    ends = boxes[:, 2] == 0
    assert ends.sum() == 2 * 1998
    assert boxes[ends, :2].prod(axis=1).sum() < 5 * 2 * np.pi * 0.01


def test_what_is_no_face_is_said(tmp_path: Path) -> None:
    many = tmp_path / "many.obj"
    many.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf " + "1 2 3 " * 4000 + "\n")
    with pytest.raises(GeometryError, match=r"many.obj.*line 4: a face has at most 10000 corners"):
        load_model(many)
    wrong = tmp_path / "wrong.obj"
    for face in ("1 2 3 9", "1 2 3 x", "1 2 3 -9"):
        wrong.write_text(f"v 0 0 0\nv 1 0 0\nv 0 1 0\nf {face}\n")
        with pytest.raises(GeometryError, match=r"wrong.obj"):
            load_model(wrong)


def test_a_file_that_is_no_obj_file_is_told_so(tmp_path: Path) -> None:
    (tmp_path / "part.obj").write_bytes(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR")
    with pytest.raises(GeometryError, match="it is not an OBJ file"):
        load_model(tmp_path / "part.obj")


WIREFRAME = "v 0 0 0\nv 1 0 0\nv 1 1 0\nl 1 2/7 3 # an angle\nv 0 1 0\nl -2 -1\nl 4 4 1\n"


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_lines_are_the_model_where_there_is_no_face(tmp_path: Path, encoding: str) -> None:
    file = tmp_path / "part.obj"
    file.write_text(WIREFRAME, encoding=encoding)
    model = load_model(file)
    assert {tuple(sorted(line)) for line in model.lines.tolist()} == {(0, 1), (1, 2), (2, 3), (0, 3)}
    assert (model.faces, model.vertices.tolist()[2]) == ((), [1.0, 1.0, 0.0])
    file.write_text(WIREFRAME + "f 1 2 3 4\n", encoding=encoding)
    assert len(load_model(file).triangles) == 2


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("v 0 0 0\nl 1 2\n", "a face or line names a point that the file does not have"),
        ("v 0 0 0\nl 1 -2\n", "a face or line names a point that the file does not have"),
        ("v 0 0 0\nv 0 0 1\nl 1 x\n", "line 3: not all of it are numbers"),
        ("v 0 0,0 0\nv 0 0 1\nl 1 2\n", "line 1: not all of it are numbers"),
        ("v 0 0\nv 0 0 1\nl 1 2\n", "damaged"),
        ("v 0 0 0\nl 1 1\n", "no faces"),
        ("v 0 0 nan\nv 1 0 0\nl 1 2\n", "not finite"),
    ],
)
def test_what_is_no_line_is_said(tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "part.obj"
    file.write_text(text)
    with pytest.raises(GeometryError, match=said):
        load_model(file)
