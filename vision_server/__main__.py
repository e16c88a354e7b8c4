"""Command line of the vision server: `python -m vision_server COMMAND`."""

from __future__ import annotations

from typing import Annotated

import typer

app = typer.Typer(
    help="Images in, edges and poses out.",
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)


@app.command()
def serve(
    endpoint: Annotated[str, typer.Option(help="Where to listen: ipc:///path or tcp://127.0.0.1:PORT.")],
    parent: Annotated[int | None, typer.Option(metavar="PID", help="Stop when this process ends.")] = None,
) -> None:
    """Serve pose estimation to a controller."""
    from bridge.errors import EXIT_DEVICE, LightsAndCameraError

    try:
        from bridge.serve import serve as run
        from vision_server.server import VisionServer

        status = run(VisionServer(), endpoint, parent_pid=parent)
    except (LightsAndCameraError, OSError) as error:
        typer.echo(f"vision_server: {' '.join(str(error).split())}", err=True)
        status = error.exit_status if isinstance(error, LightsAndCameraError) else EXIT_DEVICE
    raise typer.Exit(status)


@app.command()
def warm() -> None:
    """Compile every numeric kernel into the cache, once."""
    from vision_server.commands.warm import warm_up

    warm_up()


def _commands() -> None:
    from vision_server.commands.edges import edges_command
    from vision_server.commands.estimate import estimate_command

    app.command("estimate")(estimate_command)
    app.command("edges")(edges_command)


if __name__ == "__main__":
    _commands()
    app(prog_name="python -m vision_server")
