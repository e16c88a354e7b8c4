"""Recording a stack folder from a device, so that an evening in the laboratory becomes a repeatable test."""

import itertools
import shutil
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np

from bridge.command_line import counted
from bridge.errors import BadInput
from bridge.messages import Describe, Settings
from image_server.recording.linearity import Radiance, linear, measured_ratio, united
from image_server.serve.device import Change, Device, Frame, checked_settings
from numerics.arrays import Flags, Floats
from stack.exposure import WHITE, full_levels, level_fraction, relative_exposure
from stack.format import STACK_FILE
from stack.write import frames_stack, known_target, new_folder, write_basis

SATURATED = 254  # one below white, for noise
LARGEST_NONLINEARITY = 0.1
"""Part by which a shutter or level may be off its nominal effect; more, and a basis stack would mislead."""

OF_SCENE = ("target_moved", "sun_changed")
Progress = Callable[[str], None]


@dataclass(frozen=True)
class Recording:
    """What was recorded: how many frames, and how many of them the device could not verify."""

    frames: int
    unverified: int


class _Camera:
    """Captures, counted."""

    def __init__(self, device: Device, progress: Progress) -> None:
        self.device = device
        self.describe: Describe = device.describe()
        self.taken = self.unverified = 0
        self._progress = progress

    def capture(self, settings: Settings) -> Frame:
        frame = self.device.capture(settings)
        self.taken += 1
        self.unverified += not frame.verified
        self._progress(f"{self.taken}: lights {list(settings.lights)}, {settings.shutter_s:g} s")
        if frame.applied.lights != settings.lights:
            raise BadInput(
                f"A light died while recording: {list(settings.lights)} were asked for,"
                f" {list(frame.applied.lights)} are lit.",
                "Mend it, and record again.",
            )
        return frame

    def mean(self, settings: Settings, count: int) -> tuple[Floats, Flags]:
        """Mean of several frames, grey values (H, W), and where any of them is saturated."""
        total: Floats | None = None
        clipped: Flags | None = None
        for _ in range(count):
            pixels = self.capture(settings).pixels
            full = pixels >= SATURATED
            total = pixels.astype(np.float64) if total is None else total + pixels
            clipped = full if clipped is None else clipped | full
        assert total is not None
        assert clipped is not None
        return total / count, clipped


def record_frames(
    device: Device, folder: Path, settings: Sequence[Settings], repeat: int, progress: Progress
) -> Recording:
    """A stack of kind "frames": every setting, `repeat` times, as it came.

    Each frame is written when it has come. Where an error ends it, those that came before are a stack.

    Raises
    ------
    BadInput : before anything is taken: settings that the device does not offer, no calibration or target,
        a folder that cannot be used.
    DeviceError : the device failed.
    """
    camera = _Camera(device, progress)
    asked = [checked_settings(camera.describe, one) for one in settings]
    known_target(camera.describe)
    device.listen(lambda change: progress(f"event: {change.event}") if change.event in OF_SCENE else None)
    written = 0
    try:
        with _stack_in(folder), frames_stack(folder, camera.describe) as write:
            for one in [one for one in asked for _ in range(repeat)]:
                frame = camera.capture(one)
                write(frame.applied, frame.pixels)
                written += 1
    except BaseException:
        if written:
            progress(f"{folder} is a stack of the {counted(written, 'frame')} before")
        raise
    return Recording(camera.taken, camera.unverified)


def record_basis(
    device: Device, folder: Path, at: Settings, average: int, black: float, progress: Progress
) -> Recording:
    """A stack of kind "basis": the radiance of each light alone, and of everything else.

    Each light is recorded alone at full level, under every shutter; the frames with all lights off are
    subtracted from it, and are the ambient image less `black`. The tone curve is undone first.

    Parameters
    ----------
    at : aperture, focal length and focus; lights and shutter do not matter.
    average : frames per light and shutter.
    black : grey value of a frame that no light falls on.

    Raises
    ------
    BadInput : no lights, calibration or target, a scene that does not stand still, or a camera or light that
        is not linear; the message says which.
    """
    camera = _Camera(device, progress)
    describe = camera.describe
    known_target(describe)
    if not describe.lights:
        raise BadInput(f"The {describe.device} has no lights to record.", "Record frames instead.")
    at = checked_settings(describe, at)
    device.listen(_must_stand_still)
    with _stack_in(folder):
        off = (0,) * len(describe.lights)
        dark, _ = _radiance(camera, at, off, average, black)
        radiances = {}
        for number, light in enumerate(describe.lights):
            lit, means = _radiance(camera, at, full_levels(describe.lights, number), average, black)
            _check_shutters(camera, light.name, means, black)
            if light.levels > 2:
                _check_level(camera, at, number, means, average, black)
            radiances[light.name] = lit - dark
        write_basis(folder, describe, at.aperture, radiances, dark)
    return Recording(camera.taken, camera.unverified)


def _must_stand_still(change: Change) -> None:
    if change.event in OF_SCENE:
        raise BadInput(
            f"The scene does not stand still while it is recorded ({change.event}), as a basis has to.",
            "Record frames, or give a scenario without [time].",
        )


@contextmanager
def _stack_in(folder: Path) -> Iterator[None]:
    """A folder for a stack; where none comes to be, a new one does not stay; raises as `new_folder`."""
    there = folder.exists()
    new_folder(folder)
    try:
        yield
    except BaseException:
        if not there and not (folder / STACK_FILE).exists():
            shutil.rmtree(folder, ignore_errors=True)
        raise


def _radiance(
    camera: _Camera, at: Settings, lights: tuple[int, ...], average: int, black: float
) -> tuple[Radiance, dict[float, Floats]]:
    """Linear radiance under some lights, and the mean frame of every shutter, less black."""
    assert camera.describe.camera is not None
    gain, gamma = camera.describe.camera.gain, camera.describe.camera.gamma
    means, signals, clipped, exposures = {}, [], [], []
    for shutter_s in sorted(camera.describe.shutters_s):
        settings = msgspec.structs.replace(at, lights=lights, shutter_s=shutter_s)
        mean, full = camera.mean(settings, average)
        means[shutter_s] = _without_black(mean, black)
        signals.append(linear(means[shutter_s], gamma))
        clipped.append(full)
        exposures.append(relative_exposure(shutter_s, at.aperture) * gain)
    return united(signals, clipped, exposures), means


def _without_black(frame: Floats, black: float) -> Floats:
    return np.maximum(frame - black, 0.0) * (WHITE / (WHITE - black))


def _check_shutters(camera: _Camera, light: str, means: dict[float, Floats], black: float) -> None:
    assert camera.describe.camera is not None
    gamma = camera.describe.camera.gamma
    shutters = sorted(means)
    for short, long in itertools.pairwise(shutters):
        ratio = measured_ratio(means[short], means[long], gamma)
        expected = long / short
        if ratio is not None and abs(ratio / expected - 1) > LARGEST_NONLINEARITY:
            raise BadInput(
                f"The camera of the {camera.describe.device} is not linear: light {light!r} is"
                f" {ratio:.3g} times brighter at {long:g} s than at {short:g} s, not {expected:.3g} times"
                f" (gamma {gamma:g}, black {black:g}).",
                "Turn automatic modes off and set gamma in [camera], as calibrate measures it; or record"
                " frames.",
            )


def _check_level(
    camera: _Camera,
    at: Settings,
    number: int,
    means: dict[float, Floats],
    average: int,
    black: float,
) -> None:
    """A light's middle level must give its share of full output, since a replay dims it so."""
    assert camera.describe.camera is not None
    light = camera.describe.lights[number]
    level = light.levels // 2
    shutters = sorted(means)
    for shutter_s in reversed(shutters):
        lights = tuple(level if i == number else 0 for i in range(len(camera.describe.lights)))
        off = (0,) * len(lights)
        if float((means[shutter_s] >= SATURATED).mean()) > 0.01:
            continue
        gamma = camera.describe.camera.gamma
        frames = [
            linear(
                _without_black(
                    camera.mean(msgspec.structs.replace(at, lights=lit, shutter_s=shutter_s), average)[0],
                    black,
                ),
                gamma,
            )
            for lit in (lights, off)
        ]
        full = linear(means[shutter_s], gamma) - frames[1]
        share = float((frames[0] - frames[1]).sum() / full.sum()) if full.sum() > 0 else 0.0
        expected = level_fraction(level, light.levels)
        bright = float(full.mean()) * WHITE > 1.0
        if bright and abs(share / expected - 1) > LARGEST_NONLINEARITY:
            raise BadInput(
                f"Light {light.name!r} is not linear: level {level} of {light.levels - 1} gives {share:.0%}"
                f" of full output, not {expected:.0%}.",
                "List the channel value of each level in the lights file (values), or record frames.",
            )
        return
