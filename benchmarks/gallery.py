"""Draw the gallery of docs/your_part.md: six parts found at first sight, and views in which they cannot be.

    .venv/bin/python -m benchmarks.gallery [--out docs/images] [--seed 4]

One JSON object per view: how far off the pose is, its score, and how many poses were listed.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, NamedTuple

import cv2
import numpy as np
import typer

from benchmarks.edge_figure import captioned
from benchmarks.first_sight import any_pose
from benchmarks.lines import show
from benchmarks.machined_parts import ROUND, machined, surface_of
from benchmarks.synthetic_parts import error_of, random_part, rendered
from geometry.camera import Camera
from geometry.model import Model, find_target, load_model
from geometry.pose import RIGHT, Pose
from geometry.surface import Surface
from geometry.symmetries import symmetry_of
from numerics.arrays import Grey
from report.overlay import draw_overlay
from vision_server.edges.suppression import edge_picture
from vision_server.image_set import ImageSet
from vision_server.matching import Anywhere
from vision_server.pipeline import estimate_pose
from vision_server.trust.judgement import Estimate

IMAGES = Path(__file__).resolve().parent.parent / "docs" / "images"
CAMERA = Camera(640, 480, 768.0, 768.0, 319.5, 239.5)
TRUSTED = 0.93  # score, docs/trust.md
PANEL_PX, MARGIN_PX = 200, 24
JPEG = [cv2.IMWRITE_JPEG_QUALITY, 82]


class View(NamedTuple):
    """A part, and where it is."""

    name: str
    model: Model
    pose: Pose


def parts(seed: int) -> list[View]:
    """Six parts, drawn or loaded, at orientations drawn at random."""
    made: dict[str, Callable[[np.random.Generator], Surface]] = {
        "machined, 48 segments": lambda rng: surface_of(machined(rng, 48)),
        "prisms, 100 lines": lambda rng: random_part(rng, 100),
        "flange, 128 segments": lambda _: surface_of(ROUND["flange"](128)),
        "cylinder, 256 segments": lambda _: surface_of(ROUND["cylinder"](256)),
        "free form, 64 segments": lambda _: surface_of(ROUND["body"](64)),
    }
    views = []
    for number, (name, surface) in enumerate(made.items()):
        rng = np.random.default_rng((seed, number))
        model = Model.of_surface(name, surface(rng))
        views.append(View(name, model, any_pose(rng, model, CAMERA)))
    satellite = load_model(find_target("satellite"))
    pose = any_pose(np.random.default_rng((seed, len(views))), satellite, CAMERA)
    return [*views, View("satellite.cao", satellite, pose)]


def failures(seed: int) -> list[View]:
    """Views that do not hold a pose: a plate's plain back, and a part that is far away."""
    rng = np.random.default_rng((seed, 0))
    model = Model.of_surface("machined, 48 segments", surface_of(machined(rng, 48)))
    aslant = Pose(np.array([0.35, 0.25, 0.1]), np.array([0.0, 0.0, 0.45]))
    plain = Model.of_surface("plate", random_part(np.random.default_rng(seed), 12))
    return [
        View("a plain plate, from its back", plain, aslant),
        View("too far away", model, Pose(np.array([2.5, 0.4, 0.2]), np.array([0.1, -0.2, 4.5]))),
    ]


def told(estimate: Estimate) -> str:
    """What the program says of a view, in a few words."""
    if estimate.pose is None:
        return f"no pose, {estimate.segments} straight edges"
    trusted = "trusted" if estimate.score > TRUSTED else "not trusted"
    words = f"score {estimate.score:.2f}, {trusted}"
    if len(estimate.poses) > 1:
        words += f"; {len(estimate.poses)} poses fit"
    return words + ("; turns freely" if estimate.free else "")


def panels(view: View, rng: np.random.Generator) -> Grey:
    """The view, its edges and the pose found, beside each other over what is said of it."""
    pixels = rendered(view.model, CAMERA, view.pose, rng)
    images = ImageSet(CAMERA.width, CAMERA.height)
    images.add("i1", pixels, 1.0, 1.0)
    found = estimate_pose(images, ["i1"], view.model, CAMERA, Anywhere())
    edges = 255 - edge_picture(images.edge_map(["i1"]))
    overlay = draw_overlay(pixels, view.model, CAMERA, found.pose, inset=False)
    crop = around(view)
    row = []
    for picture in (pixels, edges, overlay):
        square = cv2.resize(picture[crop], (PANEL_PX, PANEL_PX), interpolation=cv2.INTER_AREA)
        row.append(square if square.ndim == 3 else cv2.cvtColor(square, cv2.COLOR_GRAY2BGR))
    off = None
    if found.pose is not None:
        off = error_of(found.pose, view.pose, symmetry_of(view.model))
    show(
        view.name,
        found.score,
        "score",
        right=off is not None and off.within(*RIGHT),
        mm_off=None if off is None else round(1e3 * off.translation_m, 3),
        degrees_off=None if off is None else round(off.rotation_deg, 3),
        poses=len(found.poses),
    )
    words = f"{view.name}: {told(found)}"
    return captioned(np.asarray(np.hstack(row), np.uint8), words)


def around(view: View) -> tuple[slice, slice]:
    """A square of the frame that holds the part."""
    seen = CAMERA.project(view.pose.apply(view.model.vertices))
    low, high = seen.min(axis=0) - MARGIN_PX, seen.max(axis=0) + MARGIN_PX
    half = min(0.5 * float((high - low).max()), 0.5 * CAMERA.height)
    x, y = (
        float(np.clip(middle, half, side - half))
        for middle, side in zip(0.5 * (low + high), (CAMERA.width, CAMERA.height), strict=True)
    )
    return np.s_[int(y - half) : int(y + half), int(x - half) : int(x + half)]


def sheet(views: list[View], seed: int) -> Grey:
    """All views, two to a row."""
    made = [panels(view, np.random.default_rng((seed, 100 + n))) for n, view in enumerate(views)]
    return np.vstack([np.hstack(made[n : n + 2]) for n in range(0, len(made), 2)])


def main(
    out: Annotated[Path, typer.Option(help="Folder of the pictures.")] = IMAGES,
    seed: Annotated[int, typer.Option(help="Draws parts and orientations.")] = 4,
) -> None:
    """Look at each part once, without a seed pose, and draw what came of it."""
    for name, views in (("gallery.jpg", parts(seed)), ("gallery-failures.jpg", failures(seed))):
        if not cv2.imwrite(str(out / name), sheet(views, seed), JPEG):
            raise typer.BadParameter(f"cannot write {out / name}")


if __name__ == "__main__":
    typer.run(main)
