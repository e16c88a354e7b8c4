"""A small picture of every scenario, for the documentation.

    .venv/bin/python -m benchmarks.scenario_pictures [FOLDER]

Each is the first frame of a session: lights half up, the longest exposure that clips next to nothing of the
target. The targets take turns.
"""

from pathlib import Path
from typing import Annotated

import cv2
import msgspec
import numpy as np
import typer

from bridge.messages import Describe, Settings
from image_server.simulator.scenario import SCENARIOS, load_scenario
from image_server.simulator.scenario_tables import Time
from image_server.simulator.simulator import Simulator
from numerics.arrays import Grey
from stack.exposure import relative_exposure

ROOT = Path(__file__).resolve().parent.parent
FOLDER = ROOT / "docs" / "images" / "scenarios"
TARGETS = ("cube", "fixture", "satellite")
SEED = 3
SIZE = (200, 150)
QUALITY = 80
MOST_CLIPPED = 0.02  # of the target
CLIPPED_GREY = 250


def exposures(described: Describe) -> list[Settings]:
    """Every shutter and aperture with the lights half up, the longest exposure first."""
    levels = tuple(light.levels // 2 for light in described.lights)
    settings = [
        Settings(lights=levels, shutter_s=shutter, aperture=aperture)
        for shutter in described.shutters_s
        for aperture in described.apertures
    ]
    return sorted(settings, key=lambda s: -relative_exposure(s.shutter_s, s.aperture))


def picture(scenario: str, target: str) -> Grey:
    """A well exposed frame (H, W) of a scenario; the shortest exposure where all of them clip."""
    still = msgspec.structs.replace(load_scenario(scenario), time=Time())
    simulator = Simulator(target, still, SEED)
    for settings in exposures(simulator.describe()):
        pixels = simulator.capture(settings).pixels
        lit = np.any([image > 0.01 for image in simulator.basis()[:-1]], axis=0)
        if np.mean(pixels[lit] >= CLIPPED_GREY) <= MOST_CLIPPED:
            break
    return pixels


def main(folder: Annotated[Path, typer.Argument(help="Where the pictures go.")] = FOLDER) -> None:
    """Write one JPEG per scenario."""
    folder.mkdir(parents=True, exist_ok=True)
    for number, file in enumerate(sorted(SCENARIOS.glob("*.toml"))):
        small = cv2.resize(
            picture(file.stem, TARGETS[number % len(TARGETS)]), SIZE, interpolation=cv2.INTER_AREA
        )
        cv2.imwrite(str(folder / f"{file.stem}.jpg"), small, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])


if __name__ == "__main__":
    typer.run(main)
