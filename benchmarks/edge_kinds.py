"""Kinds of edges against the simulator's truth: precision-recall of each, and what is taken for what.

    .venv/bin/python -m benchmarks.edge_kinds [--parts 3] [--seeds 2] [--first 0] [--levels] [--alone 0]
        [--picture OUT.png]

Three lights, one at a time and all together, and a sun that is always there; or N lamps on a ring, each alone
beside it; targets of the project, and parts drawn at random. True outlines, creases and ends of shadows are
by the ray tracer's faces and distances and by what each light alone reaches; only what steps by STEP_GREY in
some image counts.
"""

from __future__ import annotations

import argparse
import math
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import cv2
import msgspec
import numpy as np
from numpy.typing import NDArray

from benchmarks.lines import show
from benchmarks.synthetic_parts import random_part
from bridge.messages import Settings
from geometry.surface import Surface
from image_server.simulator.material import load_appearance
from image_server.simulator.rays import NOTHING, Caster, pixel_rays
from image_server.simulator.scenario import load_scenario
from image_server.simulator.scenario_tables import Light, Scenario
from image_server.simulator.scene import joined, target_part
from image_server.simulator.simulator import Simulator
from numerics.arrays import Field, Flags, Floats, Grey
from stack.exposure import relative_exposure
from vision_server.channels.channel import channel_statistics
from vision_server.edges.suppression import edge_picture
from vision_server.kinds.kinds import EdgeKinds, edge_kinds
from vision_server.kinds.kinds_table import kinds_picture
from vision_server.kinds.likelihoods import CREASE, FIXED, KINDS, NOISE, OUTLINE, SHADOW

Places = tuple[slice, slice]

TARGETS = ("cube", "fixture", "satellite")
PICTURED = "fixture"
LEVELS = ((7, 0, 0), (0, 7, 0), (0, 0, 7), (4, 4, 4))
FULL, RING_M = 7, 0.35  # of lamps that are alone: their level, and how far they are from the camera
SHUTTER_S, APERTURE = 1 / 60, 4.0
PART_LINES = 60
JUMP = 0.004  # of the distance, from what the face's plane has at the next pixel: another surface
FLAT = 0.999  # cosine between the normals of faces that are one
STEP_GREY = 10.0  # between the extremes of 3 x 3 px, without noise: less is hardly seen
UNLIT = 1e-6  # radiance that no lit surface has
TOLERANCE_PX = 2.0
APART_PX = 4.0  # edges of two kinds nearer to each other say nothing of confusion
JUDGED = (OUTLINE, CREASE, SHADOW)


class Truth(NamedTuple):
    """Pixels (H, W) beside true outlines, creases and ends of shadows."""

    outline: Flags
    crease: Flags
    shadow: Flags


def between(differs: Flags, down: Flags) -> Flags:
    """Pixels on either side of a difference to the next column (H, W - 1) or row (H - 1, W)."""
    out = np.zeros((len(differs), down.shape[1]), np.bool_)
    out[:, :-1] |= differs
    out[:, 1:] |= differs
    out[:-1] |= down
    out[1:] |= down
    return out


def truth_of(simulator: Simulator, sun: Field) -> Truth:
    """True edges of the scene, from faces, distances, and the images of each lamp and of the sun alone."""
    camera, model = simulator.camera, simulator.model
    scenario = load_scenario("nominal")
    appearance = load_appearance(simulator.model_file, len(model.faces))
    scene = joined([target_part(model, appearance, scenario.target, simulator.true_pose)])
    rows, columns = np.arange(camera.height), np.arange(camera.width)
    rays = pixel_rays(camera, rows, columns)
    triangle, distance = Caster(scene.triangles).first_hits(rays)
    shape = (camera.height, camera.width)
    hit = triangle != NOTHING
    face = np.where(hit, scene.face[triangle], -1).reshape(shape)
    normal = np.where(hit[:, None], scene.normals[triangle], 0.0).reshape(*shape, 3)
    point = np.where(hit[:, None], rays * distance[:, None], 0.0).reshape(*shape, 3)
    alone = [*simulator.basis()[:-1], sun]

    def compared(here: Places, there: Places) -> tuple[Flags, Flags, Flags]:
        empty = (face[here] < 0) | (face[there] < 0)
        flat = np.sum(normal[here] * normal[there], axis=-1) > FLAT
        other = face[here] != face[there]
        gap = np.minimum(
            _gap(normal[here], point[here], point[there]), _gap(normal[there], point[there], point[here])
        )
        outline = other & (empty | (gap > JUMP))
        shadow = np.zeros_like(other)
        for light in alone:
            shadow |= (light[here] > UNLIT) != (light[there] > UNLIT)
        return outline, other & ~outline & ~flat, shadow & ~outline & (flat | ~other)

    whole, first, last = slice(None), slice(None, -1), slice(1, None)
    across, down = compared((whole, first), (whole, last)), compared((first, whole), (last, whole))
    outline, crease, shadow = (between(*pair) for pair in zip(across, down, strict=True))
    # a pixel beside a contour is of both sides, lit and not: near one there are no shadows to be told
    apart = cv2.distanceTransform((~(outline | crease)).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return Truth(outline, crease & ~outline, shadow & (apart > TOLERANCE_PX))


def _gap(normal: Floats, point: Floats, other: Floats) -> Floats:
    """How far another point is from a face's plane along its line of sight, as a share of its distance."""
    along = np.sum(normal * other, axis=-1)
    return np.asarray(np.abs(np.sum(normal * point, axis=-1) / np.where(along == 0.0, np.inf, along) - 1.0))


class Scene(NamedTuple):
    """Images of one scene with their exposures, and its true edges that can be seen."""

    name: str
    images: list[Grey]
    exposure: float
    truth: Truth


def lamps_alone(count: int) -> Scenario:
    """The nominal scenario with lamps on a ring around the camera."""
    angles = 2.0 * np.pi * np.arange(count) / count
    lights = tuple(
        Light(name=f"lamp {number}", position=(RING_M * math.cos(angle), RING_M * math.sin(angle), 0.0))
        for number, angle in enumerate(angles.tolist())
    )
    return msgspec.structs.replace(load_scenario("nominal"), lights=lights)


def sun_alone(target: str | Path, scenario: Scenario, seed: int) -> Field:
    """Radiance (H, W) of a scene by its sun, without what the Earth sends back."""
    sun = msgspec.structs.replace(scenario.sun, earthshine=0.0)
    alone = msgspec.structs.replace(scenario, sun=sun, lights=scenario.lights[:1])
    return Simulator(target, alone, seed).basis()[-1]


def simulated(name: str, target: str | Path, seed: int, alone: int = 0) -> Scene:
    """Three lights, each alone and all together; or so many, each alone."""
    scenario = lamps_alone(alone) if alone else load_scenario("nominal")
    simulator = Simulator(target, scenario, seed)
    images, seen = [], np.zeros((simulator.camera.height, simulator.camera.width), np.bool_)
    exposure = relative_exposure(SHUTTER_S, APERTURE)
    square = np.ones((3, 3), np.uint8)
    for levels in levels_of(alone):
        settings = Settings(lights=levels, shutter_s=SHUTTER_S, aperture=APERTURE)
        images.append(np.asarray(simulator.capture(settings).pixels))
        clean = np.minimum(255.0 * exposure * simulator.radiance(levels), 255.0).astype(np.float32)
        seen |= cv2.dilate(clean, square) - cv2.erode(clean, square) >= STEP_GREY
    truth = truth_of(simulator, sun_alone(target, scenario, seed))
    return Scene(name, images, 1.0, Truth(*(edge & seen for edge in truth)))


def levels_of(alone: int) -> tuple[tuple[int, ...], ...]:
    """How far each light is on, a row for each image."""
    if not alone:
        return LEVELS
    return tuple(tuple(FULL * (lamp == image) for lamp in range(alone)) for image in range(alone))


def scenes(parts: int, seeds: int, first: int = 0, alone: int = 0) -> Iterator[Scene]:
    """Targets of the project, and random parts, from the ``first`` draws on; ``alone`` as `simulated`."""
    for target in TARGETS:
        for seed in range(first, first + seeds):
            yield simulated(target, target, seed + 1, alone)
    with tempfile.TemporaryDirectory() as folder:
        for number in range(first, first + parts):
            file = Path(folder) / f"part-{number}.obj"
            file.write_text(_obj(random_part(np.random.default_rng(number), PART_LINES)))
            file.with_suffix(".toml").write_text(
                'front = [0.0, 0.0, 1.0]\n[material]\ntexture = "plain"\nalbedo = 0.5\n'
            )
            yield simulated("part", file, number + 1, alone)


def _obj(surface: Surface) -> str:
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in surface.vertices]
    lines += ["f " + " ".join(str(corner + 1) for corner in face) for face in surface.faces]
    return "\n".join(lines) + "\n"


def near(edge: Flags, points: NDArray[np.int32], reach: float) -> Flags:
    """Which pixels (N, 2), row and column, are within reach of an edge."""
    away = cv2.distanceTransform((~edge).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return np.asarray(away[points[:, 0], points[:, 1]] <= reach)


class Found(NamedTuple):
    """Of one scene and kind: rank of each edgel, whether it is true, at which rank true pixels are found."""

    rank: Floats
    true: Flags
    found_at: Floats


def found(kinds: EdgeKinds, truth: Flags, kind: int) -> Found:
    """Edgels ranked by the probability of a kind, against its truth."""
    edges, rank = kinds.edges, kinds.probability[kind]
    points = np.stack(np.divmod(edges.places, edges.shape[1]), axis=1)
    best = np.zeros(edges.shape, np.float32)
    best.ravel()[edges.places] = rank
    reach = int(TOLERANCE_PX)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
    return Found(
        rank, near(truth, points, TOLERANCE_PX), np.asarray(cv2.dilate(best, disc))[truth].astype(np.float64)
    )


def curve(results: Sequence[Found]) -> tuple[Floats, Floats, float]:
    """Precision and recall over all ranks, and the area under them."""
    rank, true, found_at = (np.concatenate(parts) for parts in zip(*results, strict=True))
    thresholds = np.unique(np.quantile(np.concatenate([rank, found_at]), np.linspace(0.0, 1.0, 400)))[::-1]
    recall = np.array([np.mean(found_at >= t) for t in thresholds])
    precision = np.array([np.mean(true[rank >= t]) if (rank >= t).any() else 1.0 for t in thresholds])
    area = float(np.trapezoid(np.r_[precision[0], precision], np.r_[0.0, recall]))
    return precision, recall, area


def confusion(kinds: EdgeKinds, truth: Truth) -> tuple[Flags, Flags]:
    """Of shadow edges, which are taken for contour; of contours, which for shadow; noise left out."""
    points = np.stack(np.divmod(kinds.edges.places, kinds.edges.shape[1]), axis=1)
    contour = truth.outline | truth.crease
    by_contour, by_shadow = near(contour, points, APART_PX), near(truth.shadow, points, APART_PX)
    kind = np.argmax(kinds.probability, axis=0)
    at_contour, at_shadow = near(contour, points, TOLERANCE_PX), near(truth.shadow, points, TOLERANCE_PX)
    seen = kind != NOISE
    return (
        np.isin(kind, (OUTLINE, CREASE))[at_shadow & ~by_contour & seen],
        (kind == SHADOW)[at_contour & ~by_shadow & seen],
    )


def pictured(scene: Scene, kinds: EdgeKinds) -> Grey:
    """Four images of a scene, its edges in the colours of their kinds, and those that are the scene's."""
    images = [cv2.cvtColor(image, cv2.COLOR_GRAY2BGR) for image in scene.images]
    contour = cv2.cvtColor(edge_picture(kinds.of_kinds(FIXED)), cv2.COLOR_GRAY2BGR)
    rows = ([*images[:2], kinds_picture(kinds)], [*images[2:], contour])
    return np.asarray(np.vstack([np.hstack(row) for row in rows]), np.uint8)


def main() -> None:
    """Measure, and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--parts", type=int, default=3, help="random parts (default: %(default)s)")
    parser.add_argument("--seeds", type=int, default=2, help="views of each target (default: %(default)s)")
    parser.add_argument(
        "--first", type=int, default=0, help="draws that are left out before (default: %(default)s)"
    )
    parser.add_argument("--levels", action="store_true", help="say what the lights' levels were")
    parser.add_argument(
        "--alone", type=int, default=0, metavar="N", help="N lamps on a ring, an image of each; else three"
    )
    parser.add_argument("--picture", type=Path, help="draw a scene, its kinds and its contour into this file")
    options = parser.parse_args()
    results: dict[int, list[Found]] = {kind: [] for kind in JUDGED}
    taken: list[Flags] = []
    lost: list[Flags] = []
    levels = np.array(levels_of(options.alone)) / FULL if options.levels else None
    for scene in scenes(options.parts, options.seeds, options.first, options.alone):
        channels = [channel_statistics(image, scene.exposure) for image in scene.images]
        kinds = edge_kinds(channels, levels)
        if options.picture is not None and scene.name == PICTURED:
            cv2.imwrite(str(options.picture), pictured(scene, kinds))
        for kind, truth in zip(JUDGED, scene.truth, strict=True):
            results[kind].append(found(kinds, truth, kind))
        for all_of, some in zip((taken, lost), confusion(kinds, scene.truth), strict=True):
            all_of.append(some)
    for kind, of_kind in results.items():
        show(
            f"edge kinds/{KINDS[kind]}: average precision",
            curve(of_kind)[2],
            "1",
            edges_px=sum(len(f.found_at) for f in of_kind),
        )
    show("edge kinds/shadow taken for contour", float(np.mean(np.concatenate(taken))), "1")
    show("edge kinds/contour taken for shadow", float(np.mean(np.concatenate(lost))), "1")


if __name__ == "__main__":
    main()
