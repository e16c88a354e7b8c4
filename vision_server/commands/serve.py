"""`python -m vision_server serve`: the server of a session."""

from __future__ import annotations

import faulthandler
from argparse import ArgumentParser, Namespace
from pathlib import Path

from bridge.command_line import add_serving
from bridge.errors import BadInput


def add_options(parser: ArgumentParser) -> None:
    """Options of the command."""
    add_serving(parser)
    parser.add_argument(
        "--root",
        type=Path,
        action="append",
        metavar="DIR",
        help="Sessions may read and write in this folder only; more than one may be given "
        "(default: anywhere, but on tcp:// without keys, where all users are let in, the current folder).",
    )
    parser.add_argument(
        "--image-server",
        metavar="ENDPOINT",
        help="The image server of the sessions, where it is known: the model file that it names may be read "
        "wherever that is, also with --root.",
    )


def run(options: Namespace) -> int:
    """Serve until told to stop; the exit status."""
    faulthandler.enable()  # where a crash was is told in the log
    from bridge.endpoints import open_to_all
    from bridge.keys import client_keys, server_keys
    from bridge.serve import serve
    from vision_server.serve.files import Files
    from vision_server.serve.server import VisionServer

    strangers = options.keys is None and open_to_all(options.endpoint)
    for root in options.root or ():
        if not root.is_dir():
            raise BadInput(
                f"--root {root} is {'a file' if root.exists() else 'not there'}.", "Name a folder."
            )
    roots = options.root or ([Path.cwd()] if strangers else None)
    files = Files(None if roots is None else tuple(roots), options.image_server)
    service = VisionServer(client_keys(options.keys, "vision_server", "image_server"), files)
    curve = server_keys(options.keys, "vision_server")
    return serve(service, options.endpoint, None, options.parent, curve, options.idle_s)
