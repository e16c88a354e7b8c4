"""A satellite that tumbles before the Earth while the sun goes round and lamps switch, tracked: a picture.

    .venv/bin/python -m benchmarks.tumbling OUT.jpg [--film OUT.mp4] [--frames 108] [--seed 3]

Frames are of the simulator, 30 a second, each under another of its lamps or the sun alone. OUT.jpg shows
every ninth of them with the model where the tracker says it is; the film shows all. One JSON object: how
many frames are sure, how many of these wrong (1 degree, 1 % of the range), and how far the sun has gone.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import cv2
import msgspec
import numpy as np
import typer

from benchmarks.films import PERIOD_S
from benchmarks.tracking import WRONG
from bridge.messages import Settings
from geometry.pose import Pose
from image_server.simulator.scenario import load_scenario
from image_server.simulator.scenario_tables import Scenario, Time
from image_server.simulator.simulator import Simulator
from numerics.arrays import Grey
from report.film import Film
from report.overlay import draw_overlay
from vision_server.tracking.tracked import Tracked
from vision_server.tracking.tracker import Tracker

SCENARIO = "earth-limb"
SUN_DEG_PER_S = 40.0
VELOCITY_M_PER_S, SPIN_DEG_PER_S = (-0.02, 0.0, 0.02), (20.0, 25.0, -15.0)
EVERY, COLUMNS, SMALLER = 9, 4, 0.5  # frame in the picture, which has so many abreast, of this size
JPEG = [cv2.IMWRITE_JPEG_QUALITY, 82]
TEXT_AT, TEXT_SIZE, INK = (8, 18), 0.45, (235, 235, 235)


def tumbling() -> Scenario:
    """The Earth's limb, a target that tumbles, and a sun that goes round."""
    time = Time(
        seconds_per_capture=PERIOD_S,
        sun_deg_per_s=SUN_DEG_PER_S,
        velocity_m_per_s=VELOCITY_M_PER_S,
        spin_deg_per_s=SPIN_DEG_PER_S,
    )
    return msgspec.structs.replace(load_scenario(SCENARIO), time=time)


def taken(device: Simulator, frames: int) -> Iterator[tuple[Grey, Pose]]:
    """Frames, each under another lamp or none, and the true pose in each."""
    told = device.describe()
    lamps = len(told.lights)
    for k in range(frames):
        levels = tuple(
            light.levels - 1 if k % (lamps + 1) == number + 1 else 0
            for number, light in enumerate(told.lights)
        )
        settings = Settings(
            lights=levels,
            shutter_s=told.shutters_s[len(told.shutters_s) // 2],
            aperture=told.apertures[0],
            focal_length_mm=told.focal_lengths_mm[0] if told.focal_lengths_mm else None,
            focus_m=told.focuses_m[0] if told.focuses_m else None,
        )
        pixels = device.capture(settings).pixels
        yield pixels, device.true_pose


def drawn(device: Simulator, pixels: Grey, told: Tracked) -> Grey:
    """A frame as it is in the picture."""
    whole = draw_overlay(pixels, device.model, device.camera, told.pose, told.support, inset=False)
    small = cv2.resize(whole, None, fx=SMALLER, fy=SMALLER, interpolation=cv2.INTER_AREA)
    words = f"{told.frame * PERIOD_S:.1f} s  {told.state}"
    cv2.putText(small, words, TEXT_AT, cv2.FONT_HERSHEY_SIMPLEX, TEXT_SIZE, INK, 1, cv2.LINE_AA)
    return np.asarray(small, dtype=np.uint8)


def main(out: Path, film: Path | None = None, frames: int = 108, seed: int = 3) -> None:
    """Track, draw and say."""
    device = Simulator("satellite", tumbling(), seed)
    tracker = Tracker(device.model, device.camera, device.seed_pose or device.true_pose)
    shown = None if film is None else Film(film, device.model, device.camera, 1.0 / PERIOD_S)
    pictures, sure, wrong, lost = [], 0, 0, 0
    for k, (pixels, true) in enumerate(taken(device, frames)):
        told = tracker.step(pixels, k * PERIOD_S)
        lost += told.pose is None
        if told.state == "sure" and told.pose is not None:
            sure += 1
            wrong += not told.pose.error_to(true).within(*WRONG)
        if k % EVERY == 0:
            pictures.append(drawn(device, pixels, told))
        if shown is not None:
            shown.add(pixels, told.pose, told.support, f"{told.frame} {told.state}")
    if shown is not None:
        shown.close()
    pictures += [np.zeros_like(pictures[0])] * (-len(pictures) % COLUMNS)
    rows = [np.hstack(pictures[k : k + COLUMNS]) for k in range(0, len(pictures), COLUMNS)]
    cv2.imwrite(str(out), np.vstack(rows), JPEG)
    print(
        json.dumps(
            {
                "name": "tracking, tumbling satellite", "value": sure, "unit": "frames sure",
                "frames": frames, "sure_and_wrong": wrong, "lost": lost,
                "sun_turned_deg": SUN_DEG_PER_S * PERIOD_S * (frames - 1),
            }
        )
    )  # fmt: skip


if __name__ == "__main__":
    typer.run(main)
