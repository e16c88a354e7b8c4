"""Command line of the image server."""

import typer

from image_server.commands.bench import bench
from image_server.commands.calibrate import calibrate
from image_server.commands.emulate import emulate
from image_server.commands.hardware import cameras, hardware
from image_server.commands.record import record
from image_server.commands.replay import replay
from image_server.commands.simulate import simulator
from image_server.commands.warm import warm

app = typer.Typer(
    help="Camera and lights behind the wire protocol: settings in, frame out.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
app.command()(replay)
app.command()(simulator)
app.command()(hardware)
app.command()(cameras)
app.command()(calibrate)
app.command()(emulate)
app.command()(bench)
app.command()(record)
app.command()(warm)


if __name__ == "__main__":
    app(prog_name="image_server")
