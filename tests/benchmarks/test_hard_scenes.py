"""Hard scenes: random parts are solid models, each kind has its light, and an empty frame is empty."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks import hard_scenes, povray, ray_traced_stacks
from geometry.model import load_model
from stack.read import BasisStack, load_stack


@pytest.mark.parametrize("number", range(12))
def test_a_part_is_a_closed_body_of_its_number(tmp_path: Path, number: int) -> None:
    files = [tmp_path / "one.cao", tmp_path / "again.cao"]
    for file in files:
        hard_scenes.write_part(file, np.random.default_rng([1, number]))
    assert files[0].read_text() == files[1].read_text()
    model = load_model(files[0])
    assert not model.two_sided.any()
    sides = len(model.faces) - 2  # of a prism; two sides that hardly bend have no line between them
    assert 3 * sides - 2 <= len(model.lines) <= 3 * sides
    corners = model.vertices[model.triangles]
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6.0
    assert volume > 0.0


def test_parts_differ_from_number_to_number(tmp_path: Path) -> None:
    texts = set()
    for number in range(5):
        hard_scenes.write_part(tmp_path / "part.cao", np.random.default_rng([1, number]))
        texts.add((tmp_path / "part.cao").read_text())
    assert len(texts) == 5


@pytest.mark.parametrize("kind", hard_scenes.KINDS)
def test_a_kind_is_dark_sunlit_or_blurred_as_it_says(kind: str) -> None:
    drawn = hard_scenes.conditions(kind, np.random.default_rng(3))
    assert (drawn.defocus_px > 0.0) == (kind in "ACE")
    assert (drawn.sun == 0.0) or kind != "A"
    assert (drawn.sun >= 8.0) or kind not in "BCE"


@pytest.mark.slow
@pytest.mark.skipif(not povray.available(), reason="POV-Ray (Debian package povray) is not installed")
def test_without_a_target_the_frame_shows_the_wall_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ray_traced_stacks, "SAMPLES", 1)
    monkeypatch.setattr(ray_traced_stacks, "_target", lambda *_: pytest.fail("no target is to be seen"))
    hard_scenes.write_part(tmp_path / "part.cao", np.random.default_rng(1))
    number = 1 + hard_scenes.KINDS.index("N")
    ray_traced_stacks.drawn_stack(tmp_path / "part.cao", number, 5, tmp_path / "stack", hard=True)
    stack = load_stack(tmp_path / "stack")
    assert isinstance(stack, BasisStack)
    assert np.max(stack.radiances, axis=0).mean() > 0.004
