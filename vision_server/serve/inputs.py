"""What a session or a command starts from: model, camera and seed pose, read from files and checked."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from bridge.errors import BadInput
from geometry.camera import Camera
from geometry.errors import GeometryError
from geometry.model import Model, load_model
from geometry.pose import Pose


def read_toml(path: Path) -> dict[str, Any]:
    """A TOML file as a dict.

    Raises
    ------
    BadInput
        Missing, unreadable or no TOML.
    """
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise BadInput(f"Cannot read {path}: {error.strerror or error}.", "Check the path.") from error
    except ValueError as error:
        raise BadInput(f"{path} is not valid TOML: {error}.", "Correct the file.") from error


def read_camera(path: Path) -> tuple[Camera, dict[str, Any]]:
    """The camera of a TOML file with ``[camera]`` (or nothing else), and all keys of that table."""
    data = read_toml(path)
    table = data.get("camera", data)
    try:
        if not isinstance(table, dict):
            raise GeometryError("camera is not a table")
        return Camera.from_dict(table), table
    except GeometryError as error:
        raise BadInput(
            f"{path}: {error}.", "A [camera] table needs width, height, fx, fy, cx and cy."
        ) from error


def read_seed_pose(path: Path, model: Model) -> Pose:
    """The seed pose of a TOML file with ``[target.seed_pose]``, ``[seed_pose]`` or nothing but a pose."""
    data: Any = read_toml(path)
    for key in ("target", "seed_pose"):
        if isinstance(data, dict) and key in data:
            data = data[key]
    try:
        if not isinstance(data, dict):
            raise GeometryError("the seed pose is not a table")
        return checked_pose(Pose.from_dict(data), model)
    except GeometryError as error:
        raise BadInput(
            f"{path}: {error}.", "Give [target.seed_pose] with rotation_vector and translation."
        ) from error


def checked_pose(pose: Pose, model: Model) -> Pose:
    """The pose, whose target must be in front of the camera.

    Raises
    ------
    GeometryError
        What a search turns about is not in front of the camera: the target's origin, when that is within it.
    """
    depth = pose.apply(model.pivot[None])[0, 2]
    if not depth > 0.0:
        raise GeometryError(f"the target is behind the camera (z = {depth:g} m)")
    return pose


def read_model(path: Path, unit: str = "m") -> Model:
    """A model file; geometry's errors become BadInput."""
    try:
        return load_model(path, unit)
    except GeometryError as error:
        raise BadInput(str(error), "Give a .cao, OBJ, STL or PLY file.") from error
