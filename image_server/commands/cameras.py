"""`cameras`: list what is connected."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

from bridge.errors import BadInput, DeviceError, LightsAndCameraError


def add_options(_: ArgumentParser) -> None:
    """It has none."""


def run(_: Namespace) -> None:
    """Print each camera."""
    from image_server.v4l2.controls import controls
    from image_server.v4l2.node import Node
    from image_server.v4l2.stream import formats

    nodes = sorted(Path("/dev").glob("video*"), key=lambda path: (len(path.name), path.name))
    found = 0
    for path in nodes:
        try:
            node = Node(str(path))
        except LightsAndCameraError as error:
            if not isinstance(error, BadInput) or "permission" in error.message.lower():
                print(f"{path}: {error}")
            continue
        try:
            found += 1
            print(f"{path}: {node.card} ({node.driver}, {node.bus})")
            print(f"  formats: {', '.join(formats(node))}")
            for control in controls(node).values():
                print(f"  {control.in_words()}")
        finally:
            node.close()
    if not found:
        raise DeviceError("There is no camera that can be used.", "Is one connected?")
