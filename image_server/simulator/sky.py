"""The sky: the sun's disc, the Earth with its air, stars; what the camera sees of them, what they light.

Radiances are relative to a white face, as in `image_server.simulator.tracing`.
"""

import math
from typing import NamedTuple

import numpy as np

from geometry.camera import Camera
from image_server.simulator.rays import pixel_rays
from image_server.simulator.texture import noise
from numerics.arrays import Field, Floats
from numerics.kernels import kernel

EARTH_RADIUS_KM = 6371.0  # mean radius, IUGG
AIR_HEIGHT_KM = 8.0  # over which the air thins to 1/e
AIR_BRIGHTNESS = 0.6  # of the air at the limb, relative to the ground's mean
CLOUD_SIZE = 0.03  # Earth radii
CLOUD_CONTRAST = 0.8  # chosen by hand
LOBE = 4.0  # angle (rad) that a mirrored direction is spread over, per unit of alpha
LIMB_DARKENING = 0.6  # of the sun, in visible light
STAR_TO_SUN = 10.0 ** (-0.4 * 26.74)  # a star of magnitude 0 against the sun, as light on a face
FAINTEST, BRIGHTEST = 6.0, -1.0  # magnitudes of the stars that are drawn
STARS = 5000  # brighter than FAINTEST, over the whole sky
STARS_PER_MAGNITUDE = 10.0**0.51  # growth of their number with the magnitude
SHARP_LIMB_RAD = 1e-3  # over which a limb is smoothed that no pixel or roughness smooths
BAND_ROWS = 64  # of the frame at a time, so that the rays need little memory
DIRECTIONS = 4096  # in which the sky is sampled for its light on faces


class Earth(NamedTuple):
    """The Earth, from afar.

    Attributes
    ----------
    direction : (3,) unit vector to its middle, camera frame.
    distance : of its middle, Earth radii; 0 for no Earth.
    strength : radiance of its ground where the sun stands overhead.
    """

    direction: Floats
    distance: float
    strength: float

    @property
    def radius_rad(self) -> float:
        """Half the angle that it takes."""
        return math.asin(1.0 / self.distance)


NO_EARTH = Earth(np.array([0.0, 0.0, 1.0]), 0.0, 0.0)


class Sky(NamedTuple):
    """What stands behind everything.

    Attributes
    ----------
    sun : (3,) unit vector, camera frame.
    sun_radius_rad : half its angular diameter.
    sun_strength : radiance of a white face turned to the sun.
    even : radiance from all sides; what lights the target without being seen.
    earth : NO_EARTH for none.
    star_brightness : 0 for no stars, 1 for true ones.
    """

    sun: Floats
    sun_radius_rad: float
    sun_strength: float
    even: float = 0.0
    earth: Earth = NO_EARTH
    star_brightness: float = 0.0

    @property
    def has_earth(self) -> bool:
        """Whether there is one."""
        return self.earth.distance > 0

    def hides_sun(self, sun: Floats) -> bool:
        """Whether the Earth stands before a sun in this direction."""
        return self.has_earth and float(self.earth.direction @ sun) > math.cos(self.earth.radius_rad)


@kernel()
def earth_radiance(directions: Floats, earth: Earth, sun: Floats, edge: float) -> Floats:
    """Radiance (N,) of Earth and air in unit directions (N, 3).

    `edge` is the angle (rad) over which the limb is smoothed: a pixel.
    """
    out = np.zeros(len(directions))
    for i in range(len(directions)):
        x, y, z = directions[i, 0], directions[i, 1], directions[i, 2]
        out[i] = earth_along(x, y, z, earth, sun, edge, CLOUD_CONTRAST)
    return out


@kernel()
def earth_along(
    dx: float, dy: float, dz: float, earth: Earth, sun: Floats, edge: float, clouds: float
) -> float:
    """Radiance of Earth and air in one unit direction; `clouds` is the contrast they have."""
    distance = earth.distance
    radius = math.asin(1.0 / distance)
    air = AIR_HEIGHT_KM / EARTH_RADIUS_KM / math.sqrt(distance * distance - 1.0)
    e = earth.direction
    along = dx * e[0] + dy * e[1] + dz * e[2]
    beyond = math.acos(min(max(along, -1.0), 1.0)) - radius
    if beyond > 12.0 * air + edge:
        return 0.0
    middle = along * distance
    root = middle * middle - (distance * distance - 1.0)
    ray = middle - math.sqrt(max(root, 0.0))
    nx, ny, nz = ray * dx - distance * e[0], ray * dy - distance * e[1], ray * dz - distance * e[2]
    length = math.sqrt(nx * nx + ny * ny + nz * nz)
    lit = max((nx * sun[0] + ny * sun[1] + nz * sun[2]) / length, 0.0)
    ground = min(max(0.5 - beyond / edge, 0.0), 1.0)
    value = (1.0 - ground) * AIR_BRIGHTNESS * math.exp(-max(beyond, 0.0) / air)
    if ground > 0.0:
        cloud = 0.5
        if clouds > 0.0:
            x, y, z = nx / CLOUD_SIZE + 31.0, ny / CLOUD_SIZE + 17.0, nz / CLOUD_SIZE + 5.0
            cloud = 0.5 * noise(x, y, z)
            cloud += 0.3 * noise(3.1 * x, 3.1 * y, 3.1 * z) + 0.2 * noise(9.7 * x, 9.7 * y, 9.7 * z)
        value += ground * (1.0 + clouds * 2.0 * (cloud - 0.5))
    out: float = earth.strength * lit * value
    return out


@kernel()
def mirrored(dx: float, dy: float, dz: float, alpha: float, sky: Sky) -> float:
    """Radiance of the sky as a mirror of roughness `alpha` (GGX) shows it where it reflects (dx, dy, dz).

    A rough mirror shows a blurred Earth: its limb over LOBE · alpha, the width of the lobe, and no clouds
    where they are smaller than that.
    """
    if sky.earth.distance == 0.0:
        return sky.even
    edge = max(SHARP_LIMB_RAD, LOBE * alpha)
    clouds = CLOUD_CONTRAST * max(0.0, 1.0 - edge / (4.0 * CLOUD_SIZE))
    return sky.even + earth_along(dx, dy, dz, sky.earth, sky.sun, edge, clouds)


def irradiance(sky: Sky) -> Floats:
    """Nine numbers (9,) from which `light_from` gives the sky's light on a face; the sun is not in it.

    Ramamoorthi and Hanrahan, "An Efficient Representation for Irradiance Environment Maps" (2001): second
    order spherical harmonics tell the light on a Lambert face within some per cent. Nothing shadows it.
    """
    index = np.arange(DIRECTIONS) + 0.5
    z = 1.0 - 2.0 * index / DIRECTIONS
    around = index * math.pi * (3.0 - math.sqrt(5.0))
    across = np.sqrt(1.0 - z * z)
    directions = np.stack([across * np.cos(around), across * np.sin(around), z], axis=1)
    radiance = np.full(DIRECTIONS, sky.even)
    if sky.has_earth:
        radiance = earth_radiance(directions, sky.earth, sky.sun, SHARP_LIMB_RAD)
    basis = np.stack([harmonics(*direction) for direction in directions])
    out: Floats = (4.0 * math.pi / DIRECTIONS) * (radiance @ basis)
    out[1:4] *= 2.0 / 3.0
    out[4:] *= 0.25
    return out


@kernel()
def harmonics(x: float, y: float, z: float) -> Floats:
    """Real spherical harmonics (9,) up to the second order in a unit direction."""
    return np.array(
        (
            0.28209479,
            0.48860251 * y,
            0.48860251 * z,
            0.48860251 * x,
            1.09254843 * x * y,
            1.09254843 * y * z,
            0.31539157 * (3.0 * z * z - 1.0),
            1.09254843 * x * z,
            0.54627422 * (x * x - y * y),
        )
    )


@kernel()
def light_from(sky: Floats, x: float, y: float, z: float) -> float:
    """Radiance that the sky of `irradiance` gives a white face with unit normal (x, y, z)."""
    out = (
        0.28209479 * sky[0]
        + 0.48860251 * (sky[1] * y + sky[2] * z + sky[3] * x)
        + 1.09254843 * (sky[4] * x * y + sky[5] * y * z + sky[7] * x * z)
        + 0.31539157 * sky[6] * (3.0 * z * z - 1.0)
        + 0.54627422 * sky[8] * (x * x - y * y)
    )
    value: float = max(out, 0.0)
    return value


def seen(sky: Sky, camera: Camera, rng: np.random.Generator) -> Field | None:
    """Image (H, W) float32 of the sky where nothing stands before it; None where it is black."""
    pixel = 1.0 / math.sqrt(camera.fx * camera.fy)
    sun_shows = _sun_in_view(sky, camera)
    if not sun_shows and not sky.has_earth and sky.star_brightness == 0:
        return None
    image = np.zeros((camera.height, camera.width), np.float32)
    if sky.star_brightness > 0:
        image += _stars(sky, camera, rng)
    for top in range(0, camera.height, BAND_ROWS):
        rows = np.arange(top, min(top + BAND_ROWS, camera.height))
        rays = pixel_rays(camera, rows, np.arange(camera.width)).astype(np.float64)
        units = rays / np.linalg.norm(rays, axis=1)[:, None]
        band = image[rows]
        if sun_shows:
            angle = np.arccos(np.clip(units @ sky.sun, -1.0, 1.0))
            band += _sun_disc(sky, angle, pixel).reshape(band.shape).astype(np.float32)
        if sky.has_earth:
            earth = earth_radiance(units, sky.earth, sky.sun, pixel)
            before = (units @ sky.earth.direction > math.cos(sky.earth.radius_rad)).reshape(band.shape)
            band[before] = 0.0
            band += earth.reshape(band.shape).astype(np.float32)
        image[rows] = band
    return image


def _sun_in_view(sky: Sky, camera: Camera) -> bool:
    if sky.sun_radius_rad == 0 or sky.sun[2] <= 0:
        return False
    x, y = camera.project(sky.sun[None])[0]
    margin = 2.0 + 2.0 * sky.sun_radius_rad * max(camera.fx, camera.fy)
    return bool(-margin < x < camera.width + margin and -margin < y < camera.height + margin)


def _sun_disc(sky: Sky, angle: Floats, pixel: float) -> Floats:
    """Radiance of the sun's disc at angles (N,) from its middle; all of it together gives `sun_strength`."""
    radius = sky.sun_radius_rad
    share = np.clip((radius - angle) / pixel + 0.5, 0.0, 1.0)
    depth = np.sqrt(np.clip(1.0 - (angle / radius) ** 2, 0.0, 1.0))
    mean = 1.0 - LIMB_DARKENING / 3.0  # of the darkened disc
    out: Floats = sky.sun_strength / math.sin(radius) ** 2 / mean * share
    return out * (1.0 - LIMB_DARKENING * (1.0 - depth))


def _stars(sky: Sky, camera: Camera, rng: np.random.Generator) -> Field:
    """Stars as points, each spread over the four pixels nearest to it."""
    direction = rng.normal(size=(STARS, 3))
    faint = STARS_PER_MAGNITUDE ** (BRIGHTEST - FAINTEST)
    magnitude = FAINTEST + np.log(rng.uniform(faint, 1.0, STARS)) / math.log(STARS_PER_MAGNITUDE)
    front = direction[:, 2] > 1e-3
    pixels = camera.project(direction[front])
    # light on a face over a pixel's solid angle is a radiance; pi makes it relative to a white face
    strength = sky.star_brightness * STAR_TO_SUN * math.pi * sky.sun_strength * camera.fx * camera.fy
    value = strength * 10.0 ** (-0.4 * magnitude[front])
    image = np.zeros((camera.height, camera.width), np.float32)
    low = np.floor(pixels).astype(int)
    share = pixels - low
    for dx, dy in ((0, 0), (1, 0), (0, 1), (1, 1)):
        x, y = low[:, 0] + dx, low[:, 1] + dy
        weight = np.abs(1 - dx - share[:, 0]) * np.abs(1 - dy - share[:, 1])
        inside = (x >= 0) & (x < camera.width) & (y >= 0) & (y < camera.height)
        np.add.at(image, (y[inside], x[inside]), (value * weight)[inside])
    return image
