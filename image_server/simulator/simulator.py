"""The simulated device: traces each geometry once, then mixes and exposes."""

import time
from collections import OrderedDict
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from bridge.errors import BadInput
from bridge.messages import (
    Describe,
    LightDescription,
    PoseErrorMessage,
    PoseMessage,
    Settings,
    TargetDescription,
)
from geometry.camera import Camera
from geometry.errors import GeometryError
from geometry.model import find_target, load_model
from geometry.pose import Pose
from image_server.device import Change, Device, Frame, checked_settings
from image_server.replay import level_fraction, pose_error
from image_server.sensor import exposed, mixed
from image_server.simulator import placement
from image_server.simulator.material import load_appearance
from image_server.simulator.scenario import Scenario, load_scenario
from image_server.simulator.scene import background_parts, joined, target_part
from image_server.simulator.tracing import Illumination, traced

POSE, SEED_POSE, SUN, BACKGROUND, MOVES = range(1, 6)
"""Streams of random numbers, so that one draw more in one place changes nothing elsewhere."""
KEPT_GEOMETRIES = 4  # focal lengths, mostly
LEAST_RANGE_DIAMETERS = 0.5  # a target nearer than this would contain the camera

Radiances = list[NDArray[np.float32]]


class Simulator(Device):
    """A ray-traced target with lights and a sun.

    Parameters
    ----------
    target : a name of `targets/`, or a model file.
    scenario : a scenario, or the name or file of one.
    seed : draws poses, sun, background and noise.
    unit : of the model file.

    Raises
    ------
    BadInput : a target or scenario that cannot be used.
    """

    name = "simulator"

    def __init__(
        self,
        target: str | Path = "cube",
        scenario: Scenario | str = "nominal",
        seed: int = 0,
        unit: str = "m",
    ) -> None:
        self._scenario = load_scenario(scenario) if isinstance(scenario, str) else scenario
        self._seed = seed
        try:
            self._file = find_target(str(target)).resolve()
            self._model = load_model(self._file, unit)
        except GeometryError as error:
            raise BadInput(f"{error}.") from None
        self._unit = unit
        self._appearance = load_appearance(self._file, len(self._model.faces))
        table = self._scenario.camera
        self._camera = Camera(
            table.width, table.height, table.fx, table.fy, table.cx, table.cy, table.distortion
        )
        self._sensor = table.sensor()
        front = np.array(self._appearance.front)
        self._true = placement.drawn_pose(
            self._scenario.pose, self._model, front, self._camera, self._random(POSE)
        )
        self._first_seed_pose: Pose | None = placement.seed_pose_of(
            self._true, self._camera, self._scenario.pose.search_fraction, self._random(SEED_POSE)
        )
        self._sun = placement.drawn_sun(self._scenario.sun, self._model, self._true, self._random(SUN))
        self._ambient_scale = self._scenario.ambient_scale
        self._focal_mm = table.focal_lengths_mm[0] if table.focal_lengths_mm else None
        self._captures = 0
        self._moves = 0
        self._traced: OrderedDict[float | None, Radiances] = OrderedDict()

    @property
    def true_pose(self) -> Pose:
        """The true pose, for tests and benchmarks; no reply of a server tells it."""
        return self._true

    @property
    def seed_pose(self) -> Pose | None:
        """Where the target is said to be; None after a move."""
        return self._first_seed_pose

    def describe(self) -> Describe:
        """Settings, camera at the focal length in use, target and seed pose."""
        scenario = self._scenario
        camera = self._zoomed(self._focal_mm)
        pose = self._first_seed_pose
        return Describe(
            device=self.name,
            lights=tuple(
                LightDescription(
                    name=light.name,
                    levels=light.levels,
                    position=light.position,
                    power=light.power * scenario.light_power,
                )
                for light in scenario.lights
            ),
            shutters_s=scenario.camera.shutters_s,
            apertures=scenario.camera.apertures,
            focal_lengths_mm=scenario.camera.focal_lengths_mm,
            focuses_m=None,
            camera=msgspec.structs.replace(scenario.camera.description(), fx=camera.fx, fy=camera.fy),
            target=TargetDescription(
                model=str(self._file),
                unit=self._unit,  # type: ignore[arg-type]  # load_model has checked it
                seed_pose=None if pose is None else _message(pose),
            ),
            movable=True,
        )

    def capture(self, settings: Settings) -> Frame:
        """Mix the traced images of this geometry and expose; the first capture of a geometry traces it."""
        applied = checked_settings(self.describe(), settings)
        if applied.focal_length_mm is not None:
            self._focal_mm = applied.focal_length_mm
        radiance = self.radiance(applied.lights)
        self._captures += 1
        pixels = exposed(
            radiance, self._sensor, applied.shutter_s, applied.aperture, (self._seed, self._captures)
        )
        return Frame(
            pixels=pixels,
            requested=settings,
            applied=applied,
            verified=True,
            sequence=self._captures,
            timestamp=time.time(),
            devices={"camera": "simulator", "lights": "simulator"},
        )

    def radiance(self, levels: tuple[int, ...]) -> NDArray[np.float32]:
        """Linear radiance (H, W) float32 without blur and noise; 1 clips at 1/60 s, f/4 and gain 1."""
        weights = [
            light.power * self._scenario.light_power * level_fraction(level, light.levels)
            for light, level in zip(self._scenario.lights, levels, strict=True)
        ]
        return mixed(self.basis(), [*weights, self._ambient_scale])

    def basis(self) -> Radiances:
        """Radiance images of this geometry: each light alone (full, power 1), then sun and earth-shine."""
        images = self._traced.get(self._focal_mm)
        if images is None:
            images = self._trace(self._zoomed(self._focal_mm))
            self._traced[self._focal_mm] = images
            if len(self._traced) > KEPT_GEOMETRIES:
                self._traced.popitem(last=False)
        return images

    def health(self) -> dict[str, Any]:
        """A simulator does not fall ill."""
        return {"status": "ok", "captures": self._captures, "moves": self._moves}

    def move(self, range_m: float) -> list[Change]:
        """Bring the target to a range along its line of sight; errors and the new sun come from the seed.

        Raises
        ------
        BadInput : so near that the target would touch the camera.
        """
        least = LEAST_RANGE_DIAMETERS * self._model.diameter
        if range_m < least:
            raise BadInput(
                f"The target cannot come to {range_m:g} m: it is {self._model.diameter:.2g} m large.",
                f"Allowed: {least:.2g} m or more.",
            )
        rng = self._random(MOVES, self._moves)
        move = self._scenario.move
        self._true = placement.moved_pose(self._true, range_m, move, rng)
        self._first_seed_pose = None
        self._moves += 1
        self._traced.clear()
        changes = [Change("target_moved", {"range_m": range_m})]
        if move.sun_turn_deg > 0 or move.sun_factor != (1.0, 1.0):
            self._sun = placement.turned_sun(self._sun, move.sun_turn_deg, rng)
            self._ambient_scale *= rng.uniform(*move.sun_factor)
            changes.append(Change("sun_changed"))
        return changes

    def score(self, pose: PoseMessage) -> PoseErrorMessage:
        """Error against the true pose."""
        return pose_error(pose, _message(self._true))

    def _trace(self, camera: Camera) -> Radiances:
        scenario = self._scenario
        parts = [target_part(self._model, self._appearance, scenario.target, self._true)]
        parts += background_parts(
            scenario.background, camera, self._true, self._model.diameter, self._random(BACKGROUND)
        )
        illumination = Illumination(
            lights=np.array([light.position for light in scenario.lights]),
            sun=self._sun,
            sun_radius_rad=np.radians(scenario.sun.angular_diameter_deg) / 2,
            earthshine=scenario.sun.earthshine,
        )
        return traced(joined(parts), camera, illumination)

    def _zoomed(self, focal_mm: float | None) -> Camera:
        """The camera at a focal length; fx and fy grow in proportion to it."""
        focals = self._scenario.camera.focal_lengths_mm
        if focal_mm is None or not focals:
            return self._camera
        factor = focal_mm / focals[0]
        c = self._camera
        return Camera(c.width, c.height, c.fx * factor, c.fy * factor, c.cx, c.cy, c.distortion)

    def _random(self, *stream: int) -> np.random.Generator:
        return np.random.default_rng([self._seed, *stream])


def _message(pose: Pose) -> PoseMessage:
    plain = pose.to_dict()
    return msgspec.convert(plain, PoseMessage)
