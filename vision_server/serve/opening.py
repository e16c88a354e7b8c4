"""How a session's task is opened: by what `start` gives, and what the image server describes besides."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import msgspec

from bridge.errors import BadInput
from bridge.messages import CameraDescription, Describe, TargetDescription, Unit
from bridge.start_messages import StartArgs
from geometry.camera import Camera
from geometry.errors import GeometryError
from geometry.model import Model
from geometry.pose import Pose, search_translation_px
from stack.format import FrameTable
from stack.tables import as_table
from vision_server.matching.match import Anywhere
from vision_server.pipeline import PipelineSettings
from vision_server.serve.described import used_camera
from vision_server.serve.inputs import (
    GivenCamera,
    checked_pose,
    checked_tolerance,
    read_camera_file,
    read_model,
    read_seed_pose,
    told_anywhere,
    told_raw,
    untold_tolerance_m,
)
from vision_server.serve.recorder import Recorder
from vision_server.serve.task import PoseTask

GIVEN_FRAMES = Describe(device="given frames", lights=(), shutters_s=(1 / 60,), apertures=(4.0,))
"""Where frames are given and no image server is asked: exposures are relative to 1/60 s at f/4."""


def given_values(args: StartArgs, describe: Describe) -> Describe:
    """What is described, with the camera and seed pose that `start` gives as values.

    Raises
    ------
    BadInput
        A value beside the file that says the same.
    """
    for name in ("camera", "seed_pose"):
        if getattr(args, name) is not None and getattr(args, f"{name}_file") is not None:
            raise BadInput(f"Both {name} and {name}_file are given.", "Give one of them.")
    if args.camera is not None:
        describe = msgspec.structs.replace(describe, camera=args.camera)
    if args.seed_pose is not None:
        model, unit = _model_file(args, describe)
        tolerance_m = None if describe.target is None else describe.target.tolerance_m
        target = TargetDescription(
            model=str(model), unit=unit, seed_pose=args.seed_pose, tolerance_m=tolerance_m
        )
        describe = msgspec.structs.replace(describe, target=target)
    if args.first_sight and describe.target is not None:
        if args.seed_pose is not None or args.seed_pose_file is not None:
            raise BadInput("Both first_sight and a seed pose are given.", "Give one of them.")
        target = msgspec.structs.replace(describe.target, seed_pose=None)
        describe = msgspec.structs.replace(describe, target=target)
    return describe


def open_task(
    args: StartArgs, describe: Describe, recorded: Mapping[str, FrameTable] | None = None
) -> PoseTask:
    """The task that `start` asks for; what it leaves out comes from the image server's `describe`.

    ``recorded`` are, by image, the frames that an earlier session has saved in the same folder.

    Raises
    ------
    BadInput
        A missing or unusable model, camera, seed pose or folder.
    """
    model_file, unit = _model_file(args, describe)
    model = read_model(model_file, unit)
    given = None if args.camera_file is None else read_camera_file(Path(args.camera_file))
    whose = "The image server's camera" if args.camera is None else "Argument camera"
    used = used_camera(given, describe.camera, whose)
    camera, table = used.camera, used.table
    gain, gamma = (float(table.get(key, getattr(describe.camera, key, 1.0))) for key in ("gain", "gamma"))
    anywhere = _anywhere(given, describe, model, camera)
    seed_pose = _seed_pose(args, describe, model)
    reach_px = search_translation_px(camera.width)
    told_m = _tolerance(given, describe, model)
    settings = PipelineSettings(
        matcher=args.matcher,
        seed=args.seed,
        translation_range_px=reach_px,
        tolerance_m=told_m or 0.0,
        untold_tolerance_m=untold_tolerance_m(told_m, model),
    )
    task = PoseTask(describe, model, camera, gain, gamma, seed_pose or anywhere, settings, anywhere)
    task.raw = told_raw(table, 16)
    task.edge_radius_m = None if given is None else given.edge_radius_m(model)
    if args.out is not None:
        source = Path(args.camera_file or "describe")
        shown = _recorded(describe, task, table, model_file, unit, source)
        task.recorder = Recorder(Path(args.out), shown, dict(recorded or {}))
    return task


def _recorded(
    describe: Describe, task: PoseTask, table: Mapping[str, Any], model: Path, unit: str, source: Path
) -> Describe:
    """What a recording says of the equipment: as described, with camera, target and seed pose in use."""
    camera = task.camera.to_dict() | {"gain": task.gain, "gamma": task.gamma}
    camera |= {key: table[key] for key in ("read_noise_e", "full_well_e", "bits", "bayer") if key in table}
    target = {"model": str(model), "unit": unit, **asdict(task.anywhere)}
    if task.settings.untold_tolerance_m == 0.0:  # it was told, if only to be none
        target["tolerance_m"] = task.settings.tolerance_m
    if isinstance(task.seed_pose, Pose):
        target["seed_pose"] = task.seed_pose.to_dict()
    return msgspec.structs.replace(
        describe,
        camera=as_table(camera, CameraDescription, source),
        target=as_table(target, TargetDescription, source),
    )


def _model_file(args: StartArgs, describe: Describe) -> tuple[Path, Unit]:
    if args.model is not None:
        return Path(args.model), args.unit or "m"
    if describe.target is None:
        if args.image_server is None:
            raise BadInput("No model is given, and no image server that knows its target.", "Give model.")
        raise BadInput("The image server does not know its target.", "Give a model file (--target FILE).")
    return Path(describe.target.model), args.unit or describe.target.unit


def _seed_pose(args: StartArgs, describe: Describe, model: Model) -> Pose | None:
    """Where the target is said to be; None where nothing is said, and it is looked for everywhere."""
    if args.seed_pose_file is not None:
        return read_seed_pose(Path(args.seed_pose_file), model)
    known = None if describe.target is None else describe.target.seed_pose
    if known is None:
        return None
    try:
        return checked_pose(Pose.of(known), model)
    except GeometryError as error:
        whose = "The image server's seed pose" if args.seed_pose is None else "Argument seed_pose"
        raise BadInput(f"{whose}: {error}.") from error


def _anywhere(given: GivenCamera | None, describe: Describe, model: Model, camera: Camera) -> Anywhere:
    """What narrows the search without a seed pose: the camera file's [target], or what is described."""
    told = Anywhere() if given is None else given.anywhere(model)
    if told != Anywhere() or describe.target is None:
        return told
    return told_anywhere(describe.target, model, camera, "The image server's target")


def _tolerance(given: GivenCamera | None, describe: Describe, model: Model) -> float | None:
    """How far lines of the part may be off, m, as camera file or image server tell; None if none does."""
    told = None if given is None else given.tolerance_m(model)
    if told is None and describe.target is not None and describe.target.tolerance_m is not None:
        return checked_tolerance(describe.target.tolerance_m, model, "The image server's target: ")
    return told
