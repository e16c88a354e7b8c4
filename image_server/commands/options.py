"""Options that several commands share: each group is a dataclass, and a command takes it as one argument."""

import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from functools import wraps
from pathlib import Path
from typing import Annotated, Any, get_type_hints

import typer


def finite(value: float | tuple[float, float] | None) -> float | tuple[float, float] | None:
    """The value of an option, if it is not NaN or infinite."""
    numbers = value if isinstance(value, tuple) else (value,)
    if any(number is not None and not math.isfinite(number) for number in numbers):
        raise typer.BadParameter("it must be a finite number.")
    return value


@dataclass(frozen=True, kw_only=True)
class Serving:
    """Where a server listens, and what ends it."""

    endpoint: Annotated[str, typer.Option(help="Where to listen: ipc:///path or tcp://127.0.0.1:PORT.")]
    events: Annotated[str | None, typer.Option(help="Where to publish events; none: not published.")] = None
    keys: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="CURVE keys (python -m bridge keys DIR), to listen on a network."),
    ] = None
    parent: Annotated[int | None, typer.Option(metavar="PID", help="Stop when this process ends.")] = None


@dataclass(frozen=True, kw_only=True)
class Draws:
    """Where random draws come from."""

    seed: Annotated[
        int, typer.Option(min=0, help="Seed of every random draw: noise, and the simulator's poses.")
    ] = 0
    captures_taken: Annotated[
        int,
        typer.Option(min=0, help="Frames taken before by a session that goes on: noise is drawn from there."),
    ] = 0


@dataclass(frozen=True, kw_only=True)
class Conditions:
    """Light and blur instead of those in a stack or scenario file."""

    ambient_scale: Annotated[
        float | None,
        typer.Option(
            min=0,
            callback=finite,
            help="Strength of the sun instead of the one in the file; 0 is eclipse, 20 harsh.",
        ),
    ] = None
    light_power: Annotated[
        float | None, typer.Option(min=0, callback=finite, help="Multiply the power of every light.")
    ] = None
    defocus_sigma_px: Annotated[
        float | None,
        typer.Option(
            min=0, callback=finite, help="Blur at the widest aperture, px, instead of the one in the file."
        ),
    ] = None
    motion_px_per_s: Annotated[
        tuple[float, float] | None,
        typer.Option(
            metavar="X Y", callback=finite, help="Image motion, px/s, instead of the one in the file."
        ),
    ] = None

    def values(self) -> tuple[float | None, float | None, float | None, tuple[float, float] | None]:
        """In the order that `with_conditions` of stacks and scenarios takes them."""
        return self.ambient_scale, self.light_power, self.defocus_sigma_px, self.motion_px_per_s


def grouped(command: Callable[..., None]) -> Callable[..., None]:
    """A command whose arguments of a dataclass type are given as that dataclass's fields."""
    hints = get_type_hints(command, include_extras=True)
    groups = {name: kind for name, kind in hints.items() if is_dataclass(kind) and isinstance(kind, type)}
    parameters: list[inspect.Parameter] = []
    for name, parameter in inspect.signature(command).parameters.items():
        if name in groups:
            parameters.extend(_field_parameters(groups[name]))
        else:
            parameters.append(parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY, annotation=hints[name]))

    @wraps(command)
    def flat(**values: Any) -> None:
        made = {
            name: kind(**{field.name: values.pop(field.name) for field in fields(kind)})
            for name, kind in groups.items()
        }
        command(**values, **made)

    flat.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    flat.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    return flat


def _field_parameters(group: type) -> list[inspect.Parameter]:
    return [
        parameter.replace(annotation=get_type_hints(group, include_extras=True)[name])
        for name, parameter in inspect.signature(group).parameters.items()
    ]
