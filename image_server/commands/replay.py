"""`replay`: serve a recorded light stack."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from bridge.command_line import add_serving
from bridge.errors import BadInput
from image_server.commands.options import (
    AS_IN_THE_FILE,
    Conditions,
    add_conditions,
    add_deaths,
    add_events,
    add_past,
    add_seed,
    given_conditions,
    with_deaths,
)
from image_server.commands.serving import serve_device

if TYPE_CHECKING:
    from image_server.replay import Replay


def add_options(parser: ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument(
        "--stack", required=True, type=Path, metavar="DIR", help="Stack folder with its stack.toml."
    )
    parser.add_argument(
        "--nearest",
        action="store_true",
        help="Recorded frames: take the nearest settings where others are asked for, rather than refuse.",
    )
    parser.add_argument(
        "--shown",
        type=Path,
        metavar="DIR",
        help="Images of a session that goes on: recorded frames that it has seen do not come again.",
    )
    add_serving(parser)
    add_events(parser)
    add_seed(parser)
    add_past(parser)
    add_conditions(parser)
    add_deaths(parser)


def run(options: Namespace) -> int:
    """Serve until told to stop; the exit status."""
    conditions = given_conditions(options)
    return serve_device(
        lambda: with_deaths(replay_device(options, conditions, options.nearest, options.shown), options),
        options,
    )


def replay_device(
    options: Namespace,
    conditions: Conditions = AS_IN_THE_FILE,
    nearest: bool = False,
    shown: Path | None = None,
) -> Replay:
    """The device of a stack folder under other conditions.

    Raises
    ------
    BadInput
        A stack that cannot be used, or conditions for recorded frames.
    """
    from image_server.replay import Replay
    from stack.read import BasisStack, load_stack, recorded_frames, with_conditions

    stack = load_stack(options.stack)
    if isinstance(stack, BasisStack):
        stack = with_conditions(stack, *conditions)
    elif conditions != AS_IN_THE_FILE:
        raise BadInput(
            f"The stack {options.stack} holds recorded frames; their sun, lights and blur cannot be changed.",
            "Leave out --ambient-scale, --light-power, --defocus-sigma-px and --motion-px-per-s.",
        )
    frames = {} if shown is None else recorded_frames(shown)
    shown_before = [frame.settings() for frame in frames.values()]
    return Replay(stack, options.seed, options.captures_taken, nearest, shown_before)
