"""Light stacks of scenes no one has seen, by POV-Ray: any wireframe, textured, lit by three lamps and a sun.

    .venv/bin/python -m benchmarks.ray_traced_stacks OUT [MODEL...] [--count 6] [--seed 1] [--hard] [--off 0]

Writes OUT/<model>-<number>, stack folders for `swipl main.pl --stack` and for `experiments run`.
Pose, textures, sun and what stands behind the target are drawn from the seed. Odd numbers are in black
space, with a seed pose from half the search range; even ones stand before a wall and boxes, with a seed pose
from all of it. Sun, blur and the power of the lamps change from one to the next. Needs POV-Ray (Debian:
apt-get install povray).
"""

import math
import sys
import tempfile
from pathlib import Path
from typing import Annotated, Any
from zlib import crc32

import cv2
import msgspec
import numpy as np
import typer

from benchmarks import hard_scenes, povray
from benchmarks.drawn_parts import part_file
from benchmarks.hard_scenes import Conditions
from benchmarks.patches import of_faces
from bridge.messages import CameraDescription, Describe, LightDescription, PoseMessage, TargetDescription
from geometry.camera import Camera
from geometry.model import Model, load_model
from geometry.pose import Pose
from image_server.simulator.placement import drawn_pose, drawn_sun, seed_pose_of
from image_server.simulator.scenario_tables import PoseDraw, Sun
from numerics.arrays import Floats
from stack.exposure import APERTURES, FULL_SCALE_16, SHUTTERS_S
from stack.write import described, new_folder, write_table

CAMERA = Camera(640, 480, 800.0, 800.0, 319.5, 239.5)
DESCRIPTION = msgspec.convert(CAMERA.to_dict() | {"gain": 2.0, "read_noise_e": 6.0}, CameraDescription)
TARGETS = ("cube", "fixture", "satellite")
LAMPS = {"left": (-0.35, 0.0, 0.0), "right": (0.35, 0.0, 0.0), "top": (0.0, -0.35, 0.0)}  # m, camera frame
LEVELS = 8
SHARE_OF_FRAME = (0.6, 1.1)  # the target's diameter over the frame's height
TILT_DEG = (10.0, 55.0)
SUN_ANGLE_DEG = (20.0, 100.0)
GRAZING_DEG = (60.0, 86.0)
LAMP_RADIANCE = 0.3  # of a white face turned to a lamp, at full level
SUN_RADIANCE = 0.05  # of a white face turned to the sun
BEAM_DEG = 30.0  # half angle at which a lamp's beam ends
SAMPLES = 3
MOST_SKINS = 3
MOST_CONTRAST = 0.5
WALLS = 0.5  # of the hard scenes without a wall of lines have another
SKINS = ("granite", "bozo", "wrinkles", "marble turbulence 0.7", "agate", "crackle")

CONDITIONS = (
    Conditions(sun=8.0, power=0.25, defocus_px=4.0, motion_px_per_s=260.0),
    Conditions(sun=1.0),
    Conditions(sun=20.0),
    Conditions(sun=0.0, power=0.25, defocus_px=4.0, motion_px_per_s=260.0),
    Conditions(sun=20.0, defocus_px=3.0, motion_px_per_s=250.0),
)


def drawn_stack(
    file: Path, number: int, seed: int, folder: Path, hard: bool = False, off: float = 0.0
) -> None:
    """Draw, render and write one stack; a hard one is of the kind that its number says, see `hard_scenes`.

    The part that is seen is not quite its model's where it is ``off``, see `hard_scenes.not_quite`.

    Raises
    ------
    BadInput : the folder holds a stack already.
    DeviceError : POV-Ray failed.
    """
    new_folder(folder)
    drawn = [seed, number, crc32(file.stem.encode())]
    rng = np.random.default_rng(drawn)
    model = hard_scenes.not_quite(load_model(file), off, np.random.default_rng(drawn))
    kind = hard_scenes.KINDS[(number - 1) % len(hard_scenes.KINDS)] if hard else ""
    before_wall = number % 2 == 0 or hard
    share = rng.uniform(*SHARE_OF_FRAME)
    distance = model.diameter * CAMERA.fy / (share * CAMERA.height)
    draw = PoseDraw(range_m=(distance, distance), tilt_deg=TILT_DEG, roll_deg=180.0, inside_fraction=0.9)
    pose = drawn_pose(draw, model, np.array([0.0, 0.0, -1.0]), CAMERA, rng)
    sun = drawn_sun(Sun(angle_deg=GRAZING_DEG if kind in ("B", "E") else SUN_ANGLE_DEG), model, pose, rng)
    things = [] if kind == "N" else _target(model, pose, rng)
    if hard:
        things += _hard(kind, model, pose, sun, rng)
    elif before_wall:
        things += _behind(model, pose, rng)
    lights = {name: _lamp(np.array(place), pose) for name, place in LAMPS.items()}
    lights["sun"] = povray.far_light(sun, SUN_RADIANCE)
    with tempfile.TemporaryDirectory() as scratch:
        for name, light in lights.items():
            image = povray.ray_traced([light, *things], CAMERA, SAMPLES, Path(scratch))
            cv2.imwrite(str(folder / f"{name}.png"), np.rint(image * FULL_SCALE_16).astype(np.uint16))
    fraction = 1.0 if before_wall else 0.5
    describe = Describe(
        device="POV-Ray",
        lights=tuple(LightDescription(name=name, levels=LEVELS, position=at) for name, at in LAMPS.items()),
        shutters_s=SHUTTERS_S,
        apertures=APERTURES,
        camera=DESCRIPTION,
        target=TargetDescription(
            model=str(file), seed_pose=_message(seed_pose_of(pose, load_model(file), CAMERA, fraction, rng))
        ),
    )
    conditions = hard_scenes.conditions(kind, rng) if hard else CONDITIONS[number % len(CONDITIONS)]
    table: dict[str, Any] = {"kind": "basis", "ambient": "sun.png", "ambient_scale": conditions.sun}
    table |= described(folder, describe)
    table["camera"]["defocus_sigma_px"] = conditions.defocus_px
    heading = rng.uniform(-math.pi, math.pi)
    table["camera"]["motion_px_per_s"] = [
        conditions.motion_px_per_s * math.cos(heading), conditions.motion_px_per_s * math.sin(heading)
    ]  # fmt: skip
    for light in table["lights"]:
        light["radiance"] = f"{light['name']}.png"
        light["power"] = conditions.power
    table["target"]["true_pose"] = msgspec.to_builtins(_message(pose))
    write_table(folder, table)


def _message(pose: Pose) -> PoseMessage:
    return msgspec.convert(pose.to_dict(), PoseMessage)


def _lamp(place: Floats, pose: Pose) -> str:
    """A spotlight beside the camera, aimed at the target."""
    strength = LAMP_RADIANCE * float(np.linalg.norm(pose.translation - place)) ** 2
    return povray.spotlight(place, pose.translation, strength, BEAM_DEG)


def _look(size: float, rng: np.random.Generator) -> str:
    """A painted or crinkled skin whose pattern is about `size` metres wide."""
    dark, light = sorted(rng.uniform(0.1, 0.95, 2))
    if light - dark > MOST_CONTRAST:
        dark = light - MOST_CONTRAST
    scale = povray.MM * size * rng.uniform(0.08, 0.4)
    turn = ", ".join(f"{angle:.0f}" for angle in rng.uniform(0, 360, 3))
    bumps = f" normal {{ bumps {rng.uniform(0, 0.15):.3f} scale {scale / 4:.4g} }}"
    return (
        f"pigment {{ {rng.choice(SKINS)} color_map {{ [0 rgb {dark:.3f}] [1 rgb {light:.3f}] }}"
        f" scale {scale:.4g} rotate <{turn}> }}{bumps}"
        f" finish {{ ambient 0 emission 0 diffuse 0.85 specular {rng.uniform(0, 0.35):.3f}"
        f" roughness {rng.uniform(0.01, 0.08):.3f} }}"
    )


def _target(model: Model, pose: Pose, rng: np.random.Generator) -> list[str]:
    """The target; patches that no sharp edge bounds have one skin, and some share it."""
    corners, first = pose.apply(model.vertices)[model.triangles], of_faces(model)[model.triangle_face]
    skins = [_look(model.diameter, rng) for _ in range(MOST_SKINS)]
    drawn = rng.integers(len(skins), size=len(model.faces))
    return [povray.mesh(corners[first == face], skins[drawn[face]]) for face in np.unique(first)]


def _hard(kind: str, model: Model, pose: Pose, sun: Floats, rng: np.random.Generator) -> list[str]:
    """What stands around the target in a hard scene."""
    things: list[str] = []
    if kind in "AEN":
        things.append(hard_scenes.lines_behind(model, pose, rng))
    elif rng.random() < WALLS:
        things += _behind(model, pose, rng)
    if kind in "CE":
        things.append(hard_scenes.arm(model, pose, _look(model.diameter, rng), rng))
    if kind in "BE":
        things += hard_scenes.shadowing(model, pose, sun, _look(model.diameter, rng), rng)
    return things


def _behind(model: Model, pose: Pose, rng: np.random.Generator) -> list[str]:
    """A wall behind the target and boxes beside it."""
    size = povray.MM * model.diameter
    depth = povray.MM * pose.translation[2]
    tilt = ", ".join(f"{angle:.1f}" for angle in rng.uniform(-25, 25, 2))
    things = [
        f"plane {{ <0, 0, -1>, 0 {_look(model.diameter, rng)} rotate <{tilt}, 0>"
        f" translate <0, 0, {depth + rng.uniform(0.9, 1.6) * size:.4g}> }}"
    ]
    for _ in range(rng.integers(1, 4)):
        side = rng.uniform(0.08, 0.2) * size
        angle = rng.uniform(-math.pi, math.pi)
        away = rng.uniform(0.6, 0.8) * size
        turn = ", ".join(f"{angle:.0f}" for angle in rng.uniform(0, 360, 3))
        things.append(
            f"box {{ <-1, -1, -1>, <1, 1, 1> scale {side / 2:.4g} rotate <{turn}>"
            f" {_look(side / povray.MM, rng)}"
            f" translate <{away * math.cos(angle):.4g}, {away * math.sin(angle):.4g},"
            f" {depth + rng.uniform(0, 0.6) * size:.4g}> }}"
        )
    return things


def main(
    out: Annotated[Path, typer.Argument(help="Folder for the stacks.")],
    models: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="MODEL",
            help="Targets by name, model files (metres), parts that are drawn, or docking gear.",
        ),
    ] = None,
    count: Annotated[int, typer.Option(min=1, help="Stacks of each model.")] = 6,
    seed: Annotated[int, typer.Option(min=0)] = 1,
    hard: Annotated[bool, typer.Option("--hard", help="Scenes that hurt.")] = False,
    off: Annotated[
        float, typer.Option(min=0.0, max=0.2, help="By this share the part is longer than its model.")
    ] = 0.0,
) -> None:
    """Render light stacks of scenes no one has seen."""
    if not povray.available():
        print(
            "povray is not installed (Debian: apt-get install povray); nothing was rendered.", file=sys.stderr
        )
        raise typer.Exit(2)
    for name in models or TARGETS:
        for number in range(1, count + 1):
            with tempfile.TemporaryDirectory() as scratch:
                file = part_file(name, Path(scratch), np.random.default_rng([seed, number]))
                folder = out / f"{file.stem}-{number}"
                drawn_stack(file, number, seed, folder, hard, off)
            print(folder, flush=True)


if __name__ == "__main__":
    typer.run(main)
