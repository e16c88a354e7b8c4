"""Drawn parts: closed bodies of their number, and wheels that only a block tells from their turns."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.drawn_parts import OTHER_PARTS, PARTS
from geometry.model import Model, load_model
from geometry.near_symmetries import near_symmetries


def part(folder: Path, name: str, number: int) -> Model:
    {**PARTS, **OTHER_PARTS}[name](folder / f"{name}.cao", np.random.default_rng([1, number]))
    return load_model(folder / f"{name}.cao")


@pytest.mark.parametrize("name", [*PARTS, *OTHER_PARTS])
def test_a_part_is_a_closed_body_of_its_number(tmp_path: Path, name: str) -> None:
    texts = set()
    for number in range(8):
        model = part(tmp_path, name, number)
        text = (tmp_path / f"{name}.cao").read_text()
        part(tmp_path, name, number)
        assert (tmp_path / f"{name}.cao").read_text() == text
        texts.add(text)
        assert not model.two_sided.any()
        corners = model.vertices[model.triangles]
        volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6.0
        assert volume > 0.0
    assert len(texts) == 8


@pytest.mark.parametrize("number", range(12))
def test_a_prism_has_the_lines_of_its_outline(tmp_path: Path, number: int) -> None:
    model = part(tmp_path, "part", number)
    sides = len(model.faces) - 2  # two sides that hardly bend have no line between them
    assert 3 * sides - 2 <= len(model.lines) <= 3 * sides


@pytest.mark.parametrize("number", range(6))
def test_a_wheel_is_turned_nearly_onto_itself(tmp_path: Path, number: int) -> None:
    assert near_symmetries(part(tmp_path, "wheel", number))
