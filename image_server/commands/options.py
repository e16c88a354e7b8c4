"""Options that several commands share."""

from __future__ import annotations

from argparse import ArgumentParser, ArgumentTypeError, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from bridge.command_line import MOST_SEED, number, whole_number
from stack.format import MOST_STRENGTH

if TYPE_CHECKING:
    from image_server.serve.device import Device

Conditions = tuple[float | None, float | None, float | None, tuple[float, float] | None]
"""Ambient scale, light power, defocus (px) and motion (px/s), each instead of a file's."""

AS_IN_THE_FILE: Conditions = (None, None, None, None)


def add_events(parser: ArgumentParser) -> None:
    """Where a server tells what happens."""
    parser.add_argument("--events", metavar="ENDPOINT", help="Where to publish events (default: nowhere).")


def add_seed(parser: ArgumentParser) -> None:
    """Where random draws come from."""
    parser.add_argument(
        "--seed",
        metavar="N",
        type=whole_number(0, MOST_SEED),
        default=0,
        help="Seed of every random draw: noise, and the simulator's poses (default: %(default)s).",
    )
    parser.set_defaults(captures_taken=0, moved=[])  # what only goes on is given by `add_past`


def add_past(parser: ArgumentParser) -> None:
    """What a session has done before that goes on with this server."""
    parser.add_argument(
        "--captures-taken",
        metavar="N",
        type=whole_number(0),
        default=0,
        help="Frames taken before by a session that goes on: noise is drawn from there"
        " (default: %(default)s).",
    )
    parser.add_argument(
        "--moved",
        action="append",
        type=_move,
        default=[],
        metavar="RANGE_M:CAPTURES",
        help="Where a session that goes on has moved the target to, after how many frames; repeatable.",
    )


def _move(word: str) -> tuple[float, int]:
    range_m, colon, captures = word.partition(":")
    if not colon:
        raise ArgumentTypeError(f"{word!r} is not RANGE_M:CAPTURES, such as 0.8:3")
    return number(1e-6)(range_m), whole_number(0)(captures)


def add_deaths(parser: ArgumentParser) -> None:
    """Lights that go out on cue."""
    parser.add_argument(
        "--light-dies",
        action="append",
        type=_death,
        default=[],
        metavar="NAME:CAPTURES",
        help="This light goes out after so many frames, and is told as a light_fault; repeatable.",
    )


def _death(word: str) -> tuple[str, int]:
    name, colon, captures = word.rpartition(":")
    if not colon:
        raise ArgumentTypeError(f"{word!r} is not NAME:CAPTURES, such as left:3")
    return name, whole_number(0)(captures)


def with_deaths(device: Device, options: Namespace) -> Device:
    """The device, with lights that die where `--light-dies` was given."""
    if not options.light_dies:
        return device
    from image_server.serve.dying_lights import DyingLights

    return DyingLights(device, dict(options.light_dies), options.captures_taken)


def add_conditions(parser: ArgumentParser) -> None:
    """Light and blur instead of those in a stack or scenario file."""
    parser.add_argument(
        "--ambient-scale",
        metavar="FACTOR",
        type=number(0, MOST_STRENGTH),
        help="Strength of the sun instead of the one in the file; 0 is eclipse, 20 harsh.",
    )
    parser.add_argument(
        "--light-power",
        type=number(0, MOST_STRENGTH),
        metavar="FACTOR",
        help="Multiply the power of every light.",
    )
    parser.add_argument(
        "--defocus-sigma-px",
        metavar="PX",
        type=number(0),
        help="Blur at the widest aperture, px, instead of the one in the file.",
    )
    parser.add_argument(
        "--motion-px-per-s",
        type=number(),
        nargs=2,
        metavar=("X", "Y"),
        help="Image motion, px/s, instead of the one in the file.",
    )


def given_conditions(options: Namespace) -> Conditions:
    """What `add_conditions` has read."""
    motion = options.motion_px_per_s
    return (
        options.ambient_scale,
        options.light_power,
        options.defocus_sigma_px,
        None if motion is None else (motion[0], motion[1]),
    )


def add_camera(parser: ArgumentParser, required: bool = True) -> None:
    """A camera, as an option or, where it is told by its place, as the next word."""
    parser.add_argument(
        "--camera",
        required=required,
        metavar="DEV_OR_TOML",
        help="A V4L2 device such as /dev/video0, or a camera file.",
    )


def add_target(parser: ArgumentParser, default: str | None) -> None:
    """What is in front of the camera."""
    parser.add_argument(
        "--target",
        default=default,
        metavar="NAME_OR_FILE",
        help="A target of targets/ or a .cao, OBJ, STL, PLY or glTF file"
        + ("." if default is None else " (default: %(default)s)."),
    )
    parser.add_argument(
        "--unit", default="m", help="Unit of the model file: m, cm, mm or in (default: %(default)s)."
    )


def add_equipment(parser: ArgumentParser) -> None:
    """Lights, and what is known of camera and target."""
    parser.add_argument(
        "--lights",
        metavar="DEV_OR_TOML",
        help="A serial device such as /dev/ttyUSB0, or a lights file.",
    )
    parser.add_argument(
        "--camera-model",
        type=Path,
        metavar="TOML",
        help="File with [camera], instead of that of the camera file.",
    )
    add_target(parser, None)
    parser.add_argument("--seed-pose", type=Path, metavar="TOML", help="File with [target.seed_pose].")
    parser.add_argument(
        "--dark-after-s",
        metavar="S",
        type=number(0),
        help="Turn the lights off when no request has come for so long; 0: never. Default: lights file.",
    )
