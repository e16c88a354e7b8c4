"""What an image server describes: which camera is looked through, and doubts of its camera and lights."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import msgspec
import numpy as np

from bridge.errors import BadInput
from bridge.messages import CameraDescription, LightDescription
from geometry.camera import Camera
from geometry.errors import GeometryError
from geometry.pose import Pose
from stack.format import GivenTargetTable
from vision_server.serve.inputs import GivenCamera

# Of the frame's half diagonal, chosen by hand: half a percent of the range; two calibrations differ by less.
APART = 0.005
# Distances of target and camera between lamp and target: it gives a thousandth of the light of one beside the
# camera, which is less than a grey level.
FAR_LAMP = 30.0


def used_camera(given: GivenCamera | None, described: CameraDescription | None, source: str) -> GivenCamera:
    """The camera of a file, which someone has calibrated; else what the image server describes.

    Parameters
    ----------
    source : whose description it is, for people.

    Raises
    ------
    BadInput : there is none, or it is none.
    """
    if given is not None:
        return given
    if described is None:
        raise BadInput(
            "No camera is given, and no image server describes its own.",
            "Give a camera file (--camera-model TOML).",
        )
    table = msgspec.to_builtins(described)
    try:
        return GivenCamera(Path(source), Camera.from_dict(table), table, GivenTargetTable())
    except GeometryError as error:
        raise BadInput(f"{source}: {error}.", "Give a camera file.") from error


def camera_doubt(used: Camera, described: CameraDescription | None) -> str | None:
    """What to say of a camera that is not the one that the image server describes."""
    if described is None:
        return None
    other = Camera.from_dict(msgspec.to_builtins(described))
    if (used.width, used.height) != (other.width, other.height):
        sizes = f"of {used.width}x{used.height} px, the image server describes {other.width}x{other.height}"
        return f"the camera file is {sizes}. One of the two is wrong."
    apart_px = _apart_px(used, other)
    if apart_px <= APART * 0.5 * float(np.hypot(used.width, used.height)):
        return None
    return (
        f"the camera file is used (fx {used.fx:g}, fy {used.fy:g}), and the image server describes another "
        f"camera (fx {other.fx:g}, fy {other.fy:g}): points of the frame are up to {apart_px:.1f} px apart. "
        "If the server is right, every pose is off."
    )


def lights_doubt(lights: Sequence[LightDescription], seed_pose: Pose | None) -> str | None:
    """What to say of lights so far away that they give the target as good as no light."""
    if seed_pose is None:
        return None
    target = seed_pose.translation
    ahead = float(np.linalg.norm(target))
    for light in lights:
        if light.position is None:
            continue
        away = float(np.linalg.norm(target - light.position))
        if away > FAR_LAMP * ahead * math.sqrt(max(light.power, 1.0)):
            return (
                f"the light {light.name!r} is {away:.3g} m from the target, which is {ahead:.3g} m from the "
                "camera. Is its position in metres?"
            )
    return None


def _apart_px(one: Camera, other: Camera) -> float:
    """How far apart two cameras see what the first sees at the middles and corners of its frame, px."""
    across, down = (np.array([0.0, 0.5, 1.0]) * (size - 1) for size in (one.width, one.height))
    seen = np.stack(np.meshgrid(across, down), axis=-1).reshape(-1, 2)
    ideal = one.undistort_points(seen)
    rays = (ideal - [one.cx, one.cy]) / [one.fx, one.fy]
    again = other.project(np.column_stack([rays, np.ones(len(rays))]))
    return float(np.linalg.norm(again - seen, axis=1).max())
