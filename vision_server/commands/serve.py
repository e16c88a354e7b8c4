"""`python -m vision_server serve`: the server of a session."""

from __future__ import annotations

import faulthandler
import sys
from argparse import ArgumentParser, Namespace
from pathlib import Path

from bridge.command_line import whole_number


def add_options(parser: ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument(
        "--endpoint", required=True, help="Where to listen: ipc:///path or tcp://127.0.0.1:PORT."
    )
    parser.add_argument(
        "--keys",
        type=Path,
        metavar="DIR",
        help="CURVE keys (python -m bridge keys DIR), for servers on a network.",
    )
    parser.add_argument("--parent", type=whole_number(), metavar="PID", help="Stop when this process ends.")


def run(options: Namespace) -> int:
    """Serve until told to stop; the exit status."""
    from bridge.errors import EXIT_DEVICE, LightsAndCameraError

    faulthandler.enable()  # where a crash was is told in the log
    try:
        from bridge.keys import client_keys, server_keys
        from bridge.serve import serve
        from vision_server.serve.server import VisionServer

        service = VisionServer(client_keys(options.keys, "vision_server", "image_server"))
        curve = server_keys(options.keys, "vision_server")
        return serve(service, options.endpoint, parent_pid=options.parent, curve=curve)
    except (LightsAndCameraError, OSError) as error:
        print(f"vision_server: {' '.join(str(error).split())}", file=sys.stderr)
        return error.exit_status if isinstance(error, LightsAndCameraError) else EXIT_DEVICE
