"""Whether an image more ever makes the pose worse: errors of nested image sets of light stacks.

    .venv/bin/python -m benchmarks.more_images STACK... [--draws 2] [--most 32]

Of each stack images are drawn that expose the scene, and the pose is estimated from the first 1, 2, 4 ... of
them, from the same seed pose. One JSON object per size of set: the share that is right (1 degree, 1 %), and
over the sets that are right at this size and at half of it the geometric mean of the error, in units of those
limits, and of its ratio to that of half as many images, with a 95 % interval by resampling stacks.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated
from zlib import crc32

import numpy as np
import typer

from benchmarks.photographs import image_set, stack_studio
from benchmarks.trust_rows import drawn_set
from geometry.pose import disturbed
from numerics.arrays import Floats
from vision_server.matching import SearchRange
from vision_server.pipeline import PipelineSettings, estimate_pose

RESAMPLED = 2000


def errors(folder: Path, sizes: list[int], draw: int) -> Floats:
    """Error from the first so many images of one draw, in units of 1 degree and 1 %; inf for no pose."""
    studio, reach = stack_studio(folder), SearchRange()
    rng = np.random.default_rng([draw, crc32(folder.name.encode())])
    shots = drawn_set(studio, "exposed", sizes[-1], rng)
    images = image_set(shots)
    start = disturbed(
        studio.true, rng, reach.rotation_deg, reach.translation_px, studio.camera.fx, studio.model.middle
    )
    out = []
    for size in sizes:
        settings = PipelineSettings(seed=draw, tone_sd_px=shots[0].tone_sd_px)
        names = list(images.images)[:size]
        found = estimate_pose(images, names, studio.model, studio.camera, start, settings)
        error = None if found.pose is None else found.pose.error_to(studio.true)
        out.append(
            np.inf if error is None else max(error.rotation_deg, 100.0 * error.translation_fraction_of_range)
        )
    return np.array(out)


def ratio(before: Floats, after: Floats) -> tuple[float, list[float]]:
    """Geometric mean of after / before, (stacks, draws), where both are right; its 95 % interval."""
    both = (before <= 1.0) & (after <= 1.0)
    logs = np.where(both, np.log(np.where(both, after / before, 1.0)), 0.0)
    drawn = np.random.default_rng(0).integers(0, len(logs), (RESAMPLED, len(logs)))
    means = logs.sum(axis=1)[drawn].sum(axis=1) / np.maximum(both.sum(axis=1)[drawn].sum(axis=1), 1)
    interval = [round(float(x), 2) for x in np.exp(np.percentile(means, [2.5, 97.5]))]
    return round(float(np.exp(logs.sum() / max(both.sum(), 1))), 3), interval


def main(
    stacks: list[Path],
    draws: Annotated[int, typer.Option(min=1)] = 2,
    most: Annotated[int, typer.Option(min=2, help="Images of the largest set.")] = 32,
) -> None:
    """Errors of nested image sets."""
    sizes = [2**k for k in range(int(np.log2(most)) + 1)]
    table = np.array([[errors(folder, sizes, draw) for draw in range(draws)] for folder in stacks])
    for k, size in enumerate(sizes):
        right = table[:, :, k] <= 1.0
        row = {"name": "images", "images": size, "sets": right.size, "right": int(right.sum())}
        row["error"] = round(float(np.exp(np.log(table[:, :, k][right]).mean())), 4) if right.any() else None
        if k > 0:
            row["over_half"], row["over_half_interval"] = ratio(table[:, :, k - 1], table[:, :, k])
        print(json.dumps(row), flush=True)


if __name__ == "__main__":
    typer.run(main)
