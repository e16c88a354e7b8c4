"""Mock servers for people who write controllers, as classes, as pytest fixtures and as a command.

In a ``conftest.py``::

    from bridge.mocks import mock_image_server, mock_vision_server

and then a test takes ``mock_vision_server``, points its client at ``.endpoint``, and scripts what it needs
(`bridge.mock_server.MockServer`). Unscripted requests get plausible answers (`bridge.mock_physics`).

For a client in another process, such as a Prolog test::

    python -m bridge.mocks vision --endpoint ipc:///tmp/v --parent PID --script script.json
"""

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from bridge import mock_physics
from bridge.arrays import array_sha256
from bridge.errors import BadInput, LightsAndCameraError
from bridge.image_messages import IMAGE_OPERATIONS, ImageCaptureArgs, MoveArgs, RestartArgs
from bridge.lifeline import Lifeline
from bridge.messages import Settings
from bridge.mock_script import apply_script, read_script
from bridge.mock_server import MockServer, RecordedRequest
from bridge.serve import Reply
from bridge.start_messages import RestoreArgs, StartArgs
from bridge.vision_messages import (
    VISION_OPERATIONS,
    AddArgs,
    DiscardArgs,
    EstimateArgs,
    VisionCaptureArgs,
)

__all__ = [
    "MockImageServer",
    "MockServer",
    "MockVisionServer",
    "RecordedRequest",
    "mock_image_server",
    "mock_vision_server",
]


class MockImageServer(MockServer):
    """An image server that photographs a grey square.

    Attributes
    ----------
    description
        What `describe` answers; replace it to mock another device.
    """

    def __init__(self, endpoint: str | None = None, events: str | None = None) -> None:
        self._sequence = 0
        super().__init__(
            "mock image server",
            IMAGE_OPERATIONS,
            {
                "describe": lambda _: Reply(self.description),
                "capture": self._capture,
                "health": self.health,
                "restart": self._restart,
                "move": self._move,
                "score": lambda _: Reply({"error": None}),
            },
            endpoint,
            events,
        )
        self.description = mock_physics.describe(self.events)

    def _capture(self, args: ImageCaptureArgs) -> Reply:
        _check_settings(args.settings, self.description)
        self._sequence += 1
        pixels = mock_physics.frame(args.settings, self.description)
        result = {
            "requested": args.settings,
            "applied": args.settings,
            "verified": True,
            "sequence": self._sequence,
            "timestamp": 1.7e9 + self._sequence,
            "devices": {"camera": "mock"},
            "sha256": array_sha256(pixels),
        }
        return Reply(result, [pixels])

    def _restart(self, args: RestartArgs) -> Reply:
        self._sequence = args.captures_taken
        return Reply({"events": []})

    def _move(self, args: MoveArgs) -> Reply:
        moved = {"event": "target_moved", "args": {"range_m": args.range_m}}
        self.publish("target_moved", {"range_m": args.range_m})
        return Reply({"range_m": args.range_m, "events": [moved]})


class MockVisionServer(MockServer):
    """A vision server whose error falls as the set of well-exposed images grows; it asks no image server.

    Attributes
    ----------
    description
        The device that `start` answers with; replace it to mock another one.
    images
        Statistics of the images taken, by name.
    """

    def __init__(self, endpoint: str | None = None, events: str | None = None) -> None:
        self.images: dict[str, dict[str, Any]] = {}
        self._used: set[str] = set()
        self._best: dict[str, Any] | None = None
        self._parameters: dict[str, Any] = {}
        super().__init__(
            "mock vision server",
            VISION_OPERATIONS,
            {
                "start": self._start,
                "capture": self.capture,
                "add": self.capture,
                "end": lambda _: Reply({}),
                "estimate": self.estimate,
                "discard": self._discard,
                "best": lambda _: Reply(self._best or mock_physics.estimate({})),
                "appraise": lambda _: Reply({"gamma": 1.0}),
                "predict": lambda _: Reply({"gains": None}),
                "parameters": self._set_parameters,
                "restore": self._restore,
                "health": self.health,
            },
            endpoint,
            events,
        )
        self.description = mock_physics.describe(self.events)

    def _start(self, args: StartArgs) -> Reply:
        self.images.clear()
        self._used.clear()
        self._best = None
        model = {"name": "mock", "lines": mock_physics.LINES, "faces": 6}
        return Reply({"model": model, "describe": self.description})

    def _restore(self, args: RestoreArgs) -> Reply:
        reply = self._start(args)
        full = Settings(lights=tuple(light.levels - 1 for light in self.description.lights), **_REFERENCE)
        self._used.update((*args.images, *args.discarded))
        self.images.update({name: mock_physics.statistics(full, self.description) for name in args.images})
        return reply

    def capture(self, args: VisionCaptureArgs | AddArgs) -> Reply:
        """The plausible answer: what a scripted one may end with."""
        _check_settings(args.settings, self.description)
        if args.image in self._used:
            raise BadInput(f"There has been an image {args.image!r} already.", "Use a new name.")
        self._used.add(args.image)
        statistics = mock_physics.statistics(args.settings, self.description)
        self.images[args.image] = statistics
        return Reply(
            {
                "image": args.image,
                "applied": args.settings,
                "verified": True,
                "statistics": statistics,
                "seconds": {"capture": 0.001, "edges": 0.001},
            }
        )

    def estimate(self, args: EstimateArgs) -> Reply:
        """The plausible answer: what a scripted one may change."""
        for name in args.images:
            self._known(name)
        self._best = mock_physics.estimate({name: self.images[name] for name in args.images})
        return Reply(self._best)

    def _discard(self, args: DiscardArgs) -> Reply:
        self._known(args.image)
        del self.images[args.image]
        return Reply({"image": args.image, "images": list(self.images)})

    def _set_parameters(self, args: dict[str, Any]) -> Reply:
        self._parameters.update(args)
        return Reply(dict(self._parameters))

    def _known(self, name: str) -> None:
        if name not in self.images:
            raise BadInput(
                f"There is no image {name!r}.", f"There are: {', '.join(self.images) or 'none yet'}."
            )


_REFERENCE = {"shutter_s": 1 / 60, "aperture": 4.0}


def _check_settings(settings: Settings, device: Any) -> None:
    levels = [light.levels for light in device.lights]
    if len(settings.lights) != len(levels):
        raise BadInput(f"{len(settings.lights)} light levels were given for {len(levels)} lights.")
    for light, level in zip(device.lights, settings.lights, strict=True):
        if level >= light.levels:
            raise BadInput(f"Light {light.name!r} has no level {level}.", f"Use 0 to {light.levels - 1}.")


@pytest.fixture
def mock_image_server() -> Iterator[MockImageServer]:
    """A running mock image server."""
    with MockImageServer() as server:
        yield server


@pytest.fixture
def mock_vision_server() -> Iterator[MockVisionServer]:
    """A running mock vision server."""
    with MockVisionServer() as server:
        yield server


def main(argv: list[str] | None = None) -> int:
    """Run one mock server as a process; returns its exit status."""
    parser = argparse.ArgumentParser(prog="python -m bridge.mocks", description=main.__doc__)
    parser.add_argument("kind", choices=["image", "vision"])
    parser.add_argument("--endpoint", required=True)
    parser.add_argument("--events")
    parser.add_argument("--parent", type=int, help="process to end with")
    parser.add_argument("--script", type=Path, help="JSON file, see docs/protocol.md")
    options = parser.parse_args(argv)
    try:
        kind = MockImageServer if options.kind == "image" else MockVisionServer
        mock = kind(options.endpoint, options.events or options.endpoint + "-events")
        if options.script is not None:
            apply_script(mock, read_script(options.script))
        return mock.run(Lifeline(options.parent, signals=True))
    except LightsAndCameraError as error:
        print(error, file=sys.stderr)
        return error.exit_status


if __name__ == "__main__":
    sys.exit(main())
