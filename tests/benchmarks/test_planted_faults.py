"""Planted faults do to a picture what they say, and nothing tells of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.planted_faults import (
    KINDS,
    MOVED,
    Fault,
    Planted,
    drawn,
    opened,
    pictured,
    relit,
    turned,
    with_arm,
)
from benchmarks.surprises import first_settings
from bridge.messages import LightDescription, Settings
from geometry.camera import Camera
from geometry.model import load_model
from geometry.pose import Pose
from image_server.serve.device import Frame

CAMERA = Camera(320, 240, 400.0, 400.0, 159.5, 119.5)
LIT = Settings(lights=(7, 0, 3), shutter_s=1 / 60, aperture=4.0)
LIT_TWO = Settings(lights=(10, 1), shutter_s=1 / 60, aperture=4.0)
THREE = tuple(LightDescription(name=name, levels=8) for name in ("left", "right", "top"))


def test_what_moves_is_seen_where_its_pose_says() -> None:
    fault = Fault("target_moved", towards_rad=0.7)
    true = Pose(np.array([0.1, -0.3, 0.2]), np.array([0.05, 0.02, 0.6]))
    u, v = np.rint(CAMERA.project(true.translation[None])[0]).astype(int)
    spot = np.zeros((240, 320), np.uint8)
    spot[v - 3 : v + 4, u - 3 : u + 4] = 200
    seen = pictured(spot, CAMERA, spot > 0, fault, 2).astype(float)
    middle = np.array([(seen * axis).sum() for axis in np.indices(seen.shape)[::-1]]) / seen.sum()
    move = turned(fault)
    expected = CAMERA.project((move.matrix @ true.translation)[None])[0]
    assert middle == pytest.approx(expected, abs=0.8)  # the spot is at a whole pixel
    assert np.linalg.norm(move.matrix @ true.translation - true.translation) == pytest.approx(
        MOVED * np.linalg.norm(true.translation), rel=0.02
    )


def test_lights_do_otherwise_than_they_are_told() -> None:
    assert relit(LIT, Fault("light_dead", (0,)), THREE).lights == (0, 0, 3)
    assert relit(LIT, Fault("lights_swapped", (1, 2)), THREE).lights == (7, 3, 0)
    assert relit(LIT, Fault("in_the_way"), THREE).lights == LIT.lights
    uneven = [LightDescription(name="port", levels=32), LightDescription(name="starboard", levels=2)]
    assert relit(LIT_TWO, Fault("lights_swapped", (0, 1)), uneven).lights == (31, 0)


def test_a_fault_of_light_that_makes_no_difference_is_not_drawn() -> None:
    rng = np.random.default_rng(1)
    dark = Settings(lights=(0, 0, 0), shutter_s=1 / 60, aperture=4.0)
    assert drawn("light_dead", dark, 1.0, THREE, rng) is None
    assert drawn("lights_swapped", dark, 1.0, THREE, rng) is None
    assert all(drawn("light_dead", LIT, 1.0, THREE, rng) != Fault("light_dead", (1,)) for _ in range(20))


def test_an_arm_hides_a_part_of_the_target_and_not_all() -> None:
    pixels, region = np.full((240, 320), 60, np.uint8), np.zeros((240, 320), bool)
    region[80:160, 100:200] = True
    for towards in np.linspace(0.0, 2.0 * np.pi, 7):
        changed = with_arm(pixels, region, float(towards), np.random.default_rng(0)) != pixels
        assert 0.1 < changed[region].mean() < 0.5


@pytest.fixture(scope="module")
def asked() -> list[Settings]:
    """Two settings, one after the other."""
    first = first_settings(opened("nominal", 1)[0].describe())
    return [
        Settings(lights=lights, shutter_s=first.shutter_s, aperture=first.aperture)
        for lights in ((7, 0, 7), (7, 7, 0))
    ]


@pytest.fixture(scope="module")
def plain(asked: list[Settings], tmp_path_factory: pytest.TempPathFactory) -> list[Frame]:
    """What is seen under them without a fault."""
    device = Planted("nominal", 1, "nothing", 2, tmp_path_factory.mktemp("plain"))
    return [device.capture(settings) for settings in asked]


@pytest.mark.parametrize("kind", ["nothing", *KINDS])
def test_a_fault_comes_when_it_is_to_come_and_is_not_told(
    kind: str, asked: list[Settings], plain: list[Frame], tmp_path: Path
) -> None:
    device = Planted("nominal", 1, kind, 2, tmp_path)
    for number, (settings, without) in enumerate(zip(asked, plain, strict=True), 1):
        frame = device.capture(settings)
        assert frame.applied == without.applied
        assert frame.verified
        happened = number == 2 and kind not in ("nothing", "model_wrong")
        assert (frame.pixels != without.pixels).any() == happened


def test_light_that_flickers_makes_each_image_brighter_or_darker(tmp_path: Path) -> None:
    device, plain = (Planted("nominal", 1, kind, 2, tmp_path) for kind in ("flicker", "nothing"))
    times = []
    for _ in range(6):
        seen, steady = (one.capture(LIT).pixels.astype(float) for one in (device, plain))
        bright = (steady > 60.0) & (steady < 200.0)
        times.append(np.median(seen[bright] / steady[bright]))
    assert max(times) - min(times) > 0.1
    assert all(0.84 < one < 1.16 for one in times)


def test_a_wrong_model_is_longer_along_one_axis(tmp_path: Path) -> None:
    wrong, true = (Planted("nominal", 1, kind, 2, tmp_path).describe() for kind in ("model_wrong", "nothing"))
    assert wrong.target is not None
    assert true.target is not None
    longer, plain = load_model(wrong.target.model), load_model(true.target.model)
    share = np.ptp(longer.vertices, axis=0) / np.ptp(plain.vertices, axis=0)
    assert sorted(share) == pytest.approx([1.0, 1.0, 1.02])
