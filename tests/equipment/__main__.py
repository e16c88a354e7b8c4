"""Command line of the emulated equipment, for those without hardware: `python -m tests.equipment`."""

from __future__ import annotations

import secrets
import selectors
import sys
import time
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import msgspec

from bridge.errors import BadInput, LightsAndCameraError
from bridge.lifeline import Lifeline
from image_server.simulator.scenario import load_scenario, with_conditions
from image_server.simulator.simulator import Simulator
from stack.tables import toml_text
from tests.equipment.bench import Bench
from tests.equipment.dmx import EmulatedDmxUsbPro
from tests.equipment.faults import FaultPlan
from tests.equipment.line import EmulatedLineDriver
from tests.equipment.usbip import Connection, video_node
from tests.equipment.uvc_camera import UvcCamera
from tests.equipment.uvc_descriptors import Format
from tests.equipment.uvc_model import load_camera_model

TICK_S = 0.05  # between two looks at the clock; chosen by hand
FULL = 255  # of the emulated line driver's outputs
UNITS_PER_S = 10**7  # of USB video's frame intervals
DRIVERS = {"dmx": EmulatedDmxUsbPro, "line": EmulatedLineDriver}


def emulate_lights(given: Namespace, lifeline: Lifeline) -> None:
    """Emulate a light driver; prints its device, then its outputs whenever they change."""
    emulator = DRIVERS[given.kind](given.channels, show_outputs, given.link)
    try:
        plan = FaultPlan({"": emulator}, given.fault)
        print(f"device {given.link or emulator.path}", flush=True)
        have_faults(plan, lifeline)
    finally:
        emulator.close()


def emulate_bench(given: Namespace, lifeline: Lifeline) -> None:
    """Emulate a USB camera and lights in front of a simulated target, so that a session can run on them.

    The camera is plugged into the kernel's virtual USB controller and driven by uvcvideo, so it needs root
    and the modules vhci-hcd and uvcvideo. Faults are the lights'; with `camera:` before them, the camera's:
    silent, garbage, unplugged or refuse:CONTROL.
    """
    known = load_camera_model(given.model)
    scenario = with_conditions(
        load_scenario(given.scenario), given.ambient_scale, given.light_power, given.defocus_sigma_px
    )
    simulator = Simulator(given.target, scenario, given.seed, unit=given.unit)
    lights = EmulatedLineDriver(len(simulator.describe().lights), show_outputs, given.link)
    try:
        sensor = Bench(simulator, known, lambda: lights.outputs, FULL)
        size = simulator.camera.width, simulator.camera.height
        interval = round(UNITS_PER_S / given.frame_rate)
        formats = tuple(Format(name, *size, (interval,)) for name in ("YUYV", "MJPG"))
        serial = secrets.token_hex(6)
        camera = UvcCamera(known, formats, sensor, serial, light=lambda: tuple(lights.outputs))
        plan = FaultPlan({"": lights, "camera": camera}, given.fault)
        sensor(camera.values)  # traced before anyone waits for a frame
        connection = Connection(camera)
        camera.on_unplug = connection.unplug
        try:
            node = video_node(connection, serial)
            target = msgspec.to_builtins(simulator.describe().target)
            write_toml(given.out / "camera.toml", sensor.camera_file(node))
            write_toml(given.out / "seed-pose.toml", {"target": {"seed_pose": target["seed_pose"]}})
            print(f"lights {given.link or lights.path}", flush=True)
            print(f"camera {node}", flush=True)
            have_faults(plan, lifeline)
        finally:
            connection.unplug()
    finally:
        lights.close()


def write_toml(file: Path, values: dict[str, Any]) -> None:
    """Write a file, and its folder."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(toml_text(values), encoding="utf-8")
    except OSError as error:
        raise BadInput(f"Cannot write {file}: {error.strerror}.", "Give another folder.") from None


def have_faults(plan: FaultPlan, lifeline: Lifeline) -> None:
    """Faults as planned, and as they come on standard input, until it is time to stop."""
    typed = selectors.DefaultSelector()
    with suppress(OSError, ValueError):  # a file, or nothing at all, is not listened to
        typed.register(sys.stdin, selectors.EVENT_READ)
    while not lifeline.ended():
        plan.due()
        if not typed.get_map():
            time.sleep(TICK_S)
        elif typed.select(TICK_S):
            line = sys.stdin.readline()
            if not line:
                typed.unregister(sys.stdin)
            elif line.strip():
                plan.now(line.strip())
                print(f"fault {line.strip()}", flush=True)


def show_outputs(outputs: list[int]) -> None:
    """Print what the lights do."""
    print("outputs", *outputs, flush=True)


def command_line() -> ArgumentParser:
    """What can be asked for."""
    parser = ArgumentParser(prog="python -m tests.equipment", description=__doc__, allow_abbrev=False)
    commands = parser.add_subparsers(required=True)
    lights = commands.add_parser(
        "lights",
        help="a light driver on a pseudo-terminal",
        description=emulate_lights.__doc__,
        allow_abbrev=False,
    )
    lights.set_defaults(run=emulate_lights)
    lights.add_argument("kind", choices=DRIVERS, help="dmx: Enttec DMX USB Pro; line: the line protocol")
    lights.add_argument("--channels", type=int, default=3, help="outputs that have a lamp")
    bench = commands.add_parser(
        "bench",
        help="a USB camera in front of a simulated target, and lights",
        description=emulate_bench.__doc__,
        allow_abbrev=False,
    )
    bench.set_defaults(run=emulate_bench)
    bench.add_argument("out", type=Path, help="folder for camera.toml and seed-pose.toml")
    bench.add_argument("--model", default="c922", help="model of the camera: c922, live, lens or a file")
    bench.add_argument("--frame-rate", type=float, default=30.0, help="per second")
    bench.add_argument("--target", default="cube", help="a target of targets/ or a model file")
    bench.add_argument("--unit", default="m", help="unit of the model file: m, cm, mm or in")
    bench.add_argument("--scenario", default="nominal", help="a scenario of scenarios/ or a TOML file")
    bench.add_argument("--seed", type=int, default=0, help="seed of every random draw")
    for name in ("ambient-scale", "light-power", "defocus-sigma-px"):
        bench.add_argument(f"--{name}", type=float, help="instead of what the scenario says")
    for command in (lights, bench):
        command.add_argument("--link", type=Path, help="make a symbolic link to the pseudo-terminal")
        command.add_argument(
            "--fault", metavar="[S:]FAULT", action="append", default=[],
            help="silent, garbage, unplugged or dead:CHANNEL, S seconds after the start; repeatable",
        )  # fmt: skip
        command.add_argument("--parent", metavar="PID", type=int, help="stop when this process ends")
    return parser


def main(words: Sequence[str]) -> int:
    """Run a command; its exit status."""
    given = command_line().parse_args(words)
    lifeline = Lifeline(given.parent, signals=True)
    try:
        given.run(given, lifeline)
        return lifeline.status
    except LightsAndCameraError as error:
        print(f"equipment: {' '.join(str(error).split())}", file=sys.stderr)
        return error.exit_status
    finally:
        lifeline.close()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
