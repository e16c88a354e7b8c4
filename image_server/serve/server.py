"""The image server: a device behind the wire protocol (docs/protocol.md)."""

import msgspec

from bridge.arrays import array_sha256
from bridge.image_messages import ImageCaptureArgs, ImageCaptureResult, MoveArgs, RestartArgs, ScoreArgs
from bridge.messages import EventTold, NoArgs
from bridge.serve import Reply, Service
from image_server.serve.device import Change, Device, setting_ranges


class ImageServer(Service):
    """Operations of an image server over one device; what happens to the scene is published."""

    name = "image_server"
    prompt = frozenset({"health"})

    def __init__(self, device: Device) -> None:
        self._device = device
        self._told: list[EventTold] = []  # since the request in hand began
        self.operations = {
            "describe": (NoArgs, self._on_describe),
            "capture": (ImageCaptureArgs, self._on_capture),
            "health": (NoArgs, self._on_health),
            "restart": (RestartArgs, self._on_restart),
            "move": (MoveArgs, self._on_move),
            "score": (ScoreArgs, self._on_score),
        }
        device.listen(self._publish)

    def close(self) -> None:
        """Leave the hardware dark and free."""
        self._device.close()

    def _publish(self, change: Change) -> None:
        sequence = self.emit(change.event, change.args)
        self._told.append(EventTold(event=change.event, args=change.args, sequence=sequence))

    def _on_describe(self, _: NoArgs) -> Reply:
        described = self._device.describe()
        ranges = (*setting_ranges(described), *described.ranges)
        return Reply(msgspec.structs.replace(described, ranges=ranges, events=self.events_endpoint))

    def _on_capture(self, args: ImageCaptureArgs) -> Reply:
        self._told = []
        if args.number is not None:
            self._device.come_to(args.number)
        frame = self._device.capture(args.settings)
        header = ImageCaptureResult(
            requested=frame.requested,
            applied=frame.applied,
            verified=frame.verified,
            sequence=frame.sequence,
            timestamp=frame.timestamp,
            devices=frame.devices,
            sha256=array_sha256(frame.pixels),
            events=tuple(self._told),
        )
        return Reply(header, [frame.pixels])

    def _on_health(self, _: NoArgs) -> Reply:
        return Reply(self._device.health())

    def _on_restart(self, args: RestartArgs) -> Reply:
        changes = self._device.restart(args.seed, args.captures_taken, args.moves)
        return Reply({"events": [EventTold(event=change.event, args=change.args) for change in changes]})

    def _on_move(self, args: MoveArgs) -> Reply:
        self._told = []
        for change in self._device.move(args.range_m):
            self._publish(change)
        return Reply({"range_m": args.range_m, "events": self._told})

    def _on_score(self, args: ScoreArgs) -> Reply:
        error = self._device.score(args.pose, args.moves)
        return Reply({"error": None if error is None else msgspec.to_builtins(error)})
