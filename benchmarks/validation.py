"""The simulator against POV-Ray: the same scenes, difference images, and the error by region.

    .venv/bin/python -m benchmarks.validation [--out FOLDER] [--scene NAME]

Writes a picture of each scene and prints a Markdown table. Needs POV-Ray (Debian: apt-get install povray);
without it, it says so and compares nothing.
"""

import math
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import cv2
import matplotlib as mpl
import numpy as np
import typer

from benchmarks import povray
from geometry.camera import Camera
from image_server.simulator.light import (
    LIGHT_AT_REFERENCE,
    REFERENCE_DISTANCE_M,
    SUN_STRENGTH,
    Illumination,
    beam_table,
)
from image_server.simulator.material import MaterialChanges, load_appearance
from image_server.simulator.rays import NOTHING, Caster, pixel_rays
from image_server.simulator.scenario_tables import Light
from image_server.simulator.scene import Scene, joined, target_part
from image_server.simulator.simulator import Simulator
from image_server.simulator.sky import Sky
from image_server.simulator.tracing import traced
from numerics.arrays import Field, Flags, Floats

ROOT = Path(__file__).resolve().parent.parent
FOLDER = ROOT / "docs" / "images" / "validation"
CAMERA = Camera(640, 480, 800.0, 800.0, 319.5, 239.5)
CHALK = MaterialChanges(texture="plain", grain=0.0, specular=0.0, crinkle=0.0)
SUN = np.array([-0.55, -0.45, -0.7]) / np.linalg.norm([-0.55, -0.45, -0.7])
DISC_LIGHTS = 61  # parallel lights that stand for the sun's disc in POV-Ray
SHOWN_ERROR = 0.02  # full scale of the difference images, of the brightest pixel
EDGE_STEP = 0.05  # of the brightest pixel, between neighbours: an edge


@dataclass(frozen=True)
class Case:
    """A target under one light.

    Attributes
    ----------
    light : a lamp, or None for the sun.
    sun_deg : angular diameter of the sun.
    samples : POV-Ray's rays along each side of a pixel.
    """

    name: str
    says: str
    target: str
    seed: int
    light: Light | None = None
    sun_deg: float = 0.0
    samples: int = 5


CASES = (
    Case("cube-left", "cube, point light on the left", "cube", 3,
         Light(name="left", position=(-0.35, 0.0, 0.0))),
    Case("fixture-right", "fixture, point light on the right", "fixture", 5,
         Light(name="right", position=(0.35, 0.0, 0.0))),
    Case("satellite-beam", "satellite, LED of 12° aimed at it from above", "satellite", 4,
         Light(name="top", position=(0.0, -0.35, 0.0), aim=(0.0, 0.4, 0.7), half_intensity_deg=12.0)),
    Case("satellite-sun", "satellite, the sun as a point", "satellite", 3),
    Case("fixture-penumbra", "fixture, a sun of 4° with its penumbra", "fixture", 3, sun_deg=4.0, samples=3),
)  # fmt: skip


def scene_of(case: Case) -> Scene:
    """The target of a case where its seed draws it, all faces plain."""
    simulator = Simulator(case.target, "nominal", case.seed)
    model = simulator.model
    appearance = load_appearance(simulator.model_file, len(model.faces))
    return joined([target_part(model, appearance, CHALK, simulator.true_pose)])


def ours(case: Case, scene: Scene) -> Field:
    """What the simulator traces."""
    light = case.light or Light(name="none", position=(0.0, 0.0, 0.0))
    aim = np.array(light.aim) / np.linalg.norm(light.aim)
    sky = Sky(SUN, math.radians(case.sun_deg) / 2, SUN_STRENGTH)
    illumination = Illumination(np.array([light.position]), aim[None], beam_table(light)[None], sky)
    return traced(scene, CAMERA, illumination).images[0 if case.light else 1]


def theirs(case: Case, scene: Scene, folder: Path) -> Field:
    """What POV-Ray renders."""
    if case.light is None:
        disc = sun_disc(case.sun_deg)
        lights = [povray.far_light(direction, SUN_STRENGTH / len(disc)) for direction in disc]
    else:
        strength = LIGHT_AT_REFERENCE * REFERENCE_DISTANCE_M**2
        position, aim, power = np.array(case.light.position), None, 0.0
        if case.light.half_intensity_deg is not None:
            aim = np.array(case.light.aim)
            power = math.log(0.5) / math.log(math.cos(math.radians(case.light.half_intensity_deg)))
        lights = [povray.point_light(position, strength, aim, power)]
    return povray.rendered(scene, CAMERA, lights, case.samples, folder)


def sun_disc(diameter_deg: float) -> Floats:
    """Unit vectors (N, 3) spread evenly over the sun's disc: rings of a middle, 6, 12, ... of equal areas."""
    if diameter_deg == 0:
        return np.asarray(SUN[None])
    right = np.cross(SUN, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    down = np.cross(SUN, right)
    rings = round((math.sqrt(12 * DISC_LIGHTS - 3) - 3) / 6)
    out = [SUN]
    for ring in range(1, rings + 1):
        radius = (
            math.radians(diameter_deg) / 2 * math.sqrt((3 * ring**2 + 1) / (3 * rings**2 + 3 * rings + 1))
        )
        around = (np.arange(6 * ring) + 0.5) * math.pi / (3 * ring)
        out += [SUN + radius * (math.cos(a) * right + math.sin(a) * down) for a in around]
    return np.asarray([d / np.linalg.norm(d) for d in out], dtype=np.float64)


def regions(scene: Scene, theirs: Field) -> dict[str, Flags]:
    """Masks (H, W): outlines, edges within the target, faces in the light, faces in the dark."""
    rays = pixel_rays(CAMERA, np.arange(CAMERA.height), np.arange(CAMERA.width))
    triangle, _ = Caster(scene.triangles).first_hits(rays)
    face = np.where(triangle == NOTHING, -1, scene.face[triangle]).reshape(theirs.shape).astype(np.int16)
    window = np.ones((3, 3), np.uint8)
    target = (face >= 0).astype(np.uint8)
    outline = cv2.dilate(target, window) != cv2.erode(target, window)
    crease = (cv2.dilate(face, window) != cv2.erode(face, window)) & ~outline
    inside = (face >= 0) & ~outline & ~crease
    step = cv2.dilate(theirs, window) - cv2.erode(theirs, window)
    away = cv2.erode(inside.astype(np.uint8), window) > 0  # their neighbours are of the same face
    shadow = cv2.dilate((away & (step > EDGE_STEP * theirs.max())).astype(np.uint8), window) > 0
    shadow &= inside
    rest = inside & ~shadow
    lit = rest & (theirs > 0)
    return {
        "faces in the light": lit,
        "faces in the dark": rest & ~lit,
        "edges between faces": crease,
        "edges of shadows": shadow,
        "outline": outline,
    }


def rows(case: Case, mine: Field, other: Field, masks: dict[str, Flags]) -> list[str]:
    """Markdown rows: errors in % of the brightest pixel."""
    scale = 100.0 / float(other.max())
    difference = scale * (mine.astype(np.float64) - other)
    out = []
    for region, mask in masks.items():
        if mask.any():
            errors = difference[mask]
            cells = (
                f"{errors.mean():+.3f}",
                f"{np.sqrt((errors**2).mean()):.3f}",
                f"{np.quantile(np.abs(errors), 0.99):.3f}",
            )
            out.append(f"| {case.says} | {region} | {int(mask.sum())} | {' | '.join(cells)} |")
    return out


def drawn(mine: Field, other: Field, file: Path) -> None:
    """The two images and their difference, side by side, cut to the target."""
    mpl.use("Agg")
    from matplotlib import pyplot as plt

    y, x = np.nonzero(np.maximum(mine, other) > 0)
    cut = np.s_[max(y.min() - 8, 0) : y.max() + 9, max(x.min() - 8, 0) : x.max() + 9]
    top = float(other.max())
    figure, axes = plt.subplots(1, 3, figsize=(9.6, 2.9), layout="constrained")
    for axis, picture, title in zip(axes, (mine, other), ("simulator", "POV-Ray"), strict=False):
        axis.imshow(picture[cut], cmap="gray", vmin=0, vmax=top)
        axis.set_title(title, fontsize=10)
    shown = axes[2].imshow(
        100 * (mine - other)[cut] / top, cmap="RdBu_r", vmin=-100 * SHOWN_ERROR, vmax=100 * SHOWN_ERROR
    )
    axes[2].set_title("difference, % of the brightest", fontsize=10)
    for axis in axes:
        axis.set_axis_off()
    figure.colorbar(shown, ax=axes[2], fraction=0.046)
    figure.savefig(file, dpi=100)
    plt.close(figure)


def main(
    out: Annotated[Path, typer.Option(help="Where the pictures go.")] = FOLDER,
    scene: Annotated[str | None, typer.Option(help="Only this one.")] = None,
) -> None:
    """Compare every scene with POV-Ray."""
    if not povray.available():
        print("POV-Ray is not installed (Debian: apt-get install povray); nothing compared.", file=sys.stderr)
        raise typer.Exit
    out.mkdir(parents=True, exist_ok=True)
    print("| scene | region | pixels | mean | RMS | 99 % below |\n| --- | --- | --- | --- | --- | --- |")
    for case in CASES:
        if scene in (None, case.name):
            placed = scene_of(case)
            mine = ours(case, placed)
            with tempfile.TemporaryDirectory() as scratch:
                other = theirs(case, placed, Path(scratch))
            print("\n".join(rows(case, mine, other, regions(placed, other))), flush=True)
            drawn(mine, other, out / f"{case.name}.png")


if __name__ == "__main__":
    typer.run(main)
