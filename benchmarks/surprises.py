"""Faults planted in mid-session: what is named rightly, and what is said where nothing has happened.

    .venv/bin/python -m benchmarks.surprises [SCENE...] [--seeds 3] [--images 5]

A scene is a stack folder (kind basis) or a scenario of the simulator (target: cube). Images are chosen as
`informed` does. From the second on, each is also taken with a light dead, with two lights swapped, under
another sun, and of a target that has moved by 1 % of the range (the picture shifted). One JSON object a kind
of fault: images, of how many something was foreseen (from a pose that is rather right), and in how many the
target is said to have moved, which is a false alarm in all rows but its own.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from functools import lru_cache
from pathlib import Path
from typing import Annotated

import cv2
import msgspec
import numpy as np
import typer
from numpy.typing import NDArray

from bridge.messages import Describe, Settings
from bridge.start_messages import StartArgs
from bridge.vision_messages import PredictArgs
from image_server.replay import Replay
from image_server.serve.device import Device
from image_server.simulator import Simulator
from image_server.simulator.scenario import load_scenario
from image_server.simulator.scenario import with_conditions as scenario_with
from stack.read import BasisStack, load_stack
from stack.read import with_conditions as stack_with
from vision_server.pose.observation import PoseProblem
from vision_server.prediction.surprise import moved_to
from vision_server.serve.opening import open_task
from vision_server.serve.prediction import predict
from vision_server.serve.task import PoseTask

Grey = NDArray[np.uint8]

SCENES = ("nominal", "eclipse", "harsh", "textured", "grazing", "blur")
MOVED = 0.01  # of the range
SUNS = (0.0, 0.25, 4.0)  # times what it was; from nothing to FIRST_SUN
FIRST_SUN = 4.0
FIRST_FAULT = 2  # image: of the first nothing is foreseen


@lru_cache(8)
def opened(scene: str, seed: int, sun: float | None = None) -> tuple[Device, float]:
    """The device of a scene, its sun's strength as it is or as given; that strength."""
    if not Path(scene).is_dir():
        scenario = load_scenario(scene)
        changed = scenario_with(scenario, ambient_scale=sun)
        return Simulator("cube", changed, seed), scenario.ambient_scale
    stack = load_stack(Path(scene))
    if not isinstance(stack, BasisStack):
        raise typer.BadParameter(f"{scene} holds recorded frames: nothing can be planted in them.")
    return Replay(stack_with(stack, ambient_scale=sun), seed), stack.table.ambient_scale


def candidates(describe: Describe) -> tuple[Settings, ...]:
    """Lights together, alone and all but one, under each shutter and aperture."""
    top = np.array([light.levels - 1 for light in describe.lights])
    alone = np.diag(top)
    levels = [*(np.rint(share * top) for share in (1 / 3, 2 / 3, 1.0)), *alone, *(top - alone)]
    return tuple(
        Settings(lights=tuple(int(level) for level in row), shutter_s=shutter, aperture=aperture)
        for row in levels
        for shutter in describe.shutters_s
        for aperture in describe.apertures
    )


def first_settings(describe: Describe) -> Settings:
    """What `informed` begins with on a camera like the paper's: full light, short and small."""
    levels = tuple(light.levels - 1 for light in describe.lights)
    return Settings(lights=levels, shutter_s=min(describe.shutters_s), aperture=max(describe.apertures))


def faults(
    scene: str, seed: int, number: int, settings: Settings, describe: Describe, rng: np.random.Generator
) -> Iterator[tuple[str, Callable[[], Grey]]]:
    """Each fault, and the frame that it would give."""

    def frame(levels: tuple[int, ...], sun: float | None = None) -> Grey:
        device, _ = opened(scene, seed, sun)
        device.come_to(number)
        return device.capture(msgspec.structs.replace(settings, lights=levels)).pixels

    lit = [index for index, level in enumerate(settings.lights) if level > 0]
    if lit:
        dead = int(rng.choice(lit))
        yield (
            "light_dead",
            lambda: frame(
                tuple(0 if index == dead else level for index, level in enumerate(settings.lights))
            ),
        )
    one, other = sorted(rng.choice(len(settings.lights), 2, replace=False).tolist())
    if settings.lights[one] != settings.lights[other]:
        swapped = list(settings.lights)
        swapped[one], swapped[other] = swapped[other], swapped[one]
        yield "lights_swapped", lambda: frame(tuple(swapped))
    now = opened(scene, seed)[1]
    then = float(rng.choice(SUNS)) * now if now > 0.0 else FIRST_SUN
    yield "sun_changed", lambda: frame(settings.lights, then)
    angle = rng.uniform(0.0, 2.0 * np.pi)
    camera = describe.camera
    assert camera is not None
    shift = MOVED * camera.fx * np.array([np.cos(angle), np.sin(angle)])

    def shifted() -> Grey:
        affine = np.array([[1.0, 0.0, shift[0]], [0.0, 1.0, shift[1]]])
        pixels = frame(settings.lights)
        size = (camera.width, camera.height)
        out = cv2.warpAffine(pixels, affine, size, flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(out, dtype=np.uint8)

    yield "target_moved", shifted
    yield "nothing", lambda: frame(settings.lights)


def moved(task: PoseTask, pixels: Grey, settings: Settings) -> bool:
    """Whether the target is said to have moved in a frame; the frame is forgotten again."""
    assert task.expected is not None
    task.images.add("trial", pixels, task.exposure(settings), task.gamma)
    problem = PoseProblem.at_scale(task.images.gradients(["trial"]), task.model, task.camera)
    task.images.remove("trial")
    return moved_to(problem, task.expected) is not None


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
        drawn = first_settings(describe) if number == 1 else asked[rng.integers(len(asked))]
        settings = foreseen[0].settings if foreseen else drawn
        planted = faults(scene, seed, number, settings, describe, rng) if number >= FIRST_FAULT else ()
        for fault, taken in planted:
            count[fault, "images"] += 1
            if task.expected is not None:
                count[fault, "foreseen"] += 1
                count[fault, "moved"] += moved(task, taken(), settings)
        frame = device.capture(settings)
        task.add(f"i{number}", frame.pixels, frame.applied)


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
        row = {what: count[kind, what] for what in ("images", "foreseen", "moved")}
        print(json.dumps({"name": f"surprise-{kind}", **row}))


if __name__ == "__main__":
    typer.run(main)
