"""`replay`: serve a recorded light stack."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from bridge.errors import BadInput
from image_server.command_line import Option
from image_server.commands.options import Conditions, Draws, Serving
from image_server.commands.serving import serve_device

if TYPE_CHECKING:
    from image_server.replay import Replay


def replay(
    stack: Annotated[Path, Option(metavar="DIR", help="Stack folder with its stack.toml.")],
    serving: Serving,
    draws: Draws,
    conditions: Conditions,
) -> None:
    """Serve a recorded light stack."""
    serve_device(lambda: replay_device(stack, draws, conditions), serving)


def replay_device(stack: Path, draws: Draws, conditions: Conditions) -> "Replay":
    """The device of a stack folder under other conditions.

    Raises
    ------
    BadInput : a stack that cannot be used, or conditions for recorded frames.
    """
    from image_server.replay import Replay
    from stack.read import BasisStack, load_stack, with_conditions

    loaded = load_stack(stack)
    if isinstance(loaded, BasisStack):
        loaded = with_conditions(loaded, *conditions.values())
    elif any(condition is not None for condition in conditions.values()):
        raise BadInput(
            f"The stack {stack} holds recorded frames; their sun, lights and blur cannot be changed.",
            "Leave out --ambient-scale, --light-power, --defocus-sigma-px and --motion-px-per-s.",
        )
    return Replay(loaded, draws.seed, draws.captures_taken)
