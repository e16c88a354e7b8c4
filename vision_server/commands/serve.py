"""`python -m vision_server serve`: the server of a session."""

from __future__ import annotations

import faulthandler
import sys
from argparse import ArgumentParser, Namespace

from bridge.command_line import add_serving


def add_options(parser: ArgumentParser) -> None:
    """Options of the command."""
    add_serving(parser)


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
        return serve(service, options.endpoint, None, options.parent, curve, options.idle_s)
    except (LightsAndCameraError, OSError) as error:
        print(f"vision_server: {' '.join(str(error).split())}", file=sys.stderr)
        return error.exit_status if isinstance(error, LightsAndCameraError) else EXIT_DEVICE
