"""Whether a run folder's pose is what its images show: inputs by their hashes, the estimate made again."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from bridge.errors import BadInput
from bridge.messages import PoseMessage
from bridge.result_file import EstimatedWith, Result, StepRecord, read_result
from bridge.start_messages import StartArgs
from geometry.model import about_middle
from geometry.pose import Pose
from stack.format import STACK_FILE
from stack.read import FramesStack, describe_stack, load_stack
from stack.write import file_sha256
from vision_server.pipeline import MERIT_PX
from vision_server.serve.opening import open_task
from vision_server.serve.recorder import FOLDER
from vision_server.serve.results import estimate_result
from vision_server.serve.task import PoseTask
from vision_server.trust.judgement import Estimate

SAME_SIGMAS = 0.01  # poses no more stated standard deviations apart are the same; chosen by hand
SAME = 1e-3  # of other numbers, relative: another processor's arithmetic may differ; chosen by hand
NUMBERS = ("score", "rms_px", "uncertainty", "supported_fraction", "ambiguity")


@dataclass(frozen=True)
class Verified:
    """What came of it.

    Attributes
    ----------
    images : those that the stated pose is from.
    differences : of inputs and numbers, in words; none where all is as stated.
    to_middle : model_T_middle, of the place that the part is turned about: how far poses are apart there.
    """

    images: tuple[str, ...]
    differences: tuple[str, ...]
    estimate: Estimate
    to_middle: Pose

    @property
    def as_stated(self) -> bool:
        """Whether inputs and numbers are as the folder states."""
        return not self.differences


def verified(folder: Path) -> Verified:
    """Make the estimate of a session again, from nothing but its run folder.

    Raises
    ------
    BadInput
        No run folder of a session that has ended, one without a pose, or one that does not say what its
        pose was made with: of a session that was stopped, of an earlier version, or of an approach.
    """
    stated = read_result(folder)
    if stated.pose is None:
        raise BadInput(f"{folder} states no pose.", "There is nothing to verify.")
    if stated.holds is not None:
        raise BadInput(
            f"{folder} is an approach: its last pose has no seed pose on record.", "Verify single sessions."
        )
    if stated.estimated_with is None and stated.status == "stopped":
        raise BadInput(
            f"{folder} is of a session that was stopped before its end: what its pose was estimated with"
            " is not on record.",
            f"Let it come to its end first: swipl main.pl --resume {folder}",
        )
    if stated.estimated_with is None:
        raise BadInput(
            f"{folder}/result.json does not say what its pose was estimated with.",
            "It is of an earlier version; run the session again.",
        )
    stack = load_stack(folder / FOLDER)
    if not isinstance(stack, FramesStack):
        raise BadInput(f"{folder / FOLDER} holds no frames of a session.")
    changed = _changed_inputs(folder / FOLDER, stack, stated.estimated_with)
    names = images_of(stated.pose, stated.steps)
    try:
        task = _task(stack, stated.estimated_with, names)
        estimate = task.estimate(names)
    except BadInput as error:  # which speaks as to a session, of parameters and an image server
        raise BadInput(f"{folder} cannot be estimated again: {error.message}", error.hint) from None
    differences = (*changed, *_differences(stated, estimate))
    return Verified(names, differences, estimate, about_middle(task.model)[1])


def images_of(pose: PoseMessage, steps: list[StepRecord]) -> tuple[str, ...]:
    """The images that a stated pose was estimated from.

    Raises
    ------
    BadInput
        No step has this pose.
    """
    kept: list[str] = []
    found: tuple[str, ...] | None = None
    for step in steps:
        image, size = step.image or "", step.set_size or 0
        if step.pose == pose:
            others = size - 1 if step.decision == "keep" else size
            found = (*kept[len(kept) - others :], image)
        if step.decision == "keep":
            kept.append(image)
    if found is None:
        raise BadInput("result.json: no step has the stated pose.", "Was the file changed by hand?")
    return found


def _changed_inputs(folder: Path, stack: FramesStack, told: EstimatedWith) -> list[str]:
    hashes = [(folder / STACK_FILE, told.stack_sha256)]
    hashes.append((folder / stack.table.target.model, stack.table.target.sha256))
    hashes += [(folder / frame.image, frame.sha256) for frame in stack.table.frames]
    return [
        f"{file} {'has no SHA-256 on record' if told is None else 'is not the file that it was'}"
        for file, told in hashes
        if told is None or file_sha256(file) != told
    ]


def _task(stack: FramesStack, told: EstimatedWith, names: tuple[str, ...]) -> PoseTask:
    task = open_task(StartArgs(), describe_stack(stack, "run folder"))
    task.set_parameters(told.parameters)
    frames = {
        Path(frame.image).stem: (frame, pixels)
        for frame, pixels in zip(stack.table.frames, stack.images, strict=True)
    }
    for name in names:
        if name not in frames:
            raise BadInput(f"{stack.folder / STACK_FILE} lists no image {name}.", "Was it changed by hand?")
        frame, pixels = frames[name]
        task.add(name, pixels, frame.settings())
    return task


def _differences(stated: Result, found: Estimate) -> list[str]:
    """How the estimate differs from what is stated, in words."""
    assert stated.pose is not None
    if found.pose is None or found.covariance is None or stated.covariance is None:
        return ["the images show no pose"]
    out = []
    pose = Pose.of(stated.pose)
    apart = pose.error_to(found.pose)
    sigmas = np.sqrt(np.maximum(np.diag(np.array(stated.covariance)), 0.0))
    if (
        math.radians(apart.rotation_deg) > SAME_SIGMAS * sigmas[:3].max()
        or apart.translation_m > SAME_SIGMAS * sigmas[3:].max()
    ):
        out.append(
            f"the pose is {apart.rotation_deg:.4f} degrees and {1e3 * apart.translation_m:.4f} mm"
            " from the stated one"
        )
    if not _same_matrix(np.array(stated.covariance), found.covariance):
        out.append("the covariance is another than stated")
    told = estimate_result(found)
    for name in NUMBERS:
        said, value = getattr(stated, name), told[name]
        if said is None or value is None or not math.isclose(said, value, rel_tol=SAME, abs_tol=SAME):
            out.append(f"{name} is {value}, stated is {said}")
    others = {"poses": msgspec.to_builtins(stated.poses), "free": stated.free}
    if any(others.values()):  # of a session without a seed pose, mostly
        differ = [name for name, said in others.items() if not _alike(said or [], told.get(name, []))]
        out += [f"{name} are others than stated" for name in differ]
    if stated.merit_px is not None and stated.score is not None:
        merit_px = MERIT_PX * (1.0 - stated.score)
        if not math.isclose(stated.merit_px, merit_px, rel_tol=SAME, abs_tol=SAME):
            out.append(f"merit_px is {merit_px:g} by the stated score, stated is {stated.merit_px:g}")
    return out


def _alike(one: Any, other: Any) -> bool:
    """Whether two JSON values are the same but for the last places of their numbers."""
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(_alike(one[key], other[key]) for key in one)
    if isinstance(one, list | tuple) and isinstance(other, list | tuple):
        return len(one) == len(other) and all(map(_alike, one, other))
    return bool(one == other or math.isclose(one, other, rel_tol=SAME, abs_tol=SAME))


def _same_matrix(one: Any, other: Any) -> bool:
    """Whether no entry differs by more than its share of the standard deviations it belongs to."""
    scale = np.sqrt(np.maximum(np.outer(np.diag(one), np.diag(one)), 0.0))  # stated ones may be anything
    return bool(one.shape == other.shape and np.all(np.abs(one - other) <= SAME * scale))
