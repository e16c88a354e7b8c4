"""Linearity and photon transfer of the simulator's camera, measured on its frames as in a laboratory.

    .venv/bin/python -m benchmarks.photon_transfer [--out FILE]

Draws both curves and prints what was measured beside what was put in (EMVA 1288, the method of two frames:
their difference tells the noise, whatever the scene shows).
"""

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Annotated

import matplotlib as mpl
import msgspec
import numpy as np
import typer

from bridge.messages import Settings
from image_server.simulator.scenario_tables import Scenario
from image_server.simulator.simulator import Simulator
from numerics.arrays import Floats
from stack.exposure import WHITE, relative_exposure

ROOT = Path(__file__).resolve().parent.parent
FILE = ROOT / "docs" / "images" / "photon-transfer.png"
ROUNDING = 1 / 12 / WHITE**2  # variance of the 8-bit steps, of full scale
BINS = 24
LEAST_PIXELS = 400  # in a bin, for its variance to be worth something
HIGHEST = 0.85  # of full scale: above, noise clips
DARK_SIGMAS = 5.0  # below so many deviations of the read noise, noise clips at black
GAINS = (1.0, 2.0, 4.0, 8.0)
FRAMES = 16  # averaged for a point of the linearity curve


@dataclass(frozen=True)
class Transfer:
    """Mean and variance (both of full scale) in bins of the mean, and the line through them."""

    mean: Floats
    variance: Floats
    slope: float
    foot: float


def camera_with(gain: float, read_noise_e: float, full_well_e: float) -> Scenario:
    """The nominal scenario under a camera with these parameters."""
    scenario = Scenario()
    camera = msgspec.structs.replace(
        scenario.camera, gain=gain, read_noise_e=read_noise_e, full_well_e=full_well_e
    )
    return msgspec.structs.replace(scenario, camera=camera)


def transfer(scenario: Scenario, settings: list[Settings], pairs: int = 4) -> Transfer:
    """Photon-transfer curve from pairs of frames of the cube."""
    simulator = Simulator("cube", scenario, 3)
    means, halves = [], []
    for chosen in settings:
        for _ in range(pairs):
            one, other = (simulator.capture(chosen).pixels.astype(np.float64) / WHITE for _ in range(2))
            means.append(((one + other) / 2).ravel())
            halves.append(((one - other) ** 2 / 2).ravel())
    mean, half = np.concatenate(means), np.concatenate(halves)
    camera = scenario.camera
    dark = DARK_SIGMAS * max(camera.read_noise_e * camera.gain / camera.full_well_e, 1 / WHITE)
    edges = np.linspace(dark, HIGHEST, BINS + 1)
    place = np.digitize(mean, edges) - 1
    bins = [b for b in range(BINS) if (place == b).sum() >= LEAST_PIXELS]
    binned = np.array([mean[place == b].mean() for b in bins])
    variance = np.array([half[place == b].mean() for b in bins]) - ROUNDING
    weight = np.array([(place == b).sum() for b in bins]) ** 0.5 / variance
    slope, foot = np.polyfit(binned, variance, 1, w=weight)
    return Transfer(binned, variance, float(slope), float(foot))


def bracket(gain: float) -> list[Settings]:
    """Settings that spread the cube over the scale at a gain: every light half up."""
    return [
        Settings(lights=(4, 4, 4), shutter_s=shutter, aperture=aperture)
        for shutter in (1 / 240, 1 / 120, 1 / 60, 1 / 30)
        for aperture in (2.8, 5.6)
        if 0.1 <= relative_exposure(shutter, aperture) * gain <= 3.0
    ]


def linearity(scenario: Scenario, patches: int = 6) -> tuple[Floats, Floats]:
    """Signal that the exposure asks for, and mean signal found (N,), both of full scale.

    Parts of the cube that are alike in brightness, under every shutter and aperture; left out where noise
    clips at either end.
    """
    simulator = Simulator("cube", scenario, 3)
    camera, lights = scenario.camera, (4, 4, 4)
    radiance = simulator.radiance(lights)
    edges = np.quantile(radiance[radiance > 0], np.linspace(0.02, 0.98, patches + 1))
    dark = DARK_SIGMAS * max(camera.read_noise_e * camera.gain / camera.full_well_e, 1 / WHITE)
    wanted, found = [], []
    for shutter in camera.shutters_s:
        for aperture in camera.apertures:
            scale = relative_exposure(shutter, aperture) * camera.gain
            settings = Settings(lights=lights, shutter_s=shutter, aperture=aperture)
            mean = np.mean([simulator.capture(settings).pixels for _ in range(FRAMES)], axis=0) / WHITE
            for low, high in pairwise(edges):
                if low * scale > dark and high * scale < HIGHEST:
                    inside = (radiance >= low) & (radiance < high)
                    wanted.append(scale * float(radiance[inside].mean()))
                    found.append(float(mean[inside].mean()))
    return np.array(wanted), np.array(found)


def main(out: Annotated[Path, typer.Option(help="The picture.")] = FILE) -> None:
    """Measure, print and draw."""
    mpl.use("Agg")
    from matplotlib import pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.4), layout="constrained")
    print("| gain | slope put in | measured | read noise put in, e | measured, e |")
    print("| --- | --- | --- | --- | --- |")
    well, read = 10000.0, 40.0
    for gain in GAINS:
        found = transfer(camera_with(gain, read, well), bracket(gain))
        measured = float(np.sqrt(max(found.foot, 0.0)) * well / gain)
        print(f"| {gain:g} | {gain / well:.2e} | {found.slope:.2e} | {read:g} | {measured:.1f} |")
        points = right.plot(found.mean, found.variance, "o", markersize=3, label=f"gain {gain:g}")
        line = np.linspace(0.0, HIGHEST, 100)
        right.plot(line, line * gain / well + (read * gain / well) ** 2, color=points[0].get_color(), lw=1)
    right.set(xlabel="mean, of full scale", ylabel="variance", yscale="log")
    right.set_ylim(1e-5, 6e-3)
    right.legend(fontsize=8, ncols=4, loc="upper center", title="lines: put in", title_fontsize=8)
    wanted, found_signal = linearity(camera_with(2.0, 6.0, well))
    deviation = 100 * (found_signal - wanted)
    left.plot(wanted, deviation, "o", markersize=3)
    left.axhline(0.0, color="k", lw=1)
    left.set(xlabel="exposure times radiance, of full scale", ylabel="signal less that, % of full scale")
    left.set_ylim(-0.05, 0.05)
    print(f"\nLargest deviation from linearity: {np.abs(deviation).max():.3f} % of full scale")
    out.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(out, dpi=100)


if __name__ == "__main__":
    typer.run(main)
