"""Scenes in which something goes wrong that no one tells: their devices, and what a fault does to a picture.

A scene is a stack folder (kind basis) or a scenario of the simulator (target: cube).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from functools import lru_cache
from itertools import combinations
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import msgspec
import numpy as np
import typer

from bridge.image_messages import PoseErrorMessage
from bridge.messages import Describe, LightDescription, PoseMessage, Settings
from geometry.camera import Camera
from geometry.model import load_model
from geometry.pose import Pose
from image_server.replay import Replay, pose_error
from image_server.serve.device import Device, Frame
from image_server.simulator.description import pose_message
from image_server.simulator.scenario import load_scenario
from image_server.simulator.scenario import with_conditions as scenario_with
from image_server.simulator.simulator import Simulator
from numerics.arrays import Flags, Grey
from stack.exposure import level_fraction
from stack.read import BasisStack, load_stack
from stack.read import with_conditions as stack_with
from vision_server.serve.statistics import target_region

Lights = Sequence[LightDescription]

KINDS = ("light_dead", "lights_swapped", "sun_changed", "target_moved", "in_the_way", "model_wrong")
FLICKER = "flicker"  # no fault: all light of each image is another
FLICKERS_BY = 0.15  # more or less
MOVED = 0.01  # of the range
SUNS = (0.0, 0.25, 4.0)  # times what it was; from nothing to FIRST_SUN
FIRST_SUN = 4.0
STRETCHED = 1.02  # a model's axis
ARM_WIDTH, ARM_ASIDE = 0.2, 0.25  # of the target's extent in the picture: how wide, how far from its middle
ARM_GREY, ARM_NOISE = 0.8, 1.5  # beside the target's median; grey
EDGE_PX = 0.8  # standard deviation of an arm's edge


class Fault(NamedTuple):
    """What is planted: its name, as it would be said; the lights it is about; the sun's strength then.

    ``towards_rad`` is the direction in the picture in which a target moves, or an arm reaches.
    """

    name: str
    lights: tuple[int, ...] = ()
    sun: float | None = None
    towards_rad: float = 0.0


def scene_device(scene: str, seed: int, sun: float | None = None, times: float = 1.0) -> tuple[Device, float]:
    """The device of a scene under its sun or this one, all light so many times; its own sun's strength."""
    if not Path(scene).is_dir():
        scenario = load_scenario(scene)
        strength = scenario.ambient_scale if sun is None else sun
        changed = scenario_with(scenario, ambient_scale=times * strength, light_power=times)
        return Simulator("cube", changed, seed), scenario.ambient_scale
    stack = _loaded(scene)
    strength = stack.table.ambient_scale if sun is None else sun
    return Replay(stack_with(stack, times * strength, times), seed), stack.table.ambient_scale


opened = lru_cache(16)(scene_device)
"""The same, one for each scene: its images are those of the number that it is brought to."""


@lru_cache(2)
def _loaded(folder: str) -> BasisStack:
    stack = load_stack(Path(folder))
    if not isinstance(stack, BasisStack):
        raise typer.BadParameter(f"{folder} holds recorded frames: nothing can be planted in them.")
    return stack


def true_pose(scene: str, device: Device) -> Pose:
    """For measurements only."""
    if isinstance(device, Simulator):
        return device.true_pose
    told = _loaded(scene).table.target.true_pose
    if told is None:
        raise typer.BadParameter(f"{scene} does not know its true pose.")
    return Pose.of(told)


def camera_and_region(describe: Describe, true: Pose) -> tuple[Camera, Flags]:
    """The camera, and where the target is in its picture, bool (H, W)."""
    assert describe.camera is not None and describe.target is not None
    camera = Camera.from_dict(msgspec.to_builtins(describe.camera))
    return camera, target_region(load_model(describe.target.model, describe.target.unit), camera, true)


def drawn(
    kind: str, settings: Settings, sun: float, lights: Lights, rng: np.random.Generator
) -> Fault | None:
    """A fault of one of KINDS; None where a light's would make no difference under these settings."""
    lit = [index for index, level in enumerate(settings.lights) if level > 0]
    pairs = [
        pair
        for pair in combinations(range(len(settings.lights)), 2)
        if relit(settings, Fault("lights_swapped", pair), lights) != settings
    ]
    if kind == "light_dead":
        return Fault(kind, (int(rng.choice(lit)),)) if lit else None
    if kind == "lights_swapped":
        return Fault(kind, pairs[rng.integers(len(pairs))]) if pairs else None
    if kind == "sun_changed":
        return Fault(kind, sun=float(rng.choice(SUNS)) * sun if sun > 0.0 else FIRST_SUN)
    return Fault(kind, towards_rad=rng.uniform(0.0, 2.0 * np.pi))


def relit(settings: Settings, fault: Fault, lights: Lights) -> Settings:
    """What the lights really do when these settings are asked for.

    Swapped ones have the level that is nearest to the other's share of its full light.
    """
    levels = list(settings.lights)
    if fault.name == "light_dead":
        levels[fault.lights[0]] = 0
    if fault.name == "lights_swapped":
        one, other = fault.lights
        for light, instead in ((one, other), (other, one)):
            share = level_fraction(settings.lights[instead], lights[instead].levels)
            levels[light] = round(share * (lights[light].levels - 1))
    return msgspec.structs.replace(settings, lights=tuple(levels))


def turned(fault: Fault) -> Pose:
    """How a target moves: about the camera, by MOVED of its range, so that a picture can show it exactly."""
    axis = np.array([-np.sin(fault.towards_rad), np.cos(fault.towards_rad), 0.0])
    return Pose(MOVED * axis, np.zeros(3))


def pictured(pixels: Grey, camera: Camera, region: Flags, fault: Fault, number: int) -> Grey:
    """A picture (H, W) after a fault that is not of light; the target is in a region (H, W)."""
    if fault.name == "target_moved":
        matrix = np.array([[camera.fx, 0.0, camera.cx], [0.0, camera.fy, camera.cy], [0.0, 0.0, 1.0]])
        shift = matrix @ turned(fault).matrix @ np.linalg.inv(matrix)
        size = pixels.shape[::-1]
        moved = cv2.warpPerspective(
            pixels, shift, size, flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE
        )
        return np.asarray(moved, dtype=np.uint8)
    if fault.name == "in_the_way":
        return with_arm(pixels, region, fault.towards_rad, np.random.default_rng(number))
    return pixels


def with_arm(pixels: Grey, region: Flags, towards_rad: float, rng: np.random.Generator) -> Grey:
    """A round bar across the target, as bright as it is in the median, darker towards its own sides."""
    rows, columns = np.nonzero(region)
    extent = float(max(np.ptp(rows), np.ptp(columns)))
    along = np.array([np.cos(towards_rad), np.sin(towards_rad)])
    across = np.array([-along[1], along[0]])
    grid = np.indices(pixels.shape)[::-1].transpose(1, 2, 0)
    aside = (grid - [columns.mean(), rows.mean()]) @ across / extent - ARM_ASIDE * np.cos(3.0 * towards_rad)
    round_ = np.sqrt(np.maximum(1.0 - (2.0 * aside / ARM_WIDTH) ** 2, 0.0))
    bright = ARM_GREY * float(np.median(pixels[region])) * (0.3 + 0.7 * round_)
    share = cv2.GaussianBlur((np.abs(aside) < 0.5 * ARM_WIDTH).astype(np.float64), (0, 0), EDGE_PX)
    arm = bright + rng.normal(0.0, ARM_NOISE, pixels.shape)
    return np.asarray(np.clip(np.rint(pixels + share * (arm - pixels)), 0, 255), dtype=np.uint8)


class Planted(Device):
    """The device of a scene in which a fault of a kind, or nothing, happens before one of its images.

    A fault of light waits for the first image that it makes a difference to.

    Parameters
    ----------
    scene, seed : which; the seed draws what the fault is about, too.
    kind : one of KINDS, FLICKER, or "nothing".
    before : number of the first image after it. A wrong model is wrong, and light flickers, from the start.
    folder : where a wrong model is written.
    """

    def __init__(self, scene: str, seed: int, kind: str, before: int, folder: Path) -> None:
        self.name = "planted"
        self.fault: Fault | None = None
        self._scene, self._seed, self._kind, self._before = scene, seed, kind, before
        self._device, self._sun = scene_device(scene, seed)
        self._after: Device | None = None
        self._rng = np.random.default_rng([seed, before])
        self._taken = 0
        self._describe = self._device.describe()
        self.true = true_pose(scene, self._device)
        self._camera, self._region = camera_and_region(self._describe, self.true)
        if kind == FLICKER:
            self.fault = Fault(kind)
        if kind == "model_wrong":
            axis = int(self._rng.integers(3))
            self.fault = Fault(kind)
            self._describe = with_stretched_model(self._describe, axis, folder)

    def describe(self) -> Describe:
        """As the scene's, but for a wrong model."""
        return self._describe

    def come_to(self, number: int) -> None:
        """As before the capture of this number."""
        self._taken = number - 1

    def capture(self, settings: Settings) -> Frame:
        """A frame, after a fault perhaps; what is said to be applied is what was asked for."""
        self._taken += 1
        if self.fault is None and self._kind != "nothing" and self._taken >= self._before:
            self._happen(settings)
        device, asked = self._device, settings
        if self.fault is not None:
            device, asked = self._after or device, relit(settings, self.fault, self._describe.lights)
        if self._kind == FLICKER:
            times = self._rng.uniform(1.0 - FLICKERS_BY, 1.0 + FLICKERS_BY)
            device = scene_device(self._scene, self._seed, times=times)[0]
        device.come_to(self._taken)
        frame = device.capture(asked)
        pixels = np.asarray(frame.pixels, dtype=np.uint8)
        if self.fault is not None:
            pixels = pictured(pixels, self._camera, self._region, self.fault, self._taken)
        applied = msgspec.structs.replace(frame.applied, lights=settings.lights)
        return dataclasses.replace(frame, pixels=pixels, requested=settings, applied=applied)

    def _happen(self, settings: Settings) -> None:
        self.fault = drawn(self._kind, settings, self._sun, self._describe.lights, self._rng)
        if self.fault is not None and self.fault.sun is not None:
            self._after = scene_device(self._scene, self._seed, self.fault.sun)[0]
        if self.fault is not None and self.fault.name == "target_moved":
            move = turned(self.fault)
            self.true = Pose.from_matrix(move.matrix @ self.true.matrix, move.matrix @ self.true.translation)

    def health(self) -> dict[str, Any]:
        """Sound."""
        return {"status": "ok", "captures": self._taken}

    def score(self, pose: PoseMessage, moves: int | None = None) -> PoseErrorMessage | None:
        """Error against the true pose of now."""
        target = self._describe.target
        assert target is not None
        return pose_error(pose, pose_message(self.true), load_model(target.model, target.unit))


def with_stretched_model(describe: Describe, axis: int, folder: Path) -> Describe:
    """A description whose model, a .cao file of points and polygons, is longer along one axis."""
    assert describe.target is not None
    file = Path(describe.target.model)
    if file.suffix != ".cao":
        raise typer.BadParameter(f"{file} is no .cao file: it cannot be stretched.")
    lines = file.read_text().splitlines()
    at = next(number for number, line in enumerate(lines) if line.strip().isdigit())
    left = int(lines[at])
    for number in range(at + 1, len(lines)):
        words = lines[number].split("#")[0].split()
        if len(words) == 3 and left > 0:
            values = [float(word) * (STRETCHED if k == axis else 1.0) for k, word in enumerate(words)]
            lines[number] = " ".join(f"{value:.9g}" for value in values)
            left -= 1
    longer = folder / file.name
    longer.write_text("\n".join(lines) + "\n")
    return msgspec.structs.replace(
        describe, target=msgspec.structs.replace(describe.target, model=str(longer))
    )
