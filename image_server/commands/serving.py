"""Running a device behind the wire protocol until it is told to stop."""

import faulthandler
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from bridge.errors import EXIT_DEVICE, LightsAndCameraError
from image_server.commands.options import Serving
from numerics.memory import keep_freed_memory

if TYPE_CHECKING:
    from image_server.serve.device import Device


@contextmanager
def plain_errors() -> Iterator[None]:
    """What cannot be used ends the command with one line and exit 2; what failed, with exit 4."""
    try:
        yield
    except (LightsAndCameraError, OSError) as error:
        print(f"image_server: {' '.join(str(error).split())}", file=sys.stderr)
        status = error.exit_status if isinstance(error, LightsAndCameraError) else EXIT_DEVICE
        raise SystemExit(status) from None


def serve_device(make_device: "Callable[[], Device]", serving: Serving) -> None:
    """Make a device and serve it; the exit status is the server's."""
    faulthandler.enable()  # where a crash was is told in the log
    keep_freed_memory()
    with plain_errors():
        from bridge.keys import server_keys
        from bridge.lifeline import leave
        from bridge.serve import serve
        from image_server.serve.server import ImageServer

        curve = server_keys(serving.keys, "image_server")
        service = ImageServer(make_device())
        leave(serve(service, serving.endpoint, serving.events, parent_pid=serving.parent, curve=curve))
