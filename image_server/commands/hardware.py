"""`hardware`: serve a V4L2 camera with lights on a serial line."""

from __future__ import annotations

import time
from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from bridge.command_line import add_serving
from bridge.errors import BadInput, DeviceBusy
from image_server.commands.options import add_camera, add_equipment, add_events
from image_server.commands.serving import serve_device

if TYPE_CHECKING:
    from bridge.messages import CameraDescription, TargetDescription
    from image_server.hardware import Hardware

Opened = TypeVar("Opened")
LET_GO_S = 5.0
"""How long the server of a session that was killed may have camera and lights after it; chosen by hand."""
LOOK_S = 0.1  # between two looks whether it has let go; chosen by hand


def add_options(parser: ArgumentParser) -> None:
    """Options of the command."""
    add_camera(parser)
    add_equipment(parser)
    add_serving(parser)
    add_events(parser)


def run(options: Namespace) -> int:
    """Serve until told to stop; the exit status."""
    return serve_device(lambda: when_free(lambda: laboratory_device(options)), options)


def when_free(opened: Callable[[], Opened]) -> Opened:
    """What is opened, as soon as who has it now lets go; raises as ``opened`` where that does not come."""
    deadline = time.monotonic() + LET_GO_S
    while True:
        try:
            return opened()
        except DeviceBusy:
            if time.monotonic() >= deadline:
                raise
            time.sleep(LOOK_S)


def laboratory_device(options: Namespace) -> Hardware:
    """Camera and lights, opened; what was opened is closed again when the rest cannot be.

    Raises
    ------
    BadInput
        A file or device that cannot be used.
    DeviceError
        A device that is busy, gone or does not answer.
    """
    from image_server.hardware import Hardware
    from image_server.lights.opening import open_rig
    from image_server.v4l2.camera import V4L2Camera
    from image_server.v4l2.camera_file import load_camera_file

    target = _target(options)
    description = None if options.camera_model is None else _camera_model(options.camera_model)
    camera = V4L2Camera(load_camera_file(options.camera))
    try:
        description = description or camera.file.camera
        if description is not None and (description.width, description.height) != camera.size:
            raise BadInput(
                f"[camera] is for {description.width}×{description.height} px, but {options.camera} gives"
                f" {camera.size[0]}×{camera.size[1]} px.",
                "Set width and height in the camera file's [format], or calibrate at this size.",
            )
        lights = None
        if options.lights is not None:
            lights = open_rig(options.lights, options.dark_after_s)
        return Hardware(camera, lights, description, target)
    except BaseException:
        camera.close()
        raise


def _camera_model(file: Path) -> CameraDescription:
    from bridge.messages import CameraDescription
    from stack.format import camera_file
    from stack.tables import as_table, read_toml

    _, told = camera_file(read_toml(file, "camera model"), file)
    known = CameraDescription.__struct_fields__
    return as_table({key: value for key, value in told.items() if key in known}, CameraDescription, file)


def _target(options: Namespace) -> TargetDescription | None:
    from bridge.messages import PoseMessage, TargetDescription
    from geometry.errors import GeometryError
    from geometry.model import find_target, load_model
    from stack.tables import as_table, read_toml

    seed_pose = None
    if options.seed_pose is not None:
        values = read_toml(options.seed_pose, "seed pose")
        for key in ("target", "seed_pose"):
            values = values.get(key, values)
        seed_pose = as_table(values, PoseMessage, options.seed_pose)
    if options.target is None:
        return None
    try:
        model = find_target(options.target).resolve()
        load_model(model, options.unit)
    except GeometryError as error:
        raise BadInput(f"{error}.") from None
    return as_table(
        {"model": str(model), "unit": options.unit, "seed_pose": seed_pose}, TargetDescription, model
    )
