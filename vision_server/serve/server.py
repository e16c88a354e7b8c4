"""The vision server: the pose task of a session behind the wire protocol (docs/protocol.md)."""

from __future__ import annotations

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from bridge.arrays import FramePixels, is_frame
from bridge.client import Client
from bridge.endpoints import CurveClient
from bridge.errors import BadInput, DeviceError
from bridge.image_messages import CAPTURE_S, ImageCaptureResult, capture_deadline_s
from bridge.messages import Describe, NoArgs, PoseMessage
from bridge.received import received, received_frame
from bridge.serve import Reply, Service
from bridge.start_messages import ModelTold, RestoreArgs, StartArgs, StartResult
from bridge.vision_messages import (
    AddArgs,
    AppraiseArgs,
    CheckArgs,
    DiscardArgs,
    EstimateArgs,
    ParametersArgs,
    PredictArgs,
    TrackArgs,
    VisionCaptureArgs,
)
from geometry.pose import Pose
from stack.format import FrameTable
from stack.read import recorded_frames, recorded_seed_pose
from vision_server.channels.image_files import read_pixels
from vision_server.serve.described import camera_doubt, lights_doubt
from vision_server.serve.files import ANY_FILES, Files
from vision_server.serve.inputs import model_warning, picture_px
from vision_server.serve.opening import GIVEN_FRAMES, given_values, open_task
from vision_server.serve.recorder import FOLDER
from vision_server.serve.results import estimate_result, model_wrong, restored_estimate
from vision_server.serve.sessions import Session, Sessions
from vision_server.serve.taking import taken
from vision_server.serve.task import PoseTask
from vision_server.trust.judgement import Estimate

RETRIES = 29  # about one a second: an image server that died may be there again, and answers nothing twice


class VisionServer(Service):
    """Operations of the vision server: a session for each client, begun by `start` or `restore`.

    Parameters
    ----------
    curve
        Keys with which it calls an image server on a network.
    files
        Which files sessions may name.
    """

    name = "vision_server"
    exclusive = False
    with_arrays = frozenset({"add", "track"})

    def __init__(self, curve: CurveClient | None = None, files: Files = ANY_FILES) -> None:
        self._curve, self._files = curve, files
        self._sessions = Sessions()
        self.operations = {
            "start": (StartArgs, self._on_start),
            "capture": (VisionCaptureArgs, self._on_capture),
            "add": (AddArgs, self._on_add),
            "estimate": (EstimateArgs, self._on_estimate),
            "track": (TrackArgs, self._on_track),
            "check": (CheckArgs, self._on_check),
            "discard": (DiscardArgs, self._on_discard),
            "best": (NoArgs, self._on_best),
            "predict": (PredictArgs, self._on_predict),
            "appraise": (AppraiseArgs, self._on_appraise),
            "parameters": (ParametersArgs, self._on_parameters),
            "restore": (RestoreArgs, self._on_restore),
            "end": (NoArgs, self._on_end),
        }

    def close(self) -> None:
        """Write the frames that are not on the disk yet, and let go of the image servers."""
        self._sessions.end_all()

    def _open(
        self,
        args: StartArgs,
        recorded: Mapping[str, FrameTable] | None = None,
        seed_pose: PoseMessage | None = None,
    ) -> Session:
        self._sessions.make_room(self.caller, args.out)
        client = None
        if args.image_server is not None:
            client = Client(args.image_server, CAPTURE_S, RETRIES, self._curve)
        try:
            describe = GIVEN_FRAMES if client is None else _described(client)
            if describe.target is not None and seed_pose is not None:  # a target that moved has none
                target = msgspec.structs.replace(describe.target, seed_pose=seed_pose)
                describe = msgspec.structs.replace(describe, target=target)
            describe = given_values(args, describe)
            self._files.check(args, describe)
            session = Session(open_task(args, describe, recorded), client)
        except BaseException:
            if client is not None:
                client.close()
            raise
        self._sessions.begin(self.caller, session)
        return session

    def _on_start(self, args: StartArgs) -> Reply:
        if args.out is not None:
            self._files.check_new(Path(args.out) / FOLDER)
        return _started(self._open(args).task)

    def _on_restore(self, args: RestoreArgs) -> Reply:
        self._files.check_place(args.out)
        self._sessions.make_room(self.caller, args.out)  # what it has to write is on the disk now
        out = Path(args.out)
        frames = recorded_frames(out / FOLDER)
        missing = [image for image in args.images if image not in frames]
        if missing:
            raise BadInput(
                f"{out / FOLDER} has no image {missing[0]}.", f"It has {', '.join(frames) or 'none'}."
            )
        known = {*args.images, *args.discarded}
        kept = {name: frame for name, frame in frames.items() if name in known}
        task = self._open(args, kept, recorded_seed_pose(out / FOLDER)).task
        for step in args.told:
            if step.estimate is not None:
                task.note(restored_estimate(step.estimate))
            task.set_parameters(step.parameters)
            if step.predicted:
                task.expect(task.best)
            if step.discarded is not None and step.discarded in kept and task.foresees:
                task.applied[step.discarded] = frames[step.discarded].settings()
            if step.happened is not None:
                from vision_server.serve import surprises  # late: few sessions need it

                surprises.restore(task, step.happened, list(kept))
        task.doubted = args.doubted
        remembered = set(task.applied)  # a new set has forgotten those before it
        task.applied.clear()
        for image in kept:
            if image in args.images or image in remembered:
                task.add(image, read_pixels(out / FOLDER / f"{image}.png"), frames[image].settings())
            if image in remembered:
                task.discard(image)
        task.retired |= set(args.discarded)
        return _started(task)

    def _on_capture(self, args: VisionCaptureArgs) -> Reply:
        with self._sessions.of(self.caller) as session:
            client = session.client
            if client is None:
                raise BadInput("This session has no image server.", "Give its frames: add.")
            session.task.check_name(args.image)
            began = time.perf_counter()
            asked = {"settings": msgspec.to_builtins(args.settings), "number": args.number}
            result, arrays = client.request("capture", asked, capture_deadline_s(args.settings))
            seconds = time.perf_counter() - began
            header = _checked(result, ImageCaptureResult, client.endpoint)
            pixels = received_frame(header, arrays, client.endpoint)
            events = [told.event for told in header.events]
            answer = taken(session.task, args.image, header.applied, pixels, header.verified, seconds, events)
            return Reply({**answer, "events": header.events})

    def _on_add(self, args: AddArgs) -> Reply:
        pixels = self._given_frame()
        with self._sessions.of(self.caller) as session:
            session.task.check_name(args.image)
            return Reply(taken(session.task, args.image, args.settings, pixels, True, 0.0))

    def _given_frame(self) -> FramePixels:
        if not is_frame(self.arrays):
            raise BadInput("An image is one array, uint8 or uint16 of shape (H, W).", "Convert it to grey.")
        return np.asarray(self.arrays[0].copy())  # the message goes

    def _on_track(self, args: TrackArgs) -> Reply:
        from vision_server.serve.tracking import tracked

        pixels = self._given_frame()
        with self._sessions.of(self.caller) as session:
            return Reply(tracked(session.task, pixels, args.time_s))

    def _on_check(self, args: CheckArgs) -> Reply:
        from vision_server.serve.witnesses import checked

        with self._sessions.of(self.caller) as session:
            return Reply(checked(session.task, args))

    def _on_estimate(self, args: EstimateArgs) -> Reply:
        with self._sessions.of(self.caller) as session:
            found = session.task.estimate(args.images)
            several = len(set(args.images)) > 1  # one image alone is never believed
            return Reply({**estimate_result(found), "model_wrong": model_wrong(found) if several else None})

    def _on_discard(self, args: DiscardArgs) -> Reply:
        with self._sessions.of(self.caller) as session:
            session.task.discard(args.image)
            return Reply({"image": args.image, "images": list(session.task.images.images)})

    def _on_best(self, _: NoArgs) -> Reply:
        with self._sessions.of(self.caller) as session:
            return Reply({**estimate_result(session.task.best or Estimate()), "seconds": {}})

    def _on_predict(self, args: PredictArgs) -> Reply:
        from vision_server.serve.prediction import predict  # only strategies that ask pay for it

        with self._sessions.of(self.caller) as session:
            return Reply(msgspec.to_builtins(predict(session.task, args)))

    def _on_appraise(self, args: AppraiseArgs) -> Reply:
        from vision_server.baselines.exposures import richest_gamma

        with self._sessions.of(self.caller) as session:
            images = session.task.images
            images.check([args.image])
            return Reply({"gamma": richest_gamma(images.images[args.image].pixels)})

    def _on_parameters(self, values: dict[str, Any]) -> Reply:
        with self._sessions.of(self.caller) as session:
            return Reply(session.task.set_parameters(values))

    def _on_end(self, _: NoArgs) -> Reply:
        self._sessions.end(self.caller, "")
        return Reply({})


def _described(client: Client) -> Describe:
    described: Describe = _checked(client.request("describe")[0], Describe, client.endpoint)
    return described


def _started(task: PoseTask) -> Reply:
    model, camera = task.model, task.camera
    seed_pose = task.seed_pose if isinstance(task.seed_pose, Pose) else None
    doubts = (
        model_warning(model, camera, seed_pose),
        camera_doubt(camera, task.describe.camera),
        lights_doubt(task.describe.lights, seed_pose),
    )
    told = ModelTold(
        name=model.name,
        lines=len(model.lines),
        faces=len(model.faces),
        diameter_m=model.diameter,
        picture_px=None if seed_pose is None else picture_px(model, camera, seed_pose),
        doubt=" ".join(doubt for doubt in doubts if doubt) or None,
    )
    return Reply(StartResult(model=told, describe=task.describe))


def _checked(result: dict[str, Any], kind: Any, endpoint: str) -> Any:
    try:
        return received(result, kind)
    except (msgspec.ValidationError, ValueError) as error:
        raise DeviceError(
            f"The image server at {endpoint} sent a malformed {kind.__name__}: {error}.",
            "Is it an image server of this version?",
        ) from error
