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
    add_draws,
    add_events,
    given_conditions,
)
from image_server.commands.serving import serve_device

if TYPE_CHECKING:
    from image_server.replay import Replay


def add_options(parser: ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument(
        "--stack", required=True, type=Path, metavar="DIR", help="Stack folder with its stack.toml."
    )
    add_serving(parser)
    add_events(parser)
    add_draws(parser)
    add_conditions(parser)


def run(options: Namespace) -> int:
    """Serve until told to stop; the exit status."""
    return serve_device(lambda: replay_device(options, given_conditions(options)), options)


def replay_device(options: Namespace, conditions: Conditions = AS_IN_THE_FILE) -> Replay:
    """The device of a stack folder under other conditions.

    Raises
    ------
    BadInput
        A stack that cannot be used, or conditions for recorded frames.
    """
    from image_server.replay import Replay
    from stack.read import BasisStack, load_stack, with_conditions

    stack = load_stack(options.stack)
    if isinstance(stack, BasisStack):
        stack = with_conditions(stack, *conditions)
    elif conditions != AS_IN_THE_FILE:
        raise BadInput(
            f"The stack {options.stack} holds recorded frames; their sun, lights and blur cannot be changed.",
            "Leave out --ambient-scale, --light-power, --defocus-sigma-px and --motion-px-per-s.",
        )
    return Replay(stack, options.seed, options.captures_taken)
