"""`record`: write a stack folder from any device."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from enum import StrEnum
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from bridge.errors import BadInput
from image_server.command_line import Argument, Option
from image_server.commands.hardware import CAMERA, Equipment, Laboratory, laboratory_device
from image_server.commands.options import Conditions, Draws
from image_server.commands.replay import replay_device
from image_server.commands.serving import plain_errors
from image_server.commands.simulate import Scene, simulated_device

if TYPE_CHECKING:
    from bridge.messages import Describe, Settings
    from image_server.serve.device import Device


class StackKind(StrEnum):
    """Kinds of stack folder."""

    FRAMES = "frames"
    BASIS = "basis"


def record(
    out: Annotated[Path, Argument(metavar="OUT", help="Folder to write.")],
    kind: Annotated[StackKind, Option(help="Frames as they come, or the radiance of each light.")],
    equipment: Equipment,
    camera: Annotated[str | None, CAMERA] = None,
    settings: Annotated[
        list[str] | None,
        Option(
            metavar="LEVELS:SHUTTER:APERTURE",
            help="For frames: e.g. 7,0,0:1/60:4; repeatable. 'each' is every light alone and all together"
            " under every shutter and aperture. For basis: the aperture of the first counts.",
        ),
    ] = None,
    stack: Annotated[Path | None, Option(metavar="DIR", help="Record from a stack folder.")] = None,
    scenario: Annotated[
        str | None, Option(metavar="NAME_OR_FILE", help="Record from the simulator under a scenario.")
    ] = None,
    draws: Draws = Draws(),
    repeat: Annotated[int, Option(min=1, max=1000, help="Frames per setting.")] = 1,
    average: Annotated[int, Option(min=1, max=1000, help="For basis: frames that are averaged.")] = 16,
    black: Annotated[float, Option(min=0, max=128, help="For basis: grey value with the lens capped.")] = 0.0,
) -> None:
    """Write a stack folder from a camera with lights (--camera), a stack or the simulator."""
    with plain_errors():
        from image_server.recording.record import record_basis, record_frames

        with _opened(camera, equipment, stack, scenario, draws) as device:
            describe = device.describe()
            if kind is StackKind.FRAMES:
                if not settings:
                    raise BadInput("There is nothing to record.", "Give --settings LEVELS:SHUTTER:APERTURE.")
                wanted = [one for text in settings for one in parsed_settings(text, describe)]
                done = record_frames(device, out, wanted, repeat, _say)
            else:
                at = parsed_settings(settings[0], describe)[0] if settings else _reference(describe)
                done = record_basis(device, out, at, average, black, _say)
        print(f"{out}: {done.frames} frames recorded, {done.unverified} of them unverified")


def parsed_settings(text: str, describe: "Describe") -> "list[Settings]":
    """The settings that an option means.

    Raises
    ------
    BadInput : not of the form LEVELS:SHUTTER:APERTURE[:FOCAL_LENGTH_MM[:FOCUS_M]].
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


def _reference(describe: "Describe") -> "Settings":
    from bridge.messages import Settings

    aperture = min(describe.apertures, key=lambda f_number: abs(f_number - describe.reference.aperture))
    return Settings(lights=(0,) * len(describe.lights), shutter_s=describe.shutters_s[0], aperture=aperture)


@contextmanager
def _opened(
    camera: str | None, equipment: Equipment, stack: Path | None, scenario: str | None, draws: Draws
) -> "Iterator[Device]":
    given = {"--camera": camera, "--stack": stack, "--scenario": scenario}
    sources = [name for name, value in given.items() if value is not None]
    if len(sources) != 1:
        raise BadInput(
            f"Give one of --camera, --stack and --scenario; given: {', '.join(sources) or 'none'}."
        )
    device: Device
    if stack is not None:
        device = replay_device(stack, draws, Conditions())
    elif scenario is not None:
        scene = Scene(target=equipment.target or "cube", scenario=scenario, unit=equipment.unit)
        device = simulated_device(scene, draws, Conditions())
    else:
        assert camera is not None
        device = laboratory_device(Laboratory(camera=camera, **vars(equipment)))
    try:
        yield device
    finally:
        device.close()


def _say(text: str) -> None:
    print(text, file=sys.stderr)
