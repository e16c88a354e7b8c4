"""Photographs with a known true pose: recorded light stacks under any sun, simulated scenes, image files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import msgspec
import numpy as np

from bridge.messages import Settings
from geometry.camera import Camera
from geometry.model import Model, find_target, load_model
from geometry.pose import Pose
from image_server.replay import Replay
from image_server.serve.device import Device
from image_server.simulator.simulator import Simulator
from numerics.arrays import Grey
from stack.exposure import full_levels, relative_exposure
from stack.read import BasisStack, load_stack
from vision_server.channels.image_files import read_grey
from vision_server.channels.tone import KNOWN_TONE_SD_PX, file_tone
from vision_server.image_set import ImageSet
from vision_server.serve.inputs import read_camera


@dataclass(frozen=True, eq=False)
class Photograph:
    """One image with what is known of it.

    Attributes
    ----------
    pixels
        uint8 (H, W).
    exposure, gamma, tone_sd_px
        As the vision server takes them.
    true
        camera_T_target.
    number
        Its own, for random draws.
    """

    pixels: Grey
    exposure: float
    gamma: float
    tone_sd_px: float
    camera: Camera
    model: Model
    true: Pose
    number: int


def image_set(photographs: Sequence[Photograph]) -> ImageSet:
    """The photographs as one set: i0, i1, ..."""
    camera = photographs[0].camera
    images = ImageSet(camera.width, camera.height)
    for number, one in enumerate(photographs):
        images.add(f"i{number}", one.pixels, one.exposure, one.gamma)
    return images


@dataclass(frozen=True, eq=False)
class Studio:
    """A device that photographs one target in a known pose, under any settings."""

    name: str
    device: Device
    camera: Camera
    model: Model
    true: Pose

    @property
    def middle(self) -> tuple[int, ...]:
        """All lights at middle level."""
        return tuple(light.levels // 2 for light in self.device.describe().lights)

    def full(self, only: int) -> tuple[int, ...]:
        """One light at its highest level, the others off."""
        return full_levels(self.device.describe().lights, only)

    def photograph(
        self, lights: tuple[int, ...], shutter_s: float | None = None, aperture: float | None = None
    ) -> Photograph:
        """An image under these lights; shutter and aperture are the reference ones unless given."""
        described = self.device.describe()
        reference = described.reference
        assert described.camera is not None
        settings = Settings(
            lights=lights, shutter_s=shutter_s or reference.shutter_s, aperture=aperture or reference.aperture
        )
        relative = relative_exposure(settings.shutter_s, settings.aperture, reference)
        return Photograph(
            pixels=self.device.capture(settings).pixels,
            exposure=relative * described.camera.gain,
            gamma=described.camera.gamma,
            tone_sd_px=KNOWN_TONE_SD_PX,
            camera=self.camera,
            model=self.model,
            true=self.true,
            number=0,
        )


def stack_studio(folder: Path, sun: float | None = None) -> Studio:
    """A light stack with a true pose; ``sun`` instead of its own ambient_scale."""
    stack = load_stack(folder)
    if sun is not None:
        if not isinstance(stack, BasisStack):
            raise ValueError(f"{folder} holds frames; only a basis stack can be put under another sun")
        stack = replace(stack, table=msgspec.structs.replace(stack.table, ambient_scale=sun))
    target = stack.table.target
    if target.true_pose is None:
        raise ValueError(f"{folder} has no true pose to compare with")
    return Studio(
        name=folder.name,
        device=Replay(stack, 0),
        camera=Camera.from_dict(msgspec.to_builtins(stack.table.camera)),
        model=load_model(folder / target.model, target.unit),
        true=Pose.of(target.true_pose),
    )


def simulated_studio(target: str, scenario: str, seed: int) -> Studio:
    """A target of the project in a simulated scenario."""
    simulator = Simulator(target, scenario, seed)
    described = simulator.describe()
    assert described.camera is not None
    return Studio(
        name=f"{target} {scenario} {seed}",
        device=simulator,
        camera=Camera.from_dict(msgspec.to_builtins(described.camera)),
        model=load_model(find_target(target)),
        true=simulator.true_pose,
    )


def simulated(target: str, scenario: str, seed: int) -> Photograph:
    """All lights at middle level, reference exposure."""
    studio = simulated_studio(target, scenario, seed)
    return replace(studio.photograph(studio.middle), number=seed)


def middle_of_stack(folder: Path) -> Photograph:
    """All lights at middle level, reference exposure, the stack's own sun."""
    studio = stack_studio(folder)
    return studio.photograph(studio.middle)


@cache
def _folder(folder: Path) -> tuple[Camera, Model, float | None]:
    camera, table = read_camera(folder / "camera.toml")
    return camera, load_model(next(folder.glob("*.cao"))), table.get("gamma")


def recorded(folder: Path, index: int) -> Photograph:
    """An image of a folder with one 4x4 matrix per image (`Camera_L_*.txt`)."""
    file = sorted(folder.glob("Camera_L_*.txt"))[index]
    matrix = np.loadtxt(file)
    image = folder / f"{file.stem.removeprefix('Camera_L_')}_L.jpg"
    camera, model, gamma = _folder(folder)
    (exponent,), tone_sd_px = file_tone([image], gamma)
    true = Pose.from_matrix(matrix[:3, :3], matrix[:3, 3])
    return Photograph(read_grey(image), 1.0, exponent, tone_sd_px, camera, model, true, index)
