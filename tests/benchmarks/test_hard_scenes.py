"""Hard scenes: each kind has its light, and an empty frame is empty."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks import hard_scenes, povray, ray_traced_stacks
from benchmarks.drawn_parts import write_prism
from geometry.model import find_target, load_model
from stack.read import BasisStack, load_stack


@pytest.mark.parametrize("kind", hard_scenes.KINDS)
def test_a_kind_is_dark_sunlit_or_blurred_as_it_says(kind: str) -> None:
    drawn = hard_scenes.conditions(kind, np.random.default_rng(3))
    assert (drawn.defocus_px > 0.0) == (kind in "ACE")
    assert (drawn.sun == 0.0) or kind != "A"
    assert (drawn.sun >= 8.0) or kind not in "BCE"


def test_a_part_that_is_not_quite_its_model_is_longer_one_way_and_shorter_another() -> None:
    model = load_model(find_target("fixture"))
    other = hard_scenes.not_quite(model, 0.01, np.random.default_rng(2))
    shares = np.ptp(other.vertices, axis=0) / np.ptp(model.vertices, axis=0) - 1.0
    assert np.allclose(np.sort(shares), [-0.008, 0.0, 0.01])
    assert np.allclose(other.middle, model.middle)


@pytest.mark.slow
@pytest.mark.skipif(not povray.available(), reason="POV-Ray (Debian package povray) is not installed")
def test_without_a_target_the_frame_shows_the_wall_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ray_traced_stacks, "SAMPLES", 1)
    monkeypatch.setattr(ray_traced_stacks, "_target", lambda *_: pytest.fail("no target is to be seen"))
    write_prism(tmp_path / "part.cao", np.random.default_rng(1))
    number = 1 + hard_scenes.KINDS.index("N")
    ray_traced_stacks.drawn_stack(tmp_path / "part.cao", number, 5, tmp_path / "stack", hard=True)
    stack = load_stack(tmp_path / "stack")
    assert isinstance(stack, BasisStack)
    assert np.max(stack.radiances, axis=0).mean() > 0.004
