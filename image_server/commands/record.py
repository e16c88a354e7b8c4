"""`record`: write a stack folder from any device."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

from bridge.command_line import counted, number, whole_number
from bridge.errors import BadInput
from bridge.stopping import Stopping
from image_server.commands.hardware import laboratory_device
from image_server.commands.options import add_camera, add_equipment, add_seed
from image_server.commands.replay import replay_device
from image_server.commands.simulator import simulated_device

if TYPE_CHECKING:
    from bridge.messages import Describe, Settings
    from image_server.serve.device import Device

SOURCES: dict[str, Callable[[Namespace], Device]] = {
    "camera": laboratory_device,
    "stack": replay_device,
    "scenario": simulated_device,
}
"""What a stack can be recorded from: the option that names it, and what opens it."""


def add_options(parser: ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument("out", type=Path, metavar="OUT", help="Folder to write.")
    parser.add_argument(
        "--kind",
        required=True,
        choices=("frames", "basis"),
        help="Frames as they come, or the radiance of each light.",
    )
    add_equipment(parser)
    add_camera(parser, required=False)
    parser.add_argument(
        "--settings",
        action="append",
        default=[],
        metavar="LEVELS:SHUTTER:APERTURE",
        help="For frames: e.g. 7,0,0:1/60:4; repeatable. 'each' is every light alone and all together"
        " under every shutter and aperture. For basis: the aperture of the first counts.",
    )
    parser.add_argument("--stack", type=Path, metavar="DIR", help="Record from a stack folder.")
    parser.add_argument(
        "--scenario", metavar="NAME_OR_FILE", help="Record from the simulator under a scenario."
    )
    add_seed(parser)
    parser.add_argument(
        "--repeat",
        metavar="N",
        type=whole_number(1, 1000),
        default=1,
        help="Frames per setting (default: %(default)s).",
    )
    parser.add_argument(
        "--average",
        metavar="N",
        type=whole_number(1, 1000),
        default=16,
        help="For basis: frames that are averaged (default: %(default)s).",
    )
    parser.add_argument(
        "--black",
        metavar="GREY",
        type=number(0, 128),
        default=0.0,
        help="For basis: grey value with the lens capped (default: %(default)s).",
    )


def run(options: Namespace) -> None:
    """Record."""
    from image_server.recording.record import record_basis, record_frames

    out, settings = options.out, options.settings
    with _opened(options) as device, Stopping() as stopping:

        def say(text: str) -> None:
            print(text, file=sys.stderr)
            stopping.heed()

        describe = device.describe()
        if options.kind == "frames":
            if not settings:
                raise BadInput("There is nothing to record.", "Give --settings LEVELS:SHUTTER:APERTURE.")
            wanted = [one for text in settings for one in parsed_settings(text, describe)]
            done = record_frames(device, out, wanted, options.repeat, say)
        else:
            at = parsed_settings(settings[0], describe)[0] if settings else _reference(describe)
            done = record_basis(device, out, at, options.average, options.black, say)
        stopping.heed()
    print(f"{out}: {counted(done.frames, 'frame')} recorded, {done.unverified} of them unverified")


def parsed_settings(text: str, describe: Describe) -> list[Settings]:
    """The settings that an option means.

    Raises
    ------
    BadInput
        Not of the form LEVELS:SHUTTER:APERTURE[:FOCAL_LENGTH_MM[:FOCUS_M]].
    """
    from bridge.messages import Settings

    if text == "each":
        from stack.exposure import full_levels

        full = full_levels(describe.lights)
        alone = [full_levels(describe.lights, only) for only in range(len(full))]
        return [
            Settings(lights=levels, shutter_s=shutter_s, aperture=aperture)
            for levels in dict.fromkeys([*alone, full])
            for shutter_s in describe.shutters_s
            for aperture in describe.apertures
        ]
    try:
        levels_text, *numbers = text.split(":")
        levels = tuple(int(level) for level in levels_text.split(",") if level)
        shutter_s, aperture, *lens = [float(Fraction(number)) for number in numbers]
        focal_length_mm, focus_m = [*lens, None, None][:2]
        if len(lens) > 2 or not shutter_s > 0 or not aperture > 0:
            raise ValueError
    except (ValueError, ZeroDivisionError):
        raise BadInput(
            f"--settings: {text!r} is not LEVELS:SHUTTER:APERTURE.", "For example 7,0,0:1/60:4"
        ) from None
    return [
        Settings(
            lights=levels,
            shutter_s=shutter_s,
            aperture=aperture,
            focal_length_mm=focal_length_mm,
            focus_m=focus_m,
        )
    ]


def _reference(describe: Describe) -> Settings:
    from bridge.messages import Settings

    aperture = min(describe.apertures, key=lambda f_number: abs(f_number - describe.reference.aperture))
    return Settings(lights=(0,) * len(describe.lights), shutter_s=describe.shutters_s[0], aperture=aperture)


@contextmanager
def _opened(options: Namespace) -> Iterator[Device]:
    given = [name for name in SOURCES if getattr(options, name) is not None]
    if len(given) != 1:
        named = ", ".join(f"--{name}" for name in given) or "none"
        raise BadInput(f"Give one of --camera, --stack and --scenario; given: {named}.")
    device = SOURCES[given[0]](options)
    try:
        yield device
    finally:
        device.close()
