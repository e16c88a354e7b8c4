"""Command line of the bridge: `python -m bridge keys DIR`."""

from pathlib import Path
from typing import Annotated

import typer

from bridge.errors import LightsAndCameraError

app = typer.Typer(
    help="What the three programs share.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


@app.callback()
def bridge() -> None:
    """What the three programs share."""


@app.command()
def keys(folder: Annotated[Path, typer.Argument(metavar="DIR", help="New folder for the keys.")]) -> None:
    """Make keys for servers that are reached over a network: for both servers and the controller."""
    from bridge.keys import make_keys

    try:
        for file in make_keys(folder):
            typer.echo(file)
    except LightsAndCameraError as error:
        typer.echo(f"bridge: {error}", err=True)
        raise typer.Exit(error.exit_status) from None


if __name__ == "__main__":
    app(prog_name="python -m bridge")
