"""Running a device behind the wire protocol until it is told to stop."""

from __future__ import annotations

import faulthandler
import sys
from argparse import Namespace
from collections.abc import Callable
from typing import TYPE_CHECKING

from bridge.errors import EXIT_DEVICE, LightsAndCameraError

if TYPE_CHECKING:
    from image_server.serve.device import Device


def plainly(work: Callable[[], int | None]) -> int:
    """The exit status of some work: one line and 2 for what cannot be used, and 4 for what failed."""
    try:
        return work() or 0
    except (LightsAndCameraError, OSError) as error:
        print(f"image_server: {' '.join(str(error).split())}", file=sys.stderr)
        return error.exit_status if isinstance(error, LightsAndCameraError) else EXIT_DEVICE


def serve_device(make_device: Callable[[], Device], options: Namespace) -> int:
    """Make a device and serve it where the options say; the exit status."""
    faulthandler.enable()  # where a crash was is told in the log

    def served() -> int:
        from bridge.keys import server_keys
        from bridge.serve import serve
        from image_server.serve.server import ImageServer

        curve = server_keys(options.keys, "image_server")
        service = ImageServer(make_device())
        return serve(service, options.endpoint, options.events, options.parent, curve, options.idle_s)

    return plainly(served)
