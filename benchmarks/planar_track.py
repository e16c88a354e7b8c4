"""The tracker on a recorded thing that slides on a plane, beside ViSP's trackers in the same run.

    .venv/bin/python -m benchmarks.planar_track FOLDER [--visp PREFIX] [--plot OUT.png]

FOLDER has images in order, camera.toml, a .cao model and seed.toml with the pose in the first; of ViSP's
package `visp-images-data` mbt/cube is such a thing, 218 frames of a cube pushed over a desk. Nobody knows its
poses, but what slides on a plane turns about one axis and keeps its height: three of six numbers are the same
in all frames. Each track is compared with the plane that it shows itself: how far the axis is tilted against
it, the height over it, and, where a covariance is stated, the squared error of these three in its units (3 on
average, 11.3 the 99 % bound of an honest one). What all frames have in common is not seen by this.

PREFIX is where ViSP 3.5 is installed (`/usr` after `apt-get install libvisp-mbt-dev libvisp-io-dev`); its
trackers read FOLDER/visp.xml, ViSP's own settings for that sequence.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from scipy.optimize import least_squares

from benchmarks.visp_tracker import KINDS, Step, visp
from geometry.model import Model, load_model
from geometry.rotation import matrix_of
from numerics.arrays import Floats
from vision_server.channels.image_files import read_grey
from vision_server.serve.inputs import read_camera, read_seed_pose
from vision_server.tracking.motion import about
from vision_server.tracking.sources import IMAGES
from vision_server.tracking.tracker import Tracker

TILT_SCALE, HEIGHT_SCALE = np.radians(0.5), 0.003  # of residuals, beyond which they count less
BOUND_99 = 11.34  # of three squared errors
ORDER = [3, 4, 5, 0, 1, 2]  # ViSP states translation first


def ours(images: list[Path], folder: Path, model: Model) -> list[Step]:
    """The project's tracker."""
    camera, table = read_camera(folder / "camera.toml")
    seed_pose = read_seed_pose(folder / "seed.toml", model)
    tracker = Tracker(model, camera, seed_pose, float(table.get("gamma", 1.0)))
    told = [tracker.step(read_grey(image)) for image in images]
    return [Step(one.pose, one.covariance, one.state, one.seconds) for one in told]


def plane_of(rotations: Floats, centres: Floats) -> tuple[Floats, float, Floats]:
    """Normal (3,) and distance of the plane that centres (N, 3) keep to; the normal in the target's frame."""
    start = np.linalg.svd(centres - centres.mean(axis=0))[2][2]

    def unpacked(x: Floats) -> tuple[Floats, float, Floats]:
        normal = matrix_of(x[:3]) @ start
        return normal, float(x[3]), rotations[0].T @ matrix_of(x[4:]) @ normal

    def residuals(x: Floats) -> Floats:
        normal, distance, axis = unpacked(x)
        tilt = np.cross(rotations @ axis, normal) / TILT_SCALE
        return np.concatenate([tilt.ravel(), (centres @ normal - distance) / HEIGHT_SCALE])

    x = np.r_[np.zeros(3), np.median(centres @ start), np.zeros(3)]
    return unpacked(np.asarray(least_squares(residuals, x, loss="soft_l1").x))


def judged(name: str, steps: list[Step], model: Model) -> tuple[dict[str, object], Floats]:
    """How far a track is from sliding on one plane; and the tilt of each pose, degrees."""
    held = [step for step in steps if step.pose is not None]
    poses = [step.pose for step in held if step.pose is not None]
    rotations = np.array([pose.matrix for pose in poses])
    centres = np.array([pose.apply(model.middle[None])[0] for pose in poses])
    normal, distance, axis = plane_of(rotations, centres)
    one = np.cross(normal, [1.0, 0.0, 0.0])
    across = np.stack([one / np.linalg.norm(one), np.cross(normal, one / np.linalg.norm(one))])
    tilt = np.cross(normal, rotations @ axis) @ across.T
    height = centres @ normal - distance
    looks = np.zeros((3, 6))
    looks[:2, :3], looks[2, 3:] = across, normal
    squares = []
    for step, centre, leaning, above in zip(held, centres, tilt, height, strict=True):
        if step.covariance is not None:
            spread = looks @ about(-centre, step.covariance) @ looks.T
            off = np.r_[leaning, above]
            squares.append(float(off @ np.linalg.solve(spread, off)))
    degrees = np.degrees(np.linalg.norm(tilt, axis=1))
    told: dict[str, object] = {
        "name": name, "value": float(np.median(degrees)), "unit": "degrees of tilt, median",
        "frames": len(steps), "poses": len(held), "sure": sum(step.state == "sure" for step in steps),
        "tilt_90_99_100": np.percentile(degrees, [90, 99, 100]).round(2).tolist(),
        "height_mm_50_90_99": (1e3 * np.percentile(np.abs(height), [50, 90, 99])).round(2).tolist(),
        "ms_median": 1e3 * float(np.median([step.seconds for step in held[1:]])),
    }  # fmt: skip
    if squares:
        told |= {
            "squared_error_mean": float(np.mean(squares)),
            "squared_error_median": float(np.median(squares)),
            "within_99": float(np.mean(np.array(squares) <= BOUND_99)),
        }
    return told, degrees


def plotted(tilts: dict[str, Floats], out: Path) -> None:
    """Tilt by frame."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.4, 2.8), layout="constrained")
    axes = figure.subplots()
    for (name, degrees), colour in zip(tilts.items(), ("#0072b2", "#e69f00", "#999999"), strict=False):
        axes.plot(degrees, label=name, color=colour, lw=1.2)
    axes.set(xlabel="frame", ylabel="tilt against the plane, degrees", ylim=(0, 4))
    axes.legend(frameon=False, fontsize=8)
    figure.savefig(out, dpi=120)


def main(
    folder: Path,
    prefix: Annotated[Path | None, typer.Option("--visp", help="Where ViSP is installed.")] = None,
    plot: Path | None = None,
) -> None:
    """One JSON object a tracker."""
    images = sorted(file for file in folder.iterdir() if file.suffix in IMAGES)
    place = next(folder.glob("*.cao"))
    model = load_model(place)
    tracks = {"ours": ours(images, folder, model)}
    if prefix is not None:
        seed_pose = read_seed_pose(folder / "seed.toml", model)
        for kind in KINDS:
            tracks[f"visp {kind}"] = visp(images, folder, place, seed_pose, prefix, kind)
    tilts = {}
    for name, steps in tracks.items():
        told, tilts[name] = judged(name, steps, model)
        print(json.dumps(told), flush=True)
    if plot is not None:
        plotted(tilts, plot)


if __name__ == "__main__":
    typer.run(main)
