"""Options that several commands share: each group is a dataclass, and a command takes it as one argument."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from image_server.command_line import Option


@dataclass(frozen=True, kw_only=True)
class Serving:
    """Where a server listens, and what ends it."""

    endpoint: Annotated[str, Option(help="Where to listen: ipc:///path or tcp://127.0.0.1:PORT.")]
    events: Annotated[str | None, Option(help="Where to publish events; none: not published.")] = None
    keys: Annotated[
        Path | None,
        Option(metavar="DIR", help="CURVE keys (python -m bridge keys DIR), to listen on a network."),
    ] = None
    parent: Annotated[int | None, Option(metavar="PID", help="Stop when this process ends.")] = None


@dataclass(frozen=True, kw_only=True)
class Draws:
    """Where random draws come from."""

    seed: Annotated[
        int, Option(min=0, help="Seed of every random draw: noise, and the simulator's poses.")
    ] = 0
    captures_taken: Annotated[
        int,
        Option(min=0, help="Frames taken before by a session that goes on: noise is drawn from there."),
    ] = 0


@dataclass(frozen=True, kw_only=True)
class Conditions:
    """Light and blur instead of those in a stack or scenario file."""

    ambient_scale: Annotated[
        float | None,
        Option(
            min=0,
            help="Strength of the sun instead of the one in the file; 0 is eclipse, 20 harsh.",
        ),
    ] = None
    light_power: Annotated[float | None, Option(min=0, help="Multiply the power of every light.")] = None
    defocus_sigma_px: Annotated[
        float | None,
        Option(min=0, help="Blur at the widest aperture, px, instead of the one in the file."),
    ] = None
    motion_px_per_s: Annotated[
        tuple[float, float] | None,
        Option(metavar="X Y", help="Image motion, px/s, instead of the one in the file."),
    ] = None

    def values(self) -> tuple[float | None, float | None, float | None, tuple[float, float] | None]:
        """In the order that `with_conditions` of stacks and scenarios takes them."""
        return self.ambient_scale, self.light_power, self.defocus_sigma_px, self.motion_px_per_s
