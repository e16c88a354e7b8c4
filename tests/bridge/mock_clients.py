"""Clients of mock servers, and a capture that these are asked for."""

from typing import Any

from bridge.client import Client

SETTINGS: dict[str, Any] = {"lights": [7, 7, 7], "shutter_s": 1 / 60, "aperture": 4.0}


def client_of(mock: Any, timeout_s: float = 20.0) -> Client:
    return Client(mock.endpoint, timeout_s=timeout_s)


def captured(client: Client, image: str, **changes: Any) -> dict[str, Any]:
    return client.request("capture", {"image": image, "settings": {**SETTINGS, **changes}})[0]
