"""How near refinement comes to the best that any estimator could do: the Cramér–Rao bound.

    .venv/bin/python -m benchmarks.cramer_rao [--trials 200] [--noise 2,5,10] [--blur 0.7]

Pictures of a cuboid with plain faces and blurred edges, with Gaussian noise of known standard deviation.
The derivatives of the noiseless picture by pose, grey of each face and blur give the Fisher information of
the image, and so the least covariance of a pose that knows neither greys nor blur. Before these, edge points
with known noise on the same lines: there the bound is that of the points. One JSON object per noise: the root
of the mean squared error in units of the bound (1 is the best possible); the mean squared error in units of
the covariance that refinement states (NEES, 6 when honest), and its percentiles over those of chi-square.
"""

from __future__ import annotations

import json
import os
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import numpy as np
import typer
from scipy.special import owens_t

from geometry.camera import Camera
from geometry.model import Model, load_model
from geometry.pose import Pose, disturbed
from geometry.visibility import DENSEST_PX
from numerics.arrays import Floats, Ints
from vision_server.channels.tone import KNOWN_TONE_SD_PX
from vision_server.image_set import ImageSet
from vision_server.pose.covariance import pose_covariance
from vision_server.pose.line_scales import line_scales
from vision_server.pose.observation import Observation, PoseProblem, observe
from vision_server.pose.refinement import Solution, refine, solve
from vision_server.pose.steps import moved
from vision_server.pose.weights import base_weights

CAMERA = Camera(240, 180, 315.0, 315.0, 119.5, 89.5)
POSE = Pose(np.array([0.55, 0.70, 0.10]), np.array([0.004, -0.003, 0.42]))
SIDES_M = (0.10, 0.08, 0.06)
GREYS = (70.0, 150.0, 60.0, 190.0, 110.0, 170.0)  # of the faces, linear, 0..255
BACKGROUND = 25.0
STEPS = (1e-4, 1e-4, 1e-4, 2e-5, 2e-5, 2e-5)  # rad, m: a twentieth of a pixel or less
GREY_STEP, BLUR_STEP = 0.5, 0.02
FAR = 7.0  # standard deviations of the blur, beyond which an edge is not seen
POINTS_SD_PX, POINTS_TRIALS = (0.1, 0.2, 0.4), 1000
POINTS_STEP = np.array([2e-3, 2e-3, 2e-3, 3e-4, 3e-4, 3e-4])  # rad, m: some tenths of a pixel
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

    Each face is its polygon convolved with a Gaussian, exactly, corners too: a smooth function of the pose.
    """
    model = cuboid()
    out = np.full((CAMERA.height, CAMERA.width), levels[6])
    points = pose.apply(model.vertices)
    corners = CAMERA.project(points)
    normals = model.face_normals @ pose.matrix.T
    width = np.sqrt(blur_px**2 + 1.0 / 12.0)  # pixels have an extent of their own
    for index, face in enumerate(model.faces):
        if normals[index] @ points[face[0]] < 0.0:
            polygon = corners[face]
            left, top = np.maximum(np.floor(polygon.min(axis=0) - FAR * width).astype(int), 0)
            right, bottom = np.ceil(polygon.max(axis=0) + FAR * width).astype(int)
            rows, columns = slice(top, bottom + 1), slice(left, right + 1)
            y, x = np.mgrid[rows, columns][:, : CAMERA.height - top, : CAMERA.width - left]
            coverage = _coverage(polygon, np.stack([x.ravel(), y.ravel()], axis=1), width)
            out[rows, columns] += coverage.reshape(x.shape) * (levels[index] - levels[6])
    return out


def _coverage(polygon: Floats, places: Ints, width: float) -> Floats:
    """Share (M,) of a Gaussian about each place (M, 2) that falls into a polygon (K, 2), px.

    The signed sum over its sides of the triangles between place and side: angle / (2 pi) less Owen's T of
    what lies beyond the side.
    """
    out = np.zeros(len(places))
    for start, end in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        along = (end - start) / np.linalg.norm(end - start)
        away = (start - places) @ np.array([along[1], -along[0]]) / width
        away = np.where(np.abs(away) < 1e-9, 1e-9, away)
        near = np.abs(away) < FAR
        for corner, sign in ((end, 1.0), (start, -1.0)):
            slope = ((corner - places) @ along) / width / away
            out += sign * np.arctan(slope) / (2.0 * np.pi)
            out[near] -= sign * owens_t(away[near], slope[near])
    return np.abs(out)


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
    start = disturbed(true, rng, 0.5, 1.0, CAMERA.fx)
    problem = PoseProblem.at_scale(channels, cuboid(), CAMERA)
    solution = refine(replace(problem, scale=line_scales(problem, start)), start)
    if solution is None:
        return Errors(np.inf, np.inf)
    turn = true.compose(solution.pose.inverse())
    step = np.r_[turn.rotation_vector, true.translation - turn.matrix @ solution.pose.translation]
    stated = step @ np.linalg.solve(pose_covariance(solution), step)
    return Errors(float(step @ bound @ step), float(stated))


def points_trial(sd_px: float, seed: int) -> Errors:
    """Edge points of known noise on the box's lines, a small step away: solved for, and compared."""
    clean = _clean_observation()
    rng = np.random.default_rng(seed)
    true = rng.normal(0.0, 1.0, 6) * POINTS_STEP
    shift = clean.jacobian @ true
    offset = shift + rng.normal(0.0, sd_px, shift.shape)
    noisy = clean._replace(offset=offset[None], sd=np.full((1, len(shift)), sd_px))
    base = base_weights(noisy, False)
    range_m = float(np.linalg.norm(POSE.translation))
    found, weight = solve(noisy, base, range_m, KNOWN_TONE_SD_PX)
    error = found[:6] - true
    bound = clean.jacobian.T @ clean.jacobian / sd_px**2
    solution = Solution(moved(POSE, found, noisy.centre), noisy, weight, KNOWN_TONE_SD_PX)
    step = np.r_[error[:3], error[3:] - np.cross(error[:3], noisy.centre)]
    stated = step @ np.linalg.solve(pose_covariance(solution), step)
    return Errors(float(error @ bound @ error), float(stated))


@cache
def _clean_observation() -> Observation:
    """The box's lines at POSE, each sample with an edge point of the same strength."""
    pixels = np.round(picture(POSE, np.array([*GREYS, BACKGROUND]), 0.7)).astype(np.uint8)
    images = ImageSet(CAMERA.width, CAMERA.height)
    images.add("i1", pixels, 1.0, 1.0)
    channels = images.gradients(["i1"])
    seen = observe(PoseProblem.at_scale(channels, cuboid(), CAMERA), POSE, 3.0, DENSEST_PX)
    return seen._replace(strength=np.ones_like(seen.strength), nuisance=np.zeros_like(seen.nuisance))


def row_of(name: str, errors: list[Errors]) -> dict[str, Any]:
    """The line that is printed for some trials."""
    bound, stated = (np.array([getattr(one, f"of_{kind}") for one in errors]) for kind in ("bound", "stated"))
    row: dict[str, Any] = {"name": f"refinement over the Cramér–Rao bound, {name}"}
    row |= {"value": round(float(np.sqrt(bound.mean() / 6.0)), 3), "unit": "ratio of sd"}
    row |= {"trials": len(errors), "nees_mean": round(float(stated.mean()), 2)}
    for percent, expected in CHI_SQUARE_6.items():
        row[f"nees_p{percent}_over_chi_square"] = round(float(np.percentile(stated, percent)) / expected, 2)
    return row


def main(
    trials: Annotated[int, typer.Option(min=1)] = 200,
    noise: Annotated[str, typer.Option(help="Standard deviations, grey.")] = "2,5,10",
    blur: Annotated[float, typer.Option(min=0.3, help="Of the lens, px.")] = 0.7,
) -> None:
    """Run all trials on all cores."""
    for sd_px in POINTS_SD_PX:
        points = [points_trial(sd_px, seed) for seed in range(POINTS_TRIALS)]
        row = row_of(f"edge points with noise of {sd_px:g} px", points)
        print(json.dumps(row, ensure_ascii=False), flush=True)
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        for noise_grey in (float(part) for part in noise.split(",")):
            errors = list(pool.map(partial(run_trial, noise_grey, blur), range(trials), chunksize=5))
            row = row_of(f"pictures with noise of {noise_grey:g} grey, blur {blur:g} px", errors)
            print(json.dumps(row, ensure_ascii=False), flush=True)


if __name__ == "__main__":
    typer.run(main)
