"""A file that says the same is the same model, with all that was derived from it."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from geometry.model import TARGETS, load_model
from geometry.surface import Surface


def test_a_file_that_says_the_same_is_the_same_model_and_any_other_is_not(tmp_path: Path) -> None:
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [2, 1, 0]], dtype=np.float64)
    faces = [np.array([0, 1, 2, 3]), np.array([1, 4, 5, 2])]
    none = np.empty((0, 2), np.int64)
    told = Surface(square, faces, np.array([-1, -1]), none, 1.0, 30.0)
    others = [
        replace(told, vertices=2.0 * square),
        replace(told, faces=[np.array([0, 1, 2]), np.array([3, 1, 4, 5, 2])]),
        replace(told, faces=[np.array([0, 1, 2, 3]), np.array([1, 4, 2, 5])]),
        replace(told, groups=np.array([0, 0])),
        replace(told, drawn=np.array([[0, 2]])),
        replace(told, flat_deg=2.0),
        replace(told, sharp_deg=20.0),
    ]
    assert replace(told, vertices=square.copy()).content == told.content
    assert len({told.content, *(other.content for other in others)}) == 1 + len(others)
    cube, copy = TARGETS / "cube.cao", tmp_path / "cube.cao"
    copy.write_bytes(cube.read_bytes())
    assert load_model(copy) is load_model(cube)
    assert load_model(copy, "mm") is not load_model(cube)
    renamed = copy.rename(tmp_path / "other.cao")
    assert load_model(renamed).name == "other"
