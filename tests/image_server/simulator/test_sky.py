"""Sun, Earth and stars: what is seen of them, and what they light, are the same light."""

import math

import numpy as np
import pytest

from geometry.camera import Camera
from image_server.simulator.sky import Earth, Sky, earth_radiance, irradiance, light_from, seen

CAMERA = Camera(320, 240, 400.0, 400.0, 159.5, 119.5)
BEHIND = np.array([0.0, 0.0, -1.0])
AHEAD = np.array([0.0, 0.0, 1.0])
STRENGTH = 0.5
LOW = Earth(AHEAD, 1.06, STRENGTH * 0.3)


def sky(**changes: object) -> Sky:
    return Sky(**{"sun": BEHIND, "sun_radius_rad": 0.0046, "sun_strength": STRENGTH, **changes})  # type: ignore[arg-type]


def drawn() -> np.random.Generator:
    return np.random.default_rng(5)


def test_nothing_shows_in_black_space() -> None:
    assert seen(sky(), CAMERA, drawn()) is None


@pytest.mark.parametrize("radius_deg", [0.265, 1.0, 3.0])
def test_the_disc_of_the_sun_holds_the_light_that_it_gives_a_face(radius_deg: float) -> None:
    image = seen(sky(sun=AHEAD, sun_radius_rad=math.radians(radius_deg)), CAMERA, drawn())
    assert image is not None
    # a white face turned to it has the radiance (1/pi) times the integral of the disc's over the solid angle
    solid_angle = 1.0 / (CAMERA.fx * CAMERA.fy)
    assert image.sum() * solid_angle / math.pi == pytest.approx(STRENGTH, rel=0.03)
    wide = (image > 0.5 * image.max()).sum()
    assert wide == pytest.approx(math.pi * (400.0 * math.tan(math.radians(radius_deg))) ** 2, rel=0.25)


def test_even_light_is_the_same_on_every_face() -> None:
    numbers = irradiance(sky(even=0.02))
    for normal in (AHEAD, BEHIND, np.array([0.6, 0.0, 0.8])):
        assert light_from(numbers, *normal) == pytest.approx(0.02, rel=2e-3)


@pytest.mark.parametrize("earth_distance", [1.06, 2.0])
@pytest.mark.parametrize("turned_deg", [0.0, 40.0, 80.0, 120.0])
def test_earthshine_on_a_face_is_what_its_disc_sends(earth_distance: float, turned_deg: float) -> None:
    earth = Earth(AHEAD, earth_distance, STRENGTH * 0.3)
    shining = sky(earth=earth)
    normal = np.array([math.sin(math.radians(turned_deg)), 0.0, math.cos(math.radians(turned_deg))])
    index = np.arange(100000) + 0.5
    z = 1 - 2 * index / len(index)
    around = index * math.pi * (3 - math.sqrt(5))
    across = np.sqrt(1 - z * z)
    sphere = np.stack([across * np.cos(around), across * np.sin(around), z], axis=1)
    radiance = earth_radiance(sphere, earth, BEHIND, 1e-3)
    cosine = np.maximum(sphere @ normal, 0)
    wanted = 4 * float((radiance * cosine).mean())
    most = 4 * float((radiance * np.maximum(sphere @ AHEAD, 0)).mean())
    assert light_from(irradiance(shining), *normal) == pytest.approx(wanted, abs=0.07 * most)


def test_the_limb_lies_where_the_altitude_puts_it() -> None:
    distance = 1 + 400 / 6371
    angle = math.asin(1 / distance)
    down = np.array([0.0, math.sin(angle), math.cos(angle)])  # its limb through the middle of the image
    image = seen(
        sky(earth=Earth(down, distance, STRENGTH * 0.3), sun=np.array([0.0, -1.0, 0.0])), CAMERA, drawn()
    )
    assert image is not None
    column = image[:, 160].astype(float)
    ground = column[121:].mean()
    assert column[:100].max() < 0.01 * ground < ground
    half = int(np.flatnonzero(column > 0.7 * ground)[0])
    assert abs(half - 119.5) <= 1.5


def test_a_sun_behind_the_earth_is_hidden() -> None:
    low = sky(earth=LOW)
    assert low.hides_sun(AHEAD)
    assert not low.hides_sun(BEHIND)


def test_stars_are_as_faint_as_they_are_and_do_not_shine_through_the_earth() -> None:
    true = seen(sky(star_brightness=1.0), CAMERA, drawn())
    assert true is not None
    assert 0 < true.max() < 1e-4  # 255 grey levels see nothing of it
    bright = seen(sky(star_brightness=1e6), CAMERA, drawn())
    assert bright is not None
    assert bright == pytest.approx(true * 1e6, rel=1e-3)
    hidden = seen(sky(star_brightness=1e6, earth=LOW, sun=AHEAD), CAMERA, drawn())
    assert hidden is not None
    assert hidden.max() == 0  # the night side before all of them
