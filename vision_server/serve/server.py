"""The vision server: the pose task of a session behind the wire protocol (docs/architecture.md)."""

from __future__ import annotations

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec

from bridge.client import Client
from bridge.endpoints import CurveClient
from bridge.errors import BadInput, DeviceError, LightsAndCameraError
from bridge.messages import (
    Describe,
    DiscardArgs,
    EstimateArgs,
    ImageCaptureResult,
    NoArgs,
    RestoreArgs,
    StartArgs,
    VisionCaptureArgs,
)
from bridge.serve import Reply, Service
from stack.format import FrameTable
from stack.read import recorded_frames
from vision_server.channels.image_files import read_grey
from vision_server.serve.recorder import FOLDER
from vision_server.serve.results import estimate_result, restored_estimate
from vision_server.serve.task import PoseTask, open_task

IMAGE_SERVER_DEADLINE_S = 30.0  # of one capture: a long shutter, and a camera that has to wake up


class VisionServer(Service):
    """Operations of the vision server; one task at a time, begun by `start` or `restore`.

    Parameters
    ----------
    curve : keys with which it calls an image server on a network.
    """

    name = "vision_server"

    def __init__(self, curve: CurveClient | None = None) -> None:
        self._curve = curve
        self._task: PoseTask | None = None
        self._client: Client | None = None
        self.operations = {
            "start": (StartArgs, self._on_start),
            "capture": (VisionCaptureArgs, self._on_capture),
            "estimate": (EstimateArgs, self._on_estimate),
            "discard": (DiscardArgs, self._on_discard),
            "best": (NoArgs, self._on_best),
            "parameters": (dict[str, Any], self._on_parameters),
            "restore": (RestoreArgs, self._on_restore),
        }

    def close(self) -> None:
        """Write the frames that are not on the disk yet, and let go of the image server."""
        self._end()

    def _end(self) -> None:
        if self._task is not None and self._task.recorder is not None:
            self._task.recorder.close()
        if self._client is not None:
            self._client.close()
        self._task = self._client = None

    def _open(self, args: StartArgs, recorded: Mapping[str, FrameTable] | None = None) -> PoseTask:
        self._end()
        client = Client(args.image_server, timeout_s=IMAGE_SERVER_DEADLINE_S, curve=self._curve)
        try:
            result, _ = client.request("describe")
            task = open_task(args, _checked(result, Describe, args.image_server), recorded)
        except LightsAndCameraError:
            client.close()
            raise
        self._client, self._task = client, task
        return task

    def _on_start(self, args: StartArgs) -> Reply:
        return _started(self._open(args))

    def _on_restore(self, args: RestoreArgs) -> Reply:
        out = Path(args.out)
        frames = recorded_frames(out / FOLDER)
        missing = [image for image in args.images if image not in frames]
        if missing:
            raise BadInput(
                f"{out / FOLDER} has no image {missing[0]}.", f"It has {', '.join(frames) or 'none'}."
            )
        known = {*args.images, *args.discarded}
        task = self._open(args, {name: frame for name, frame in frames.items() if name in known})
        for step in args.told:
            if step.estimate is not None:
                task.note(restored_estimate(step.estimate))
            task.set_parameters(step.parameters)
        for image in args.images:
            task.add(image, read_grey(out / FOLDER / f"{image}.png"), frames[image].settings())
        task.retired |= set(args.discarded)
        return _started(task)

    def _on_capture(self, args: VisionCaptureArgs) -> Reply:
        task, client = self._here()
        task.check_name(args.image)
        began = time.perf_counter()
        result, arrays = client.request("capture", {"settings": msgspec.to_builtins(args.settings)})
        captured = time.perf_counter()
        header = _checked(result, ImageCaptureResult, client.endpoint)
        if len(arrays) != 1 or arrays[0].ndim != 2 or arrays[0].dtype != "uint8":
            raise DeviceError(f"The image server at {client.endpoint} sent no grey uint8 frame.")
        pixels = arrays[0]
        if task.recorder is not None:
            task.recorder.save(args.image, header.applied, pixels)  # while its edges are looked for
        statistics = task.add(args.image, pixels, header.applied)
        if task.recorder is not None:
            task.recorder.flush()  # what is answered is on the disk: a session can be resumed
        return Reply(
            {
                "image": args.image,
                "applied": header.applied,
                "verified": header.verified,
                "statistics": statistics,
                "seconds": {"capture": captured - began, "edges": time.perf_counter() - captured},
            }
        )

    def _on_estimate(self, args: EstimateArgs) -> Reply:
        task, _ = self._here()
        return Reply(estimate_result(task.estimate(args.images)))

    def _on_discard(self, args: DiscardArgs) -> Reply:
        task, _ = self._here()
        task.discard(args.image)
        return Reply({"image": args.image, "images": list(task.images.images)})

    def _on_best(self, _: NoArgs) -> Reply:
        task, _client = self._here()
        if task.best is None:
            return Reply(
                {"pose": None, "covariance": None, "rms_px": None, "uncertainty": None, "score": 0.0}
            )
        return Reply({**estimate_result(task.best), "seconds": {}})

    def _on_parameters(self, values: dict[str, Any]) -> Reply:
        task, _ = self._here()
        return Reply(task.set_parameters(values))

    def _here(self) -> tuple[PoseTask, Client]:
        if self._task is None or self._client is None:
            raise BadInput("No session has been started on this vision server.", "Send start first.")
        return self._task, self._client


def _started(task: PoseTask) -> Reply:
    model = task.model
    return Reply(
        {
            "model": {"name": model.name, "lines": len(model.lines), "faces": len(model.faces)},
            "describe": task.describe,
        }
    )


def _checked(result: dict[str, Any], kind: Any, endpoint: str) -> Any:
    try:
        return msgspec.convert(result, kind)
    except (msgspec.ValidationError, ValueError) as error:
        raise DeviceError(
            f"The image server at {endpoint} sent a malformed {kind.__name__}: {error}.",
            "Is it an image server of this version?",
        ) from error
