"""`hardware`: serve a V4L2 camera with lights on a serial line; `cameras`: list what is connected."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from bridge.errors import BadInput, DeviceError, LightsAndCameraError
from image_server.command_line import Option
from image_server.commands.options import Serving
from image_server.commands.serving import plain_errors, serve_device

if TYPE_CHECKING:
    from bridge.messages import CameraDescription, TargetDescription
    from image_server.hardware import Hardware


CAMERA = Option(metavar="DEV_OR_TOML", help="A V4L2 device such as /dev/video0, or a camera file.")


@dataclass(frozen=True, kw_only=True)
class Equipment:
    """Lights, and what is known of camera and target."""

    lights: Annotated[
        str | None,
        Option(metavar="DEV_OR_TOML", help="A serial device such as /dev/ttyUSB0, or a lights file."),
    ] = None
    camera_model: Annotated[
        Path | None,
        Option(metavar="TOML", help="File with [camera], instead of that of the camera file."),
    ] = None
    target: Annotated[
        str | None, Option(metavar="NAME_OR_FILE", help="A target of targets/ or a model file.")
    ] = None
    unit: Annotated[str, Option(help="Unit of the model file: m, cm, mm or in.")] = "m"
    seed_pose: Annotated[Path | None, Option(metavar="TOML", help="File with [target.seed_pose].")] = None
    dark_after_s: Annotated[
        float | None,
        Option(
            min=0,
            help="Turn the lights off when no request has come for so long; 0: never. Default: lights file.",
        ),
    ] = None


@dataclass(frozen=True, kw_only=True)
class Laboratory(Equipment):
    """A camera with its equipment."""

    camera: Annotated[str, CAMERA]


def hardware(laboratory: Laboratory, serving: Serving) -> None:
    """Serve a V4L2 camera, with lights on a serial line or without."""
    serve_device(lambda: laboratory_device(laboratory), serving)


def laboratory_device(laboratory: Laboratory) -> "Hardware":
    """Camera and lights, opened; what was opened is closed again when the rest cannot be.

    Raises
    ------
    BadInput : a file or device that cannot be used.
    DeviceError : a device that is busy, gone or does not answer.
    """
    from image_server.hardware import Hardware
    from image_server.lights.rig import open_rig
    from image_server.v4l2.camera import V4L2Camera
    from image_server.v4l2.camera_file import load_camera_file

    target = _target(laboratory)
    description = None if laboratory.camera_model is None else _camera_model(laboratory.camera_model)
    camera = V4L2Camera(load_camera_file(laboratory.camera))
    try:
        description = description or camera.file.camera
        if description is not None and (description.width, description.height) != camera.size:
            raise BadInput(
                f"[camera] is for {description.width}×{description.height} px, but {laboratory.camera} gives"
                f" {camera.size[0]}×{camera.size[1]} px.",
                "Set width and height in the camera file's [format], or calibrate at this size.",
            )
        lights = None
        if laboratory.lights is not None:
            lights = open_rig(laboratory.lights, laboratory.dark_after_s)
        return Hardware(camera, lights, description, target)
    except BaseException:
        camera.close()
        raise


def _camera_model(file: Path) -> "CameraDescription":
    from bridge.messages import CameraDescription
    from stack.tables import as_table, read_toml

    values = read_toml(file, "camera model")
    table = dict(values.get("camera", values))
    known = CameraDescription.__struct_fields__
    return as_table({key: value for key, value in table.items() if key in known}, CameraDescription, file)


def _target(laboratory: Laboratory) -> "TargetDescription | None":
    from bridge.messages import PoseMessage, TargetDescription
    from geometry.errors import GeometryError
    from geometry.model import find_target, load_model
    from stack.tables import as_table, read_toml

    seed_pose = None
    if laboratory.seed_pose is not None:
        values = read_toml(laboratory.seed_pose, "seed pose")
        for key in ("target", "seed_pose"):
            values = values.get(key, values)
        seed_pose = as_table(values, PoseMessage, laboratory.seed_pose)
    if laboratory.target is None:
        return None
    try:
        model = find_target(laboratory.target).resolve()
        load_model(model, laboratory.unit)
    except GeometryError as error:
        raise BadInput(f"{error}.") from None
    return as_table(
        {"model": str(model), "unit": laboratory.unit, "seed_pose": seed_pose}, TargetDescription, model
    )


def cameras() -> None:
    """List the cameras of this machine with their formats and controls."""
    with plain_errors():
        from image_server.v4l2.camera import describe_control
        from image_server.v4l2.controls import controls
        from image_server.v4l2.node import Node
        from image_server.v4l2.stream import formats

        nodes = sorted(Path("/dev").glob("video*"), key=lambda path: (len(path.name), path.name))
        found = 0
        for path in nodes:
            try:
                node = Node(str(path))
            except LightsAndCameraError as error:
                if not isinstance(error, BadInput) or "permission" in error.message.lower():
                    print(f"{path}: {error}")
                continue
            try:
                found += 1
                print(f"{path}: {node.card} ({node.driver}, {node.bus})")
                print(f"  formats: {', '.join(formats(node))}")
                for control in controls(node).values():
                    print(f"  {describe_control(control)}")
            finally:
                node.close()
        if not found:
            raise DeviceError("There is no camera that can be used.", "Is one connected?")
