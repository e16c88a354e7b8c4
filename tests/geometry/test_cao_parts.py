"""A .cao file that loads others is all of them, where it says."""

from pathlib import Path

import numpy as np
import pytest

from geometry.errors import GeometryError
from geometry.model import files_of_model, load_model
from geometry.rotation import matrix_of

SQUARE = "V1\n4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0\n0\n1\n4 0 1 2 3\n0\n0\n"


def written(folder: Path, name: str, text: str) -> Path:
    file = folder / name
    file.parent.mkdir(exist_ok=True)
    file.write_text(text)
    return file


def box(folder: Path, *sides: str) -> Path:
    """A file that loads a square several times."""
    written(folder, "parts/square.cao", SQUARE)
    loads = "".join(f'load("parts/square.cao"{side})  # a side\n' for side in sides)
    return written(folder, "box.cao", f"V1\n{loads}0\n0\n0\n0\n0\n0\n")


SIDES = (
    "",
    ", t=[0; 0; 1]",
    ", tu=[90deg; 0; 0]",
    ", t=[0;1;0], tu=[1.5707963267948966 ; 0; 0]",
    ", tu=[0; -1.5707963267948966rad; 0]",
    ", tu=[0; -90 deg; 0] , t=[1; 0; 0]",
)


def test_six_squares_are_a_cube(tmp_path: Path) -> None:
    model = load_model(box(tmp_path, *SIDES))
    assert len(model.vertices) == 8  # corners that meet are one
    assert len(model.lines) == 12 and not model.two_sided.any()
    middle = model.vertices.mean(axis=0)
    assert np.allclose(middle, 0.5)
    for face, normal in zip(model.faces, model.face_normals, strict=True):
        assert normal @ (model.vertices[face].mean(axis=0) - middle) > 0.49


def test_a_part_is_where_the_files_above_it_put_it(tmp_path: Path) -> None:
    written(tmp_path, "parts/square.cao", SQUARE)
    written(tmp_path, "parts/side.cao", 'V1\nload("square.cao", t=[1; 2; 3], tu=[0.1; 0.2; 0.3])\n0\n')
    whole = written(tmp_path, "whole.cao", 'V1\nload("parts/side.cao", t=[0; 0; 7], tu=[0; 0; 90deg])\n0\n')
    square = load_model(tmp_path / "parts/square.cao").vertices
    above = matrix_of(np.array([0.0, 0.0, np.pi / 2]))
    inner = square @ matrix_of(np.array([0.1, 0.2, 0.3])).T + [1, 2, 3]
    expected = inner @ above.T + [0, 0, 7]
    found = load_model(whole).vertices
    assert np.abs(found[:, None] - expected[None]).max(axis=2).min(axis=0).max() < 1e-12


def test_round_parts_and_own_lines_go_with_it(tmp_path: Path) -> None:
    written(tmp_path, "tube.cao", "V1\n2\n0 0 0\n0 0 1\n0\n0\n0\n1\n0 1 0.3\n0\n")
    text = 'V1\nload("tube.cao")\nload("tube.cao", t=[2; 0; 0])\n2\n0 0 5\n1 0 5\n1\n0 1\n0\n0\n0\n0\n'
    model = load_model(written(tmp_path, "two.cao", text))
    assert len(model.faces) == 72
    assert model.smooth.sum() == 72
    assert len(model.lines) == 72 + 4 * 36 + 1


def test_files_are_those_that_are_loaded(tmp_path: Path) -> None:
    file = box(tmp_path, *SIDES)
    assert files_of_model(file) == [file, tmp_path / "parts/square.cao"]


@pytest.mark.parametrize(
    ("load", "message"),
    [
        ('load("none.cao")', r"whole.cao:2: there is no file .*none.cao"),
        ('load("whole.cao")', r"whole.cao:2: .*whole.cao loads itself"),
        ('load("ring.cao")', r"ring.cao:2: .*whole.cao loads itself"),
        ('load("../square.cao")', r"whole.cao:2: .* is not beside .*whole.cao or below. Copy it there"),
        ("load(square.cao)", r"whole.cao:2: 'load\(square.cao\)' is not load\(\"FILE.cao\", t="),
        ('load("square.cao", t=[1; 2])', r"whole.cao:2: 't=\[1; 2\]' is neither t=\[X; Y; Z\] nor tu="),
        ('load("square.cao", s=[1; 2; 3])', r"'s=\[1; 2; 3\]' is neither"),
        ('load("square.cao", tu=[1; 2; x])', r"'tu=\[1; 2; x\]' is neither"),
        ('load("bad.cao")', r"bad.cao:2: 'x' is not a coordinate"),
        ("load", r"whole.cao:2: 'load' is not load\("),
    ],
)
def test_a_load_that_cannot_be_is_told_with_its_line(tmp_path: Path, load: str, message: str) -> None:
    written(tmp_path, "square.cao", SQUARE)
    folder = tmp_path / "model"
    written(folder, "square.cao", SQUARE)
    written(folder, "ring.cao", 'V1\nload("whole.cao")\n0\n')
    written(folder, "bad.cao", "V1\n1 x\n")
    with pytest.raises(GeometryError, match=message):
        load_model(written(folder, "whole.cao", f"V1\n{load}\n0\n"))
