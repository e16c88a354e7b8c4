"""What choosing images could be worth at most: oracles that see the true pose, beside prediction and chance.

    .venv/bin/python -m benchmarks.oracles [SCENE...] [--seed 1] [--images 4] [--choices 8]

In each round the same settings are on offer, drawn at random from those of `benchmarks.surprises`, which also
names the scenes. `next` takes the image with which the set's pose errs least, `single` one image alone, the
best of all on offer, `foreseen` what is predicted to add most (the least exposed as first image, the first
on offer while there is no pose), `random` the first. All keep every image. One JSON object a scene and rule:
images until the pose is right (1 degree, 1 % of the range) and tight (a fifth of it), null for never, and the
last error, as a share of what is right.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import msgspec
import numpy as np
import typer

from benchmarks.planted_faults import opened, true_pose
from benchmarks.surprises import SCENES, candidates
from bridge.messages import Settings
from bridge.start_messages import StartArgs
from bridge.vision_messages import PredictArgs
from geometry.pose import RIGHT, Pose
from image_server.serve.device import Device
from vision_server.serve.opening import open_task
from vision_server.serve.prediction import predict
from vision_server.serve.task import PoseTask

RULES = ("next", "single", "foreseen", "random")
RIGHT_DEG, RIGHT_SHARE = RIGHT
TIGHT = 0.2  # of what is right


class Trial:
    """A set of images of one scene, and how far off its pose is."""

    def __init__(self, scene: str, seed: int) -> None:
        self.device: Device = opened(scene, seed)[0]
        self.task: PoseTask = open_task(msgspec.convert({"seed": seed}, StartArgs), self.device.describe())
        self.true: Pose = true_pose(scene, self.device)
        self._taken = 0

    def take(self, settings: Settings) -> str:
        """An image under these settings, which joins the set; its name."""
        self._taken += 1
        self.device.come_to(self._taken)
        frame = self.device.capture(settings)
        name = f"i{self._taken}"
        self.task.add(name, frame.pixels, frame.applied)
        return name

    def error(self, names: tuple[str, ...]) -> float:
        """Of the pose from these images, as a share of what is right; infinite without one."""
        pose = self.task.estimate(names).pose
        if pose is None:
            return float("inf")
        off = pose.error_to(self.true)
        return max(off.rotation_deg / RIGHT_DEG, off.translation_fraction_of_range / RIGHT_SHARE)

    def best(self, offered: list[Settings], joined: tuple[str, ...]) -> Settings:
        """Of what is on offer that with which these images' pose errs least; what was tried is forgotten."""
        errors = []
        for settings in offered:
            name = self.take(settings)
            errors.append(self.error((*joined, name)))
            self.task.discard(name)
        return offered[int(np.argmin(errors))]


def chosen(trial: Trial, rule: str, offered: list[Settings]) -> Settings:
    """What a rule takes of the settings on offer."""
    kept = tuple(trial.task.applied)
    if rule == "next":
        return trial.best(offered, kept)
    if rule == "foreseen" and kept:
        gains = predict(trial.task, PredictArgs(settings=tuple(offered))).gains
        if gains is not None:
            return offered[int(np.argmax([gain.bits for gain in gains]))]
    if rule == "foreseen" and not kept:
        return min(offered, key=trial.task.exposure)
    return offered[0]


def play(scene: str, seed: int, rule: str, offers: list[list[Settings]]) -> list[float]:
    """The error after each image."""
    trial = Trial(scene, seed)
    if rule == "single":
        name = trial.take(trial.best([one for offered in offers for one in offered], ()))
        return [trial.error((name,))]
    errors = []
    for offered in offers:
        trial.take(chosen(trial, rule, offered))
        errors.append(trial.error(tuple(trial.task.applied)))
    return errors


def main(
    scenes: Annotated[list[str] | None, typer.Argument(metavar="SCENE...")] = None,
    seed: Annotated[int, typer.Option(min=0)] = 1,
    images: Annotated[int, typer.Option(min=1)] = 4,
    choices: Annotated[int, typer.Option(min=1)] = 8,
) -> None:
    """Let oracles, prediction and chance choose images."""
    for scene in scenes or SCENES:
        rng = np.random.default_rng(seed)
        asked = candidates(opened(scene, seed)[0].describe())
        offers = [[asked[row] for row in rng.choice(len(asked), choices)] for _ in range(images)]
        for rule in RULES:
            errors = play(scene, seed, rule, offers)
            until = {
                word: next((n for n, error in enumerate(errors, 1) if error <= bound), None)
                for word, bound in (("right", 1.0), ("tight", TIGHT))
            }
            last = None if np.isinf(errors[-1]) else round(errors[-1], 3)
            row = {"name": "oracle", "scene": Path(scene).name, "rule": rule, **until, "error": last}
            print(json.dumps(row), flush=True)


if __name__ == "__main__":
    typer.run(main)
