"""Other people's meshes: whether they are read, whether their poses are found, and what is trusted.

    .venv/bin/python -m benchmarks.meshes FOLDER... [--every 3] [--first-sight]

FOLDER holds mesh files, however deep; one in so many is taken. Each is in the unit in which it is nearest to
0.4 m across. The simulator shows it in nominal light, under two settings, and its pose is estimated from a
drawn seed pose, or from none. One JSON object a mesh, then one of them all. Right is within 1 degree and, of
the part's middle, 1 % of the range of a pose that looks like the true one: turned about the axis of a round
part; without a seed pose also by any other exact symmetry.
"""

from __future__ import annotations

import json
import math
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Annotated

import typer

from benchmarks.synthetic_parts import error_of
from bridge.errors import BadInput
from bridge.messages import Settings
from geometry.errors import GeometryError
from geometry.model import READERS, UNITS_M, Model, about_middle, load_model
from geometry.pose import RIGHT, Pose, PoseError
from geometry.symmetries import if_round, symmetry_of
from image_server.simulator.simulator import Simulator
from vision_server.image_set import ImageSet
from vision_server.matching.match import Anywhere
from vision_server.pipeline import PipelineSettings, estimate_pose

ACROSS_M = 0.4
SETTINGS = (
    Settings(lights=(7, 7, 7), shutter_s=1 / 60, aperture=5.6),
    Settings(lights=(7, 0, 2), shutter_s=1 / 120, aperture=4.0),
)
SEED = 3
TRUSTED = 1.0 - 1.0 / 15.0  # the score at which a session's merit is its default threshold, 1 px


def off_by(model: Model, found: Pose, true: Pose, first_sight: bool) -> PoseError:
    """How far off a pose is at the part's middle: its file's origin may be many sizes of the part away."""
    centred, to_middle = about_middle(model)
    symmetry = (symmetry_of if first_sight else if_round)(centred)
    return error_of(found.compose(to_middle), true.compose(to_middle), symmetry)


def of_mesh(file: Path, first_sight: bool) -> dict[str, object]:
    """What came of one mesh."""
    told: dict[str, object] = {"mesh": file.name}
    try:
        across = load_model(file).diameter
        unit = min(UNITS_M, key=lambda one: abs(math.log(across * UNITS_M[one] / ACROSS_M)))
        scene = Simulator(file, "nominal", SEED, unit=unit)
    except (GeometryError, BadInput) as error:
        return told | {"refused": str(error)}
    images, names = ImageSet(scene.camera.width, scene.camera.height), []
    for number, settings in enumerate(SETTINGS, 1):
        names.append(f"i{number}")
        images.add(names[-1], scene.capture(settings).pixels, 1.0, 1.0)
    assert scene.seed_pose is not None
    start = Anywhere() if first_sight else scene.seed_pose
    estimate = estimate_pose(images, names, scene.model, scene.camera, start, PipelineSettings())
    told |= {"lines": len(scene.model.lines), "seconds": round(sum(estimate.seconds.values()), 2)}
    if estimate.pose is None:
        return told | {"right": False, "score": 0.0}
    off = off_by(scene.model, estimate.pose, scene.true_pose, first_sight)
    return told | {
        "right": off.within(*RIGHT),
        "score": round(estimate.score, 3),
        "poses": len(estimate.poses),
        "degrees": round(off.rotation_deg, 3),
        "share_of_range": round(off.translation_fraction_of_range, 5),
    }


def main(
    folders: list[Path],
    every: Annotated[int, typer.Option(help="One mesh in so many.")] = 1,
    first_sight: Annotated[bool, typer.Option("--first-sight", help="No seed pose is given.")] = False,
) -> None:
    """One line a mesh, and one of all."""
    found = chain.from_iterable(folder.rglob("*") for folder in folders)
    meshes = sorted(file for file in found if file.suffix.lower() in READERS)[::every]
    rows = []
    with ProcessPoolExecutor() as pool:
        for row in pool.map(partial(of_mesh, first_sight=first_sight), meshes):
            print(json.dumps(row), flush=True)
            rows.append(row)
    shown = [row for row in rows if "refused" not in row]
    if not shown:
        sys.exit("no mesh there that can be shown")
    right = [row for row in shown if row["right"]]
    trusted = [row for row in shown if float(str(row["score"])) >= TRUSTED]
    print(json.dumps({
        "name": "meshes", "value": len(right) / len(shown), "unit": "share right", "meshes": len(rows),
        "refused": len(rows) - len(shown), "right": len(right), "trusted": len(trusted),
        "wrong_and_trusted": sum(not row["right"] for row in trusted),
    }))  # fmt: skip


if __name__ == "__main__":
    typer.run(main)
