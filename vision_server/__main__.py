"""Command line of the vision server: `python -m vision_server COMMAND`."""

from __future__ import annotations

import typer

from vision_server.commands.edges import edges_command

app = typer.Typer(add_completion=False, no_args_is_help=True, pretty_exceptions_enable=False)


@app.callback()
def vision_server() -> None:
    """Images in, edges and poses out."""


app.command("edges")(edges_command)

if __name__ == "__main__":
    app(prog_name="python -m vision_server")
