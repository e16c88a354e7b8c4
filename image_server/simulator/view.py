"""A view: what one geometry looks like under a scenario's lights and sky, before aperture and sensor."""

import math
from dataclasses import dataclass

import cv2
import numpy as np

from geometry.camera import Camera
from image_server.simulator.lens import glared, vignette
from image_server.simulator.light import SUN_STRENGTH, Illumination, beam_table
from image_server.simulator.scenario_tables import Scenario
from image_server.simulator.scene import TARGET, Scene
from image_server.simulator.sky import EARTH_RADIUS_KM, NO_EARTH, Earth, Sky, seen
from image_server.simulator.tracing import traced
from numerics.arrays import Field, Floats

Radiances = list[Field]


@dataclass(frozen=True, eq=False)
class TracedView:
    """Linear images of one geometry.

    Attributes
    ----------
    images : (H, W) float32, each light alone (full, power 1), then sun, Earth and stars.
    inverse_depth : (H, W) float32, 1/m, 0 where nothing is near.
    target_depth : the same of the target alone.
    """

    images: Radiances
    inverse_depth: Field
    target_depth: Field

    @property
    def size_bytes(self) -> int:
        """Memory that it takes."""
        return (len(self.images) + 2) * self.inverse_depth.nbytes


def rendered(
    scenario: Scenario, scene: Scene, camera: Camera, sun: Floats, rng: np.random.Generator
) -> TracedView:
    """Trace the scene, put the sky behind it, and let the lens darken and scatter it.

    `sun` (3,) is the unit vector towards it; the generator draws the stars.
    """
    sky = sky_of(scenario, sun)
    trace = traced(scene, camera, illumination(scenario, sky))
    images = trace.images
    backdrop = seen(sky, camera, rng)
    if backdrop is not None:
        images[-1] += (np.float32(1.0) - trace.coverage) * backdrop
    lens = scenario.camera
    if lens.vignetting > 0:
        factor = vignette(camera, lens.vignetting)
        for image in images:
            cv2.multiply(image, factor, dst=image)
    if lens.glare > 0:
        images = [glared(image, lens.glare) for image in images]
    return TracedView(
        images, trace.inverse_depth, np.where(trace.part == TARGET, trace.inverse_depth, np.float32(0))
    )


def sky_of(scenario: Scenario, sun: Floats) -> Sky:
    """The sky of a scenario with its sun in a direction."""
    table, earth = scenario.sun, NO_EARTH
    if scenario.earth is not None:
        direction = _unit(np.array(scenario.earth.direction))
        distance = 1.0 + scenario.earth.altitude_km / EARTH_RADIUS_KM
        earth = Earth(direction, distance, SUN_STRENGTH * scenario.earth.albedo)
    return Sky(
        sun=sun,
        sun_radius_rad=math.radians(table.angular_diameter_deg) / 2,
        sun_strength=SUN_STRENGTH,
        even=SUN_STRENGTH * table.earthshine if scenario.earth is None else 0.0,
        earth=earth,
        star_brightness=scenario.background.star_brightness,
    )


def illumination(scenario: Scenario, sky: Sky) -> Illumination:
    """Lights and sky of a scenario, ready for tracing."""
    lights = scenario.lights
    return Illumination(
        lights=np.array([light.position for light in lights]),
        aims=np.array([_unit(np.array(light.aim)) for light in lights]),
        beams=np.stack([beam_table(light) for light in lights]),
        sky=sky,
    )


def _unit(vector: Floats) -> Floats:
    out: Floats = vector / np.linalg.norm(vector)
    return out
