"""`bench`: an emulated USB camera and emulated lights in front of a simulated target."""

import secrets
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import msgspec

from bridge.errors import BadInput
from bridge.lifeline import Lifeline
from image_server.command_line import Argument, Option
from image_server.commands.emulate import FAULT, LINK, have_faults, shown
from image_server.commands.options import Conditions, Draws
from image_server.commands.serving import plain_errors
from image_server.commands.simulate import Scene, simulated_device
from stack.toml_text import toml_text

if TYPE_CHECKING:
    from image_server.simulator import Simulator

FULL = 255
UNITS_PER_S = 10**7  # of USB video's frame intervals


def bench(
    out: Annotated[Path, Argument(metavar="OUT", help="Folder for camera.toml and seed-pose.toml.")],
    scene: Scene,
    draws: Draws,
    conditions: Conditions,
    model: Annotated[
        str, Option(metavar="NAME_OR_FILE", help="Model of the camera: c922, live, lens or a file.")
    ] = "c922",
    frame_rate: Annotated[float, Option(min=0.1, max=120, help="Per second.")] = 30.0,
    link: Annotated[Path | None, LINK] = None,
    fault: Annotated[list[str] | None, FAULT] = None,
    parent: Annotated[int | None, Option(metavar="PID", help="Stop when this process ends.")] = None,
) -> None:
    """Emulate a USB camera and lights in front of a simulated target, so that a session can run on them.

    The camera is plugged into the kernel's virtual USB controller and driven by uvcvideo, so it needs root
    and the modules vhci-hcd and uvcvideo. Faults are the lights'; with `camera:` before them, the camera's:
    silent, garbage, unplugged or refuse:CONTROL.
    """
    with plain_errors():
        from image_server.emulators.bench import Bench
        from image_server.emulators.faults import FaultPlan
        from image_server.emulators.line import EmulatedLineDriver
        from image_server.emulators.usbip import Connection, video_node
        from image_server.emulators.uvc_camera import UvcCamera
        from image_server.emulators.uvc_descriptors import Format
        from image_server.emulators.uvc_model import load_camera_model

        known = load_camera_model(model)
        simulator = simulated_device(scene, draws, conditions)
        lifeline = Lifeline(parent, signals=True)
        lights = EmulatedLineDriver(len(simulator.describe().lights), shown, link)
        try:
            sensor = Bench(simulator, known, lambda: lights.outputs, FULL)
            size = simulator.camera.width, simulator.camera.height
            interval = round(UNITS_PER_S / frame_rate)
            formats = tuple(Format(name, *size, (interval,)) for name in ("YUYV", "MJPG"))
            serial = secrets.token_hex(6)
            camera = UvcCamera(known, formats, sensor, serial, light=lambda: tuple(lights.outputs))
            plan = FaultPlan({"": lights, "camera": camera}, fault or [])
            sensor(camera.values)  # traced before anyone waits for a frame
            connection = Connection(camera)
            camera.on_unplug = connection.unplug
            try:
                node = video_node(connection, serial)
                _write(out / "camera.toml", sensor.camera_file(node))
                _write(out / "seed-pose.toml", {"target": {"seed_pose": _seed_pose(simulator)}})
                print(f"lights {link or lights.path}", flush=True)
                print(f"camera {node}", flush=True)
                have_faults(plan, lifeline)
            finally:
                connection.unplug()
        finally:
            lights.close()
            lifeline.close()
        sys.exit(lifeline.status)


def _seed_pose(simulator: "Simulator") -> dict[str, Any]:
    target = simulator.describe().target
    assert target is not None
    pose: dict[str, Any] = msgspec.to_builtins(target.seed_pose)
    return pose


def _write(file: Path, values: dict[str, Any]) -> None:
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(toml_text(values), encoding="utf-8")
    except OSError as error:
        raise BadInput(f"Cannot write {file}: {error.strerror}.", "Give another folder.") from None
