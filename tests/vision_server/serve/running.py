"""A service in a thread, for the tests of the vision server."""

import threading
from typing import Any

from bridge.client import Client
from bridge.serve import Server, Service

SETTINGS: dict[str, Any] = {"lights": [5, 5, 5], "shutter_s": 1 / 60, "aperture": 4.0}


class Running:
    """A service in a thread of its own."""

    def __init__(self, service: Service, endpoint: str) -> None:
        self.endpoint = endpoint
        self._server = Server(service, endpoint)
        self._thread = threading.Thread(target=self._server.run)
        self._thread.start()

    def stop(self) -> None:
        self._server.stop()
        self._thread.join(60)


def asked(client: Client, op: str, **args: Any) -> dict[str, Any]:
    return client.request(op, args)[0]
