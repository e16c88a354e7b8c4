"""Two pictures under the same settings, a fault between them: what their difference is said to be.

    .venv/bin/python -m benchmarks.repeated_pictures [SCENE...]

A scene is as `benchmarks.surprises` has it. Under each of four settings a picture is taken before and after
each kind of fault in mid-session, after nothing, and where all light is 2, 5, 10 or 15 % more or less
(flicker). Counted is what `vision_server.prediction.repeated` says of the two, the target being where
it is. One JSON object a kind: pairs, and how many are "relit", "replaced", or neither. Right is relit after a
fault of light, replaced behind an arm, neither else.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from typing import Annotated

import numpy as np
import typer

from benchmarks.planted_faults import (
    Fault,
    camera_and_region,
    drawn,
    opened,
    pictured,
    relit,
    scene_device,
    true_pose,
)
from benchmarks.surprises import IN_MID_SESSION, SCENES
from bridge.messages import Describe, Settings
from vision_server.prediction.repeated import Difference, difference

LEVELS = ((1.0, 0.7, 0.6), (1.0, 1.0, 1.0), (0.0, 1.0, 1.0), (0.0, 0.0, 0.0))  # of the lights, in turn
FLICKERS = (0.02, 0.05, 0.10, 0.15)  # of all light, more and less in turn
EXPOSURES = ((1 / 60, 5.6), (1 / 60, 4.0), (1 / 30, 5.6), (1 / 30, 5.6))  # or the nearest to these


def settings_of(describe: Describe) -> list[Settings]:
    """The four on a device."""
    out = []
    for levels, (shutter_s, aperture) in zip(LEVELS, EXPOSURES, strict=True):
        lights = tuple(
            round(levels[index % len(levels)] * (light.levels - 1))
            for index, light in enumerate(describe.lights)
        )
        shutter, opening = nearest(describe.shutters_s, shutter_s), nearest(describe.apertures, aperture)
        out.append(Settings(lights=lights, shutter_s=shutter, aperture=opening))
    return out


def nearest(offered: Sequence[float], wanted: float) -> float:
    """Of what a device offers."""
    return min(offered, key=lambda one: abs(one - wanted))


def compared(scene: str, rng: np.random.Generator, count: Counter[tuple[str, str]]) -> None:
    """All pairs of a scene."""
    device, sun = opened(scene, 1)
    describe = device.describe()
    camera, region = camera_and_region(describe, true_pose(scene, device))
    for number, settings in enumerate(settings_of(describe)):
        device.come_to(1)
        before = np.asarray(device.capture(settings).pixels, np.uint8)
        for share in FLICKERS:
            now = opened(scene, 1, times=1.0 + share * (-1) ** number)[0]
            now.come_to(2)
            after = np.asarray(now.capture(settings).pixels, np.uint8)
            count_said(count, flicker(share), difference(before, after, region))
        for kind in ("nothing", *IN_MID_SESSION):
            fault = Fault(kind) if kind == "nothing" else drawn(kind, settings, sun, describe.lights, rng)
            if fault is None:
                continue
            now = device if fault.sun is None else scene_device(scene, 1, fault.sun)[0]
            now.come_to(2)
            frame = np.asarray(now.capture(relit(settings, fault, describe.lights)).pixels, np.uint8)
            count_said(count, kind, difference(before, pictured(frame, camera, region, fault, 2), region))


def count_said(count: Counter[tuple[str, str]], kind: str, said: Difference | None) -> None:
    """One pair more."""
    count[kind, "pairs"] += 1
    count[kind, said or "neither"] += 1


def flicker(share: float) -> str:
    """The kind of pairs of which one has so much more or less light."""
    return f"flicker_{share:.0%}"


def main(scenes: Annotated[list[str] | None, typer.Argument(metavar="SCENE...")] = None) -> None:
    """Compare pictures before and after faults."""
    count: Counter[tuple[str, str]] = Counter()
    for number, scene in enumerate(scenes or SCENES):
        compared(scene, np.random.default_rng(number), count)
    for kind in ("nothing", *map(flicker, FLICKERS), *IN_MID_SESSION):
        row = {what: count[kind, what] for what in ("pairs", "relit", "replaced", "neither")}
        print(json.dumps({"name": f"repeated-{kind}", **row}))


if __name__ == "__main__":
    typer.run(main)
