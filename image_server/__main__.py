"""Command line of the image server."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bridge.errors import EXIT_DEVICE, LightsAndCameraError

if TYPE_CHECKING:
    from collections.abc import Callable

    from image_server.device import Device

app = typer.Typer(
    help="Camera and lights behind the wire protocol: settings in, frame out.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


def finite(value: float | tuple[float, float] | None) -> float | tuple[float, float] | None:
    """The value of an option, if it is not NaN or infinite."""
    numbers = value if isinstance(value, tuple) else (value,)
    if any(number is not None and not math.isfinite(number) for number in numbers):
        raise typer.BadParameter("it must be a finite number.")
    return value


Endpoint = Annotated[str, typer.Option(help="Where to listen: ipc:///path or tcp://127.0.0.1:PORT.")]
Events = Annotated[str | None, typer.Option(help="Where to publish events; none: not published.")]
Parent = Annotated[int | None, typer.Option(metavar="PID", help="Stop when this process ends.")]
Seed = Annotated[
    int, typer.Option(min=0, help="Seed of every random draw: noise, and the simulator's poses.")
]
Ambient = Annotated[
    float | None,
    typer.Option(
        min=0,
        callback=finite,
        help="Strength of the sun instead of the one in the file; 0 is eclipse, 20 harsh.",
    ),
]
Power = Annotated[
    float | None, typer.Option(min=0, callback=finite, help="Multiply the power of every light.")
]
Defocus = Annotated[
    float | None,
    typer.Option(
        min=0, callback=finite, help="Blur at the widest aperture, px, instead of the one in the file."
    ),
]
Motion = Annotated[
    tuple[float, float] | None,
    typer.Option(metavar="X Y", callback=finite, help="Image motion, px/s, instead of the one in the file."),
]


@app.command()
def replay(
    stack: Annotated[Path, typer.Option(metavar="DIR", help="Stack folder with its stack.toml.")],
    endpoint: Endpoint,
    events: Events = None,
    parent: Parent = None,
    seed: Seed = 0,
    ambient_scale: Ambient = None,
    light_power: Power = None,
    defocus_sigma_px: Defocus = None,
    motion_px_per_s: Motion = None,
) -> None:
    """Serve a recorded light stack."""

    def device() -> "Device":
        from bridge.errors import BadInput
        from image_server.replay import Replay
        from image_server.stack import BasisStack, load_stack, with_conditions

        loaded = load_stack(stack)
        conditions = (ambient_scale, light_power, defocus_sigma_px, motion_px_per_s)
        if isinstance(loaded, BasisStack):
            loaded = with_conditions(loaded, *conditions)
        elif any(condition is not None for condition in conditions):
            raise BadInput(
                f"The stack {stack} holds recorded frames; their sun, lights and blur cannot be changed.",
                "Leave out --ambient-scale, --light-power, --defocus-sigma-px and --motion-px-per-s.",
            )
        return Replay(loaded, seed)

    _serve(device, endpoint, events, parent)


@app.command()
def simulator(
    endpoint: Endpoint,
    target: Annotated[
        str,
        typer.Option(metavar="NAME_OR_FILE", help="A target of targets/ or a .cao, OBJ, STL or PLY file."),
    ] = "cube",
    scenario: Annotated[
        str, typer.Option(metavar="NAME_OR_FILE", help="A scenario of scenarios/ or a TOML file.")
    ] = "nominal",
    unit: Annotated[str, typer.Option(help="Unit of the model file: m, cm, mm or in.")] = "m",
    events: Events = None,
    parent: Parent = None,
    seed: Seed = 0,
    ambient_scale: Ambient = None,
    light_power: Power = None,
    defocus_sigma_px: Defocus = None,
    motion_px_per_s: Motion = None,
) -> None:
    """Serve a ray-traced target under lights and a sun; the seed draws its true pose."""

    def device() -> "Device":
        from image_server.simulator import Simulator
        from image_server.simulator.scenario import load_scenario, with_conditions

        described = with_conditions(
            load_scenario(scenario), ambient_scale, light_power, defocus_sigma_px, motion_px_per_s
        )
        return Simulator(target, described, seed, unit=unit)

    _serve(device, endpoint, events, parent)


def _serve(
    make_device: "Callable[[], Device]", endpoint: str, events: str | None, parent: int | None
) -> None:
    """Run a device until it is told to stop; what cannot be used ends with one line and exit 2."""
    try:
        from bridge.serve import serve
        from image_server.server import ImageServer

        status = serve(ImageServer(make_device()), endpoint, events=events, parent_pid=parent)
    except (LightsAndCameraError, OSError) as error:
        typer.echo(f"image_server: {' '.join(str(error).split())}", err=True)
        status = error.exit_status if isinstance(error, LightsAndCameraError) else EXIT_DEVICE
    raise typer.Exit(status)


if __name__ == "__main__":
    app(prog_name="image_server")
