"""Running a device behind the wire protocol until it is told to stop."""

from __future__ import annotations

import faulthandler
from argparse import Namespace
from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from image_server.serve.device import Device


def serve_device(make_device: Callable[[], Device], options: Namespace) -> int:
    """Make a device and serve it where the options say; the exit status."""
    faulthandler.enable()  # where a crash was is told in the log
    from bridge.keys import server_keys
    from bridge.serve import serve
    from image_server.serve.server import ImageServer

    curve = server_keys(options.keys, "image_server")
    service = ImageServer(make_device())
    return serve(service, options.endpoint, options.events, options.parent, curve, options.idle_s)
