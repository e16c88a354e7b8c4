"""Calibration of a camera: a camera file from what its controls offer and what its frames show."""

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np

from bridge.errors import BadInput
from image_server.recording.linearity import fitted_gamma
from image_server.v4l2.camera import V4L2Camera
from image_server.v4l2.camera_file import Axis, CameraFile
from numerics.arrays import Grey

STEADY = 0.03
"""Relative change of the mean grey value under which a frame counts as settled."""
MOST_SETTLE_FRAMES = 12  # chosen by hand: four times what UVC cameras need
LEAST_EFFECT = 0.1
"""Relative change of the mean grey value between the ends of an axis under which it has no effect."""
IRIS_STEPS = 5  # chosen by hand: one per stop of a usual iris
SAMPLES = 3  # frames averaged where brightness is compared


@dataclass(frozen=True)
class Calibration:
    """The camera file, and what was measured on the way, in words."""

    file: CameraFile
    notes: tuple[str, ...]


def calibrate(
    camera: V4L2Camera,
    widest_aperture: float | None = None,
    focal_lengths: Mapping[float, int] | None = None,
    focuses: Mapping[float, int] | None = None,
) -> Calibration:
    """Make a camera file for the camera as it stands, in front of a steadily lit scene.

    Parameters
    ----------
    camera : opened with a file that says nothing but its device and format.
    widest_aperture : f-number with the iris wide open, where there is an iris control. The f-numbers of the
        other steps follow from the light they let in, which goes as 1 / f-number².
    focal_lengths, focuses : control value of each focal length (mm) and focus distance (m).

    Raises
    ------
    BadInput : an axis for a control that the camera lacks, or a scene too dark or too bright to tell.
    """
    notes: list[str] = []
    file = msgspec.structs.replace(
        camera.file,
        card=camera.card,
        focal_length=_listed(camera, "focal_length_mm", "zoom_absolute", focal_lengths),
        focus=_listed(camera, "focus_m", "focus_absolute", focuses),
    )
    gamma = None
    if file.shutter is None:
        notes.append("no exposure control: the shutter is one frame period, and cannot be chosen")
    else:
        shutter = file.shutter
        assert shutter.control is not None
        frames = [_mean_frame(camera, shutter.control, value) for _, value in shutter.steps]
        effect = _effect(frames)
        notes.append(f"brightest over darkest shutter: {effect:.3g} times in mean grey value")
        if effect > 1 + LEAST_EFFECT:
            frame_count = _settle_frames(camera, shutter)
            file = msgspec.structs.replace(file, settle_frames=frame_count)
            notes.append(f"a new shutter shows {frame_count} frames late")
            gamma = fitted_gamma(frames, [seconds for seconds, _ in shutter.steps])
        else:
            notes.append(
                "the frames do not follow the shutter: the scene is black or white, or it is ignored"
            )
    notes.append("gamma could not be measured" if gamma is None else f"gamma {gamma:.3f}")
    if gamma is not None and file.camera is not None:
        described = msgspec.structs.replace(file.camera, gamma=round(gamma, 3))
        file = msgspec.structs.replace(file, camera=described)
    if widest_aperture is not None:
        file = msgspec.structs.replace(file, aperture=_iris(camera, widest_aperture, gamma or 1.0, notes))
    return Calibration(file, tuple(notes))


def _listed(
    camera: V4L2Camera, name: str, control: str, values: Mapping[float, int] | None
) -> Axis[float] | None:
    if not values:
        return None
    _need(camera, control, name)
    for value in values.values():
        camera.controls[control].check(value, camera.file.device)
    return Axis(control=control, steps=tuple(sorted(values.items())))


def _need(camera: V4L2Camera, control: str, name: str) -> None:
    if control not in camera.controls:
        raise BadInput(
            f"The camera {camera.file.device} has no control {control} for {name}.",
            f"It has {', '.join(camera.controls)}.",
        )


def _iris(camera: V4L2Camera, widest: float, gamma: float, notes: list[str]) -> Axis[float]:
    """F-numbers of the iris's positions, from the light that each lets in."""
    _need(camera, "iris_absolute", "aperture")
    control = camera.controls["iris_absolute"]
    positions = np.linspace(control.minimum, control.maximum, IRIS_STEPS)
    step = max(1, control.step)
    values = sorted({control.minimum + step * round((p - control.minimum) / step) for p in positions})
    light = {value: _light(_mean_frame(camera, control.name, value), gamma) for value in values}
    brightest = max(light.values())
    steps = {}
    for value, amount in light.items():
        if amount > brightest / 256:
            steps[round(widest * math.sqrt(brightest / amount), 3)] = value
    if len(steps) < 2:
        raise BadInput(
            f"The frames of {camera.file.device} do not follow its iris.",
            "Use a scene neither black nor white.",
        )
    notes.append(f"iris: f/{', f/'.join(f'{f_number:g}' for f_number in sorted(steps))}")
    return Axis(control=control.name, steps=tuple(sorted(steps.items())))


def _light(frame: Grey, gamma: float) -> float:
    return float(((frame / 255.0) ** gamma).mean())


def _mean_frame(camera: V4L2Camera, control: str, value: int) -> Grey:
    """Mean of some settled frames with a control at a value, (H, W) uint8."""
    camera.set_control(control, value)
    for _ in range(MOST_SETTLE_FRAMES):
        camera.next_frame()
    frames = [camera.next_frame()[0] for _ in range(SAMPLES)]
    mean: Grey = np.rint(np.mean(frames, axis=0)).astype(np.uint8)
    return mean


def _effect(frames: Sequence[Grey]) -> float:
    means = [float(frame.mean()) for frame in frames]
    return max(means) / max(min(means), 0.5)


def _settle_frames(camera: V4L2Camera, shutter: Axis[float]) -> int:
    """How many frames still show the old shutter, fully or in part, after a change, in either direction."""
    assert shutter.control is not None
    (_, dark), (_, bright) = shutter.steps[0], shutter.steps[-1]
    late = 0
    for before, after in ((dark, bright), (bright, dark)):
        _mean_frame(camera, shutter.control, before)
        camera.set_control(shutter.control, after)
        changed = time.monotonic()
        means: list[float] = []
        while len(means) < MOST_SETTLE_FRAMES:
            frame, stamp = camera.next_frame()
            if stamp.time >= changed:
                means.append(float(frame.mean()))
        steady = means[-1]
        unsettled = [i for i, mean in enumerate(means) if abs(mean - steady) > STEADY * max(steady, 1.0)]
        late = max(late, max(unsettled, default=-1) + 1)
    return late
