"""Places of edges beside the truth: targets on which nothing is printed."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.edge_places import plain
from benchmarks.edge_times import TARGETS
from geometry.model import find_target, load_model
from image_server.simulator.material import load_appearance


@pytest.mark.parametrize("target", TARGETS)
def test_a_plain_target_differs_in_nothing_but_its_texture(target: str, tmp_path: Path) -> None:
    own, copy = find_target(target), plain(target, tmp_path)
    faces = len(load_model(own).faces)
    assert copy.read_bytes() == own.read_bytes()
    looks = [load_appearance(file, faces) for file in (own, copy)]
    textures = [{look.material_of(face).texture for face in range(faces)} for look in looks]
    assert textures[1] == {"plain"} != textures[0]
