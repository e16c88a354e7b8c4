"""Faults planted in mid-session: what is named rightly, and what is said where nothing has happened.

    .venv/bin/python -m benchmarks.surprises [SCENE...] [--seeds 3] [--images 5]

A scene is a stack folder (kind basis) or a scenario of the simulator (target: cube). Images are chosen as
`informed` does. From the second on, each is also taken with a light dead, with two lights swapped, under
another sun, of a target that has moved by 1 % of the range (the picture turned), and behind an arm that is
drawn in front; where the vision server is in doubt, test images follow as `informed` takes them. Whole
sessions are `benchmarks.faulty_sessions`. One JSON object a kind of fault: images, of how many
something was foreseen (from a pose that is rather right), after how many what is said at last is `right`,
something else (`wrong`), or no more than a doubt (`doubted`), and the test images taken. Of "nothing",
whatever is said is wrong. `visible` are the faults that change the brightness by a tenth, in the median over
the target; `visible_right` those of them that are named.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from collections.abc import Sequence
from functools import lru_cache
from typing import Annotated

import msgspec
import numpy as np
import typer

from benchmarks.planted_faults import (
    KINDS,
    Fault,
    camera_and_region,
    drawn,
    opened,
    pictured,
    relit,
    true_pose,
)
from bridge.door import Prolog
from bridge.messages import Describe, Settings
from bridge.start_messages import CauseTold, StartArgs
from bridge.vision_messages import PredictArgs
from numerics.arrays import Grey
from vision_server.serve.opening import open_task
from vision_server.serve.prediction import predict
from vision_server.serve.statistics import frame_statistics, target_region
from vision_server.serve.surprises import Surprise, surprise_of
from vision_server.serve.task import PoseTask

SCENES = ("nominal", "eclipse", "harsh", "textured", "grazing", "blur")
IN_MID_SESSION = [kind for kind in KINDS if kind != "model_wrong"]
MOST_ASKED = 4096  # as `predict` takes
FIRST_FAULT = 2  # image: of the first nothing is foreseen
MOST_TESTS = 4  # images, as `doubted` has it in domain/procedures.pl
LEAST_CHANGE, DARK = 0.1, 8  # share of the brighter picture, where that is brighter than so many grey
COUNTED = "images", "foreseen", "right", "wrong", "doubted", "tests", "visible", "visible_right"


def candidates(describe: Describe) -> tuple[Settings, ...]:
    """What a session asks about: every representative of a qualitative state."""
    lights = ", ".join(f"light('{light.name}', {light.levels})" for light in describe.lights)
    shutters, apertures = (list(map(float, steps)) for steps in (describe.shutters_s, describe.apertures))
    device = f"device([{lights}], {shutters}, {apertures}, none, none, 0.001)"
    return tuple(
        Settings(lights=tuple(found["L"]), shutter_s=found["T"], aperture=found["A"])
        for found in prolog().ask(f"candidate({device}, settings(L, T, A))", MOST_ASKED)
    )


def first_settings(describe: Describe) -> Settings:
    """What `informed` begins with on a camera like the paper's: full light, short and small."""
    levels = tuple(light.levels - 1 for light in describe.lights)
    return Settings(lights=levels, shutter_s=min(describe.shutters_s), aperture=max(describe.apertures))


def taken(scene: str, seed: int, number: int, settings: Settings, fault: Fault) -> Grey:
    """The frame after a fault."""
    device, _ = opened(scene, seed, fault.sun)
    device.come_to(number)
    describe = device.describe()
    frame = np.asarray(device.capture(relit(settings, fault, describe.lights)).pixels, dtype=np.uint8)
    return pictured(frame, *camera_and_region(describe, true_pose(scene, device)), fault, number)


@lru_cache(1)
def prolog() -> Prolog:
    """The rules by which `informed` chooses images and test images."""
    door = Prolog()
    for rules in ("candidates", "surprises"):
        door.use_module(f"domain/reasoning/{rules}.pl")
    return door


def telling(
    task: PoseTask, newest_first: Sequence[str], doubt: CauseTold, asked: list[Settings]
) -> Settings | None:
    """Settings of the test image for a doubt after images, as `telling_settings` has them."""
    describe, taken = task.describe, [task.applied[image] for image in newest_first]
    lights = ", ".join(f"light({light.name}, {light.levels})" for light in describe.lights)
    device = f"device([{lights}], [], [], none, none, 0.001)"
    cause = doubt.cause + (f"({', '.join(doubt.lights)})" if doubt.lights else "")
    tested = ", ".join(map(_term, asked[::-1]))
    seen = [_seen(task, image) for image in newest_first]
    readings = ", ".join(
        f"reading({_term(settings)}, {shown})" for settings, shown in zip(taken, seen, strict=True)
    )
    goal = f"telling_settings({device}, [{readings}], {cause}, [{tested}], settings(L, T, A))"
    answers = prolog().ask(goal)
    if not answers:
        return None
    found = answers[0]
    return msgspec.structs.replace(
        taken[0], lights=tuple(found["L"]), shutter_s=found["T"], aperture=found["A"]
    )


def _term(settings: Settings) -> str:
    return f"settings({list(settings.lights)}, {float(settings.shutter_s)}, {float(settings.aperture)})"


def _seen(task: PoseTask, image: str) -> str:
    """What an image shows of the target, as the vision server tells the controller."""
    assert task.expected is not None
    region = target_region(task.model, task.camera, task.expected)
    told = frame_statistics(task.images.images[image].statistics, region, task.gamma)
    numbers = (told[name] for name in ("p50", "p95", "dark_fraction", "saturated_fraction"))
    return f"statistics({', '.join(f'{number:.6f}' for number in numbers)}, none)"


def said(
    task: PoseTask, scene: str, seed: int, settings: Settings, fault: Fault
) -> tuple[Surprise, int, Grey]:
    """What is said at last, after so many test images, and the first frame; the task is as before."""
    before = task.happened, task.expected, task.best, task.doubted
    number, added, asked = len(task.applied) + 1, [], list[Settings]()
    while True:
        frame = taken(scene, seed, number + len(asked), settings, fault)
        added.append((f"trial{len(asked)}", frame))
        task.add(added[-1][0], frame, settings)
        told = surprise_of(task, added[-1][0])
        following = None
        if told.doubt is not None and len(asked) < MOST_TESTS:
            following = telling(task, [*task.applied][::-1], told.doubt, asked)
        if following is None:
            break
        settings = following
        asked.append(settings)
    for name, _ in added:
        task.images.remove(name)
        del task.applied[name]
        task.lit.pop(name, None)
    task.happened, task.expected, task.best, task.doubted = before
    return told, len(asked), added[0][1]


def is_right(told: Surprise, fault: Fault, describe: Describe) -> bool:
    """Whether it is the fault that was planted."""
    lights = tuple(describe.lights[light].name for light in fault.lights)
    return told.cause is not None and (told.cause.cause, told.cause.lights) == (fault.name, lights)


def visible(task: PoseTask, frame: Grey, without: Grey) -> bool:
    """Whether a fault changes the picture of the target by LEAST_CHANGE in the median."""
    assert task.expected is not None
    region = target_region(task.model, task.camera, task.expected)
    one, other = (part[region].astype(np.float64) for part in (frame, without))
    bright = np.maximum(one, other) > DARK
    change = np.abs(one - other)[bright] / np.maximum(one, other)[bright]
    return bool(bright.any()) and float(np.median(change)) > LEAST_CHANGE


def play(scene: str, seed: int, images: int, count: Counter[tuple[str, str]]) -> None:
    """One session, with every fault tried on each image from FIRST_FAULT on."""
    device, _ = opened(scene, seed)
    describe = device.describe()
    task = open_task(msgspec.convert({"seed": seed}, StartArgs), describe)
    rng = np.random.default_rng(seed)
    asked = candidates(describe)
    for number in range(1, images + 1):
        foreseen = None
        if task.applied:
            task.estimate(tuple(task.applied))
            foreseen = predict(task, PredictArgs(settings=asked, search=1)).found
        settings = first_settings(describe) if number == 1 else asked[rng.integers(len(asked))]
        settings = foreseen[0].settings if foreseen else settings
        without = None
        sun = opened(scene, seed)[1]
        planted = [drawn(kind, settings, sun, describe.lights, rng) for kind in IN_MID_SESSION]
        for fault in [Fault("nothing"), *filter(None, planted)] if number >= FIRST_FAULT else ():
            count[fault.name, "images"] += 1
            if task.expected is None:
                continue
            told, tests, frame = said(task, scene, seed, settings, fault)
            without = frame if without is None else without
            right = is_right(told, fault, describe)
            count[fault.name, "foreseen"] += 1
            count[fault.name, "right"] += right
            count[fault.name, "wrong"] += told.cause is not None and not right
            count[fault.name, "doubted"] += told.doubt is not None
            count[fault.name, "tests"] += tests
            if visible(task, frame, without):
                count[fault.name, "visible"] += 1
                count[fault.name, "visible_right"] += right
            if told.cause is not None and not right:
                print(f"{scene} {seed} {number}: {fault} is said to be {told.cause}", file=sys.stderr)
        kept = device.capture(settings)
        task.add(f"i{number}", kept.pixels, kept.applied)


def main(
    scenes: Annotated[list[str] | None, typer.Argument(metavar="SCENE...")] = None,
    seeds: Annotated[int, typer.Option(min=1)] = 3,
    images: Annotated[int, typer.Option(min=FIRST_FAULT)] = 5,
) -> None:
    """Plant faults and count what is said of them."""
    count: Counter[tuple[str, str]] = Counter()
    for scene in scenes or SCENES:
        for seed in range(1, seeds + 1):
            play(scene, seed, images, count)
        print(f"{scene}: {sum(n for key, n in count.items() if key[1] == 'images')} images", file=sys.stderr)
    for kind in dict.fromkeys(fault for fault, _ in count):
        row = {what: count[kind, what] for what in COUNTED}
        print(json.dumps({"name": f"surprise-{kind}", **row}))


if __name__ == "__main__":
    typer.run(main)
