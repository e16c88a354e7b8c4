"""How near refinement comes to the best that any estimator could do: the Cramér–Rao bound.

    .venv/bin/python -m benchmarks.cramer_rao [--trials 200] [--noise 2,5,10] [--blur 0.7]

Pictures of a cuboid with plain faces and blurred edges, with Gaussian noise of known standard deviation.
The derivatives of the noiseless picture by pose, grey of each face and blur give the Fisher information of
the image, and so the least covariance of a pose that knows neither greys nor blur. One JSON object per noise:
the root of the mean squared error in units of that bound (1 is the best possible), the same in units of the
covariance that refinement states (1 when honest), and the 90th and 99th percentile of the squared normalised
error over those of the chi-square distribution with six degrees of freedom.
"""

from __future__ import annotations

import json
import os
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import numpy as np
import typer
from numpy.typing import NDArray
from scipy.special import ndtr

from geometry.camera import Camera
from geometry.model import Model, load_model
from geometry.pose import Pose, disturbed
from vision_server.covariance import pose_covariance
from vision_server.image_set import ImageSet
from vision_server.line_scales import line_scales
from vision_server.refinement import refine

Floats = NDArray[np.float64]

CAMERA = Camera(240, 180, 315.0, 315.0, 119.5, 89.5)
POSE = Pose(np.array([0.55, 0.70, 0.10]), np.array([0.004, -0.003, 0.42]))
SIDES_M = (0.10, 0.08, 0.06)
GREYS = (70.0, 150.0, 60.0, 190.0, 110.0, 170.0)  # of the faces, linear, 0..255
BACKGROUND = 25.0
STEPS = (1e-4, 1e-4, 1e-4, 2e-5, 2e-5, 2e-5)  # rad, m: a twentieth of a pixel or less
GREY_STEP, BLUR_STEP = 0.5, 0.02
SCALE_REACH_PX = 4.0
CHI_SQUARE_6 = {50: 5.348, 90: 10.645, 99: 16.812}  # percentiles


@cache
def cuboid() -> Model:
    """A closed box with plain faces, centred on its origin."""
    x, y, z = (0.5 * side for side in SIDES_M)
    corners = [(i, j, k) for k in (-z, z) for i, j in ((-x, -y), (x, -y), (x, y), (-x, y))]
    faces = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    text = ["V1", "8", *(" ".join(map(str, corner)) for corner in corners), "0", "0", "6"]
    text += ["4 " + " ".join(map(str, face)) for face in faces] + ["0", "0"]
    with TemporaryDirectory() as folder:
        path = Path(folder) / "cuboid.cao"
        path.write_text("\n".join(text) + "\n")
        return load_model(path)


def picture(pose: Pose, levels: Floats, blur_px: float) -> Floats:
    """Noiseless linear intensity, (H, W), 0..255: levels (7,) of the six faces and of what is behind.

    Each face is a product of blurred half-planes, so that the picture is a smooth function of the pose.
    """
    model = cuboid()
    y, x = np.mgrid[0 : CAMERA.height, 0 : CAMERA.width].astype(np.float64)
    out = np.full(x.shape, levels[6])
    points = pose.apply(model.vertices)
    corners = CAMERA.project(points)
    normals = model.face_normals @ pose.matrix.T
    width = np.sqrt(blur_px**2 + 1.0 / 12.0)  # pixels have an extent of their own
    for index, face in enumerate(model.faces):
        if normals[index] @ points[face[0]] < 0.0:
            polygon = corners[face]
            coverage = np.ones(x.shape)
            for start, end in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
                along = (end - start) / np.linalg.norm(end - start)
                inside = along[1] * (x - start[0]) - along[0] * (y - start[1])
                coverage *= ndtr(inside / width)
            out += coverage * (levels[index] - levels[6])
    return out


def information(pose: Pose, levels: Floats, blur_px: float) -> Floats:
    """Fisher information (6, 6) on the left-multiplied step of the pose, for noise of variance 1."""
    columns = []
    for k, step in enumerate(STEPS):
        delta = np.zeros(6)
        delta[k] = step
        ahead, behind = (
            picture(pose.stepped(delta), levels, blur_px),
            picture(pose.stepped(-delta), levels, blur_px),
        )
        columns.append((ahead - behind).ravel() / (2 * step))
    for k in range(7):
        delta = np.zeros(7)
        delta[k] = GREY_STEP
        ahead, behind = picture(pose, levels + delta, blur_px), picture(pose, levels - delta, blur_px)
        columns.append((ahead - behind).ravel() / (2 * GREY_STEP))
    ahead, behind = picture(pose, levels, blur_px + BLUR_STEP), picture(pose, levels, blur_px - BLUR_STEP)
    columns.append((ahead - behind).ravel() / (2 * BLUR_STEP))
    jacobian = np.stack(columns, axis=1)
    jacobian = jacobian[:, np.abs(jacobian).max(axis=0) > 0]  # faces that are not seen have no grey
    whole = jacobian.T @ jacobian
    nuisance = np.linalg.solve(whole[6:, 6:], whole[6:, :6])
    out: Floats = whole[:6, :6] - whole[:6, 6:] @ nuisance
    return out


@dataclass(frozen=True)
class Errors:
    """Squared error of one refined pose in units of the bound and of the stated covariance."""

    of_bound: float
    of_stated: float


def run_trial(noise_grey: float, blur_px: float, seed: int) -> Errors:
    """Photograph the box from a pose drawn at random, refine from nearby, and compare."""
    rng = np.random.default_rng(seed)
    true = disturbed(POSE, rng, 15.0, 20.0, CAMERA.fx)
    levels = np.array([*GREYS, BACKGROUND])
    clean = picture(true, levels, blur_px)
    pixels = np.clip(np.round(clean + noise_grey * rng.standard_normal(clean.shape)), 0, 255)
    bound = information(true, levels, blur_px) / (noise_grey**2 + 1.0 / 12.0)
    images = ImageSet(CAMERA.width, CAMERA.height)
    images.add("i1", pixels.astype(np.uint8), 1.0, 1.0)
    channels = images.gradients(["i1"])
    channels[0].prepare(1)
    start = disturbed(true, rng, 0.5, 1.0, CAMERA.fx)
    scale = line_scales(channels, cuboid(), CAMERA, start, SCALE_REACH_PX)
    solution = refine(channels, cuboid(), CAMERA, start, scale)
    if solution is None:
        return Errors(np.inf, np.inf)
    turn = true.compose(solution.pose.inverse())
    step = np.r_[turn.rotation_vector, true.translation - turn.matrix @ solution.pose.translation]
    stated = step @ np.linalg.solve(pose_covariance(solution), step)
    return Errors(float(step @ bound @ step), float(stated))


def main(
    trials: Annotated[int, typer.Option(min=1)] = 200,
    noise: Annotated[str, typer.Option(help="Standard deviations, grey.")] = "2,5,10",
    blur: Annotated[float, typer.Option(min=0.3, help="Of the lens, px.")] = 0.7,
) -> None:
    """Run all trials on all cores."""
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        for noise_grey in (float(part) for part in noise.split(",")):
            errors = list(pool.map(partial(run_trial, noise_grey, blur), range(trials), chunksize=5))
            bound, stated = (
                np.array([getattr(e, f"of_{kind}") for e in errors]) for kind in ("bound", "stated")
            )
            row: dict[str, Any] = {
                "name": f"refinement over the Cramér–Rao bound, noise {noise_grey:g} grey, blur {blur:g} px"
            }
            row |= {
                "value": round(float(np.sqrt(bound.mean() / 6.0)), 3),
                "unit": "ratio of sd",
                "trials": trials,
            }
            row |= {"bound_median": round(float(np.sqrt(np.median(bound) / CHI_SQUARE_6[50])), 3)}
            row |= {"stated": round(float(np.sqrt(stated.mean() / 6.0)), 3)}
            for percent in (50, 90, 99):
                share = float(np.percentile(stated, percent)) / CHI_SQUARE_6[percent]
                row[f"stated_p{percent}_over_chi_square"] = round(share, 3)
            print(json.dumps(row, ensure_ascii=False), flush=True)


if __name__ == "__main__":
    typer.run(main)
