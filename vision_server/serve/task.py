"""What the vision server does for one session: inputs, image set and estimates."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from bridge.errors import BadInput
from bridge.messages import CameraDescription, Describe, Settings, TargetDescription, Unit
from bridge.start_messages import StartArgs
from geometry.camera import Camera
from geometry.errors import GeometryError
from geometry.model import Model
from geometry.pose import Pose
from stack.exposure import relative_exposure
from stack.format import FrameTable
from stack.tables import as_table
from vision_server.edges.edge_map import EdgeMap
from vision_server.image_set import Grey, ImageSet
from vision_server.pipeline import Estimate, PipelineSettings, estimate_pose
from vision_server.prediction.response import LitImage
from vision_server.serve import parameters
from vision_server.serve.inputs import checked_pose, read_camera, read_model, read_seed_pose
from vision_server.serve.recorder import Recorder
from vision_server.serve.statistics import frame_statistics, target_region

if TYPE_CHECKING:
    from vision_server.tracking.tracker import Tracker


@dataclass(eq=False)
class PoseTask:
    """What the operations of the server work on.

    Attributes
    ----------
    images
        The set, and with it what was computed for each image.
    retired
        Names of images of earlier sets, which went when the scene's geometry changed; they stay taken.
    best
        The estimate with the best score of the present set so far.
    applied
        What each image of the set was taken under.
    lit
        Images as readings of brightness, of those that something was predicted from.
    tracker
        What follows the target since its first frame, where a client has it followed.
    expected
        Where the target was taken to be when something was predicted last; None where that was unsure.
    """

    describe: Describe
    model: Model
    camera: Camera
    gain: float
    gamma: float
    seed_pose: Pose
    settings: PipelineSettings
    recorder: Recorder | None = None
    images: ImageSet = field(init=False)
    retired: set[str] = field(default_factory=set)
    best: Estimate | None = None
    applied: dict[str, Settings] = field(default_factory=dict)
    lit: dict[str, LitImage] = field(default_factory=dict)
    tracker: Tracker | None = None
    expected: Pose | None = None
    _known: dict[tuple[str, ...], Estimate] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.images = ImageSet(self.camera.width, self.camera.height)

    def exposure(self, settings: Settings) -> float:
        """Exposure relative to the reference of `describe`, sensor gain included."""
        return self.gain * relative_exposure(settings.shutter_s, settings.aperture, self.describe.reference)

    def check_name(self, image: str) -> None:
        """Raise BadInput when an image's name is taken."""
        if image in self.images.images or image in self.retired:
            raise BadInput(
                f"The name {image} is taken by another image.", "Give each image a name of its own."
            )

    def add(self, image: str, pixels: Grey, applied: Settings) -> dict[str, Any]:
        """Add a frame to the set; its statistics."""
        self.images.add(image, pixels, self.exposure(applied), self.gamma)
        self.applied[image] = applied
        pose = self.seed_pose if self.best is None or self.best.pose is None else self.best.pose
        region = target_region(self.model, self.camera, pose)
        return frame_statistics(pixels, self.images.images[image].statistics, region, self.gamma)

    def discard(self, image: str) -> None:
        """Forget an image of the set; its name stays taken."""
        if image not in self.retired:
            self.images.remove(image)
            del self.applied[image]
            self.lit.pop(image, None)
            self.retired.add(image)

    def estimate(self, names: Sequence[str]) -> Estimate:
        """Pose from the named images; the same question is answered once."""
        key = tuple(dict.fromkeys(names))
        self.images.check(key)
        if key not in self._known:
            try:
                images, named = self._fused(key) if self.settings.fusion else (self.images, key)
                found = estimate_pose(
                    images, named, self.model, self.camera, self.seed_pose, self.settings,
                    lambda edges: self._show(key[-1], edges),
                )  # fmt: skip
            except GeometryError as error:
                raise BadInput(str(error)) from error
            self._known[key] = found
        estimate = self._known[key]
        self.note(estimate)
        return estimate

    def _fused(self, names: tuple[str, ...]) -> tuple[ImageSet, tuple[str, ...]]:
        """A set of one image, fused from the named ones, under the last one's name."""
        from vision_server.rivals.exposures import exposure_fusion  # only for comparison

        one = ImageSet(self.camera.width, self.camera.height)
        pixels = exposure_fusion([self.images.images[name].pixels for name in names])
        one.add(names[-1], pixels, 1.0, 1.0)
        return one, names[-1:]

    def _show(self, image: str, edges: EdgeMap) -> None:
        if self.recorder is not None:
            self.recorder.draw(image, edges)

    def note(self, estimate: Estimate) -> None:
        """Make an estimate the best one if it is."""
        if estimate.pose is not None and (self.best is None or estimate.score > self.best.score):
            self.best = estimate

    def estimate_of(self, names: Sequence[str]) -> Estimate | None:
        """The best estimate with a pose from some of the named images; None where none has one."""
        of_these = [found for key, found in self._known.items() if set(key) <= set(names)]
        known = [found for found in of_these if found.pose is not None]
        return max(known, key=lambda found: found.score, default=None if of_these else self.best)

    def set_parameters(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Set parameters by name, all or none; all of them afterwards."""
        values = dict(values)
        wanted = values.pop(parameters.SEED_POSE, None)
        settings = parameters.changed(self.settings, values)
        if wanted is not None:
            best = None if self.best is None else self.best.pose
            pose = parameters.new_seed_pose(wanted, best, self.seed_pose, self.model)
            if isinstance(wanted, Mapping) and "best_at_range_m" in wanted:
                self._new_set()
            self.seed_pose = pose
            self._known.clear()
        if settings != self.settings:
            self.settings = settings
            self._known.clear()
        return {**parameters.as_dict(self.settings), parameters.SEED_POSE: self.seed_pose.to_dict()}

    def _new_set(self) -> None:
        """The target has moved: what was seen before says nothing about where it is now."""
        self.retired |= set(self.images.images)
        self.images = ImageSet(self.camera.width, self.camera.height)
        self.applied.clear()
        self.lit.clear()
        self.expected = None
        self.best = None


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
        target = TargetDescription(model=str(model), unit=unit, seed_pose=args.seed_pose)
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
    if args.camera_file is not None:
        camera, table = read_camera(Path(args.camera_file))
    elif describe.camera is not None:
        table = msgspec.to_builtins(describe.camera)
        camera = Camera.from_dict(table)
    else:
        raise BadInput(
            "The image server does not know its camera.", "Give a camera file (--camera-model TOML)."
        )
    gain, gamma = (_positive(table, key, describe) for key in ("gain", "gamma"))
    seed_pose = _seed_pose(args, describe, model)
    task = PoseTask(
        describe,
        model,
        camera,
        gain,
        gamma,
        seed_pose,
        PipelineSettings(matcher=args.matcher, seed=args.seed),
    )
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
    camera |= {key: table[key] for key in ("read_noise_e", "full_well_e") if key in table}
    target = {"model": str(model), "unit": unit, "seed_pose": task.seed_pose.to_dict()}
    return msgspec.structs.replace(
        describe,
        camera=as_table(camera, CameraDescription, source),
        target=as_table(target, TargetDescription, source),
    )


def _model_file(args: StartArgs, describe: Describe) -> tuple[Path, Unit]:
    if args.model is not None:
        return Path(args.model), args.unit or "m"
    if describe.target is None:
        raise BadInput("The image server does not know its target.", "Give a model file (--target FILE).")
    return Path(describe.target.model), args.unit or describe.target.unit


def _seed_pose(args: StartArgs, describe: Describe, model: Model) -> Pose:
    if args.seed_pose_file is not None:
        return read_seed_pose(Path(args.seed_pose_file), model)
    known = None if describe.target is None else describe.target.seed_pose
    if known is None:
        raise BadInput("The image server knows no seed pose.", "Give a seed pose file (--seed-pose TOML).")
    try:
        return checked_pose(Pose(np.array(known.rotation_vector), np.array(known.translation)), model)
    except GeometryError as error:
        raise BadInput(f"The image server's seed pose: {error}.") from error


def _positive(table: Mapping[str, Any], key: str, describe: Describe) -> float:
    value = table.get(key)
    if value is None:
        value = 1.0 if describe.camera is None else getattr(describe.camera, key)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0.0 < value < math.inf:
        raise BadInput(f"[camera] {key} must be a positive number, not {value!r}.")
    return float(value)
