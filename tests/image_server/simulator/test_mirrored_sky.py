"""The Earth as metal and foil mirror it."""

import msgspec
import numpy as np
import pytest

from image_server.simulator.material import MaterialChanges
from image_server.simulator.scenario import load_scenario
from image_server.simulator.shading import microfacets
from image_server.simulator.simulator import Simulator
from image_server.simulator.sky import Earth, Sky, earth_radiance, mirrored

pytestmark = pytest.mark.slow


def lobe(n: np.ndarray, v: np.ndarray, alpha: float, reflectance: float, sky: Sky, side: int = 60) -> float:
    """The sky that a GGX face mirrors: its integral over half vectors, drawn as the facets lie."""
    first, second = (grid.ravel() for grid in np.meshgrid(*[(np.arange(side) + 0.5) / side] * 2))
    lean, around = np.arctan(alpha * np.sqrt(first / (1 - first))), 2 * np.pi * second
    u = np.cross(n, np.eye(3)[np.argmin(np.abs(n))])
    u /= np.linalg.norm(u)
    flat = np.outer(np.cos(around), u) + np.outer(np.sin(around), np.cross(n, u))
    h = np.sin(lean)[:, None] * flat + np.cos(lean)[:, None] * n
    vh, nh, nv = h @ v, h @ n, float(n @ v)
    light = 2 * vh[:, None] * h - v
    nl = light @ n
    radiance = sky.even + earth_radiance(light, sky.earth, sky.sun, 1e-3)
    total = 0.0
    for i in np.flatnonzero((nl > 0) & (vh > 0)):
        facets = alpha**2 / (np.pi * (nh[i] ** 2 * (alpha**2 - 1) + 1) ** 2) * nh[i] / (4 * vh[i])
        value = microfacets(nl[i], nv, nh[i], vh[i], alpha, reflectance) / np.pi
        total += radiance[i] * value * nl[i] / facets
    return total / len(nl)


@pytest.mark.parametrize("roughness", [0.1, 0.2, 0.3])
def test_metal_mirrors_the_earth(roughness: float) -> None:
    """Against the integral over the facets, in many directions; a blurred limb stands for it."""
    alpha, rng = roughness**2, np.random.default_rng(0)
    earth, sun = (
        np.array(vector) / np.linalg.norm(vector) for vector in ((0.15, 0.97, 0.25), (-0.4, -0.5, -0.77))
    )
    sky = Sky(sun=sun, sun_radius_rad=0.005, sun_strength=0.5, even=0.01, earth=Earth(earth, 1.06, 0.5 * 0.3))
    ours, true = [], []
    while len(ours) < 40:
        n, v = (vector / np.linalg.norm(vector) for vector in rng.normal(size=(2, 3)))
        if n @ v > 0.25:
            r = 2 * (n @ v) * n - v
            seen = mirrored(*r, alpha, sky)
            ours.append((0.8 + 0.2 * (1 - n @ v) ** 5) * seen)
            true.append(lobe(n, v, alpha, 0.8, sky))
    assert np.mean(ours) == pytest.approx(np.mean(true), rel=0.12)
    assert np.corrcoef(ours, true)[0, 1] > 0.97


def test_a_polished_target_shows_the_earth_and_a_dull_one_does_not() -> None:
    scenario = load_scenario("earth-limb")
    images = []
    for specular in (0.0, 0.9):
        changes = MaterialChanges(albedo=0.0, specular=specular, roughness=0.1)
        images.append(Simulator("cube", msgspec.structs.replace(scenario, target=changes), 1))
    dull, polished = (simulator.basis()[-1] for simulator in images)
    target = images[0]._view().target_depth > 0
    assert np.median(dull[target]) < 0.002  # Fresnel: only grazing faces mirror without being polished
    assert np.percentile(polished[target], 95) > 0.02 + np.percentile(dull[target], 95)
