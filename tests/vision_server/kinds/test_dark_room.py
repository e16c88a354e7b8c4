"""Lamps that are all the light there is."""

from __future__ import annotations

import numpy as np
import pytest

from tests.vision_server.level_samples import edgels_of
from vision_server.kinds.background import Background
from vision_server.kinds.dark_room import lamps_in_the_dark
from vision_server.kinds.learnt_lights import learnt_lights
from vision_server.kinds.light_parts import known_lights
from vision_server.kinds.likelihoods import CREASE, PRINT, SHADOW, likelihoods
from vision_server.kinds.sides import Sides

NOISE = 0.6
MIXED = np.array([[1.0, 0.5, 0.0], [0.0, 1.0, 0.5], [0.5, 0.0, 1.0]])


def scene(levels: np.ndarray, sun: float = 0.0, each: int = 40) -> tuple[Sides, np.ndarray]:
    """Edgels under lamps and a sun that gives so much everywhere, and their kinds."""
    random = np.random.default_rng(0)
    lamps = levels.shape[1]
    pairs, kinds = [], []
    for number in range(each * lamps):
        left = np.array(random.uniform(50.0, 150.0, lamps))
        shaded, turned = left.copy(), left * np.exp(random.normal(0.0, 0.8, lamps))
        shaded[number % lamps] = 0.0
        turned[random.random(lamps) < 0.2] = 0.0
        for kind, right in ((SHADOW, shaded), (CREASE, turned), (PRINT, 0.3 * left)):
            pairs.append((left, right) if random.random() < 0.5 else (right, left))
            kinds.append(kind)
    near = np.einsum("cl,nsl->csn", levels, np.array(pairs)) + sun
    near += NOISE * random.normal(size=near.shape)
    return edgels_of(near, NOISE), np.array(kinds)


@pytest.mark.parametrize("lamps", [3, 4, 5])
def test_kinds_are_told_from_one_image_for_each_lamp(lamps: int) -> None:
    sides, kinds = scene(np.eye(lamps))
    lights = learnt_lights(sides)
    assert lights is not None and lights.are_all and lights.are_alone
    told = likelihoods(sides, Background(1.0), lights).argmax(axis=0)
    for kind in (SHADOW, CREASE, PRINT):
        assert np.mean(told[kinds == kind] == kind) > 0.85


def test_levels_that_were_told_may_be_mixed() -> None:
    sides, kinds = scene(MIXED)
    lights = lamps_in_the_dark(MIXED, sides)
    assert lights is not None and not lights.are_alone
    told = likelihoods(sides, Background(1.0), lights).argmax(axis=0)
    assert np.mean(told[kinds == SHADOW] == SHADOW) > 0.9


@pytest.mark.parametrize(
    ("levels", "sun"), [(np.eye(3), 30.0), (MIXED, 0.0)], ids=["a sun", "several lamps in an image"]
)
def test_what_else_there_is_at_shadows_ends_shows_other_light(levels: np.ndarray, sun: float) -> None:
    sides, _ = scene(levels, sun)
    assert lamps_in_the_dark(np.eye(3), sides) is None


def test_without_ends_of_shadows_it_does_not_show() -> None:
    sides, kinds = scene(np.eye(3))
    assert lamps_in_the_dark(np.eye(3), sides.of(np.flatnonzero(kinds == PRINT))) is None


@pytest.mark.parametrize("sun", [0.0, 8.0])
def test_with_fewer_images_than_lights_creases_are_no_highlights(sun: float) -> None:
    sides, kinds = scene(np.eye(5), sun)
    told = likelihoods(sides, Background(1.0), known_lights(np.eye(5))).argmax(axis=0)
    assert np.mean(told[kinds == CREASE] == CREASE) > 0.5  # without what is said of turned lights .25 at most


def test_prints_in_dim_light_are_as_deep() -> None:
    sides, kinds = scene(np.eye(5))
    dim = sides.near * np.linspace(0.2, 1.0, 5, dtype=np.float32)[:, None, None]
    told = likelihoods(sides._replace(near=dim, brightest=dim), Background(1.0)).argmax(axis=0)
    assert np.mean(told[kinds == PRINT] == PRINT) > 0.9
