"""Would poses be found more often if it were known of each edge what it is? By the truth and by what is told.

    .venv/bin/python -m benchmarks.kind_oracle [--stacks DIR] [--drawn 6] [--starts 2]

Three images of one light each: of the stacks of a folder, and of scenes that are drawn, textured targets
before a wall or boxes with a pattern. Edges are left out of the segments that are matched, or of the edge
points that refinement and trust look at, or of both: all that are of no visible line of the model at the true
pose, which is more than any knowledge of kinds could tell; and those that `kinds.kinds` takes for shadows and
highlights, or for prints as well. One JSON object a way: how many estimates are right, tight, right and
trusted, and what was gained and lost, with a 95 % interval by resampling scenes.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest.mock import patch

import msgspec
import numpy as np
from scipy.spatial import cKDTree

from benchmarks.ablation import RANGE, TRUSTED, Scene, interval, judged, stack_scenes
from benchmarks.drawn_parts import PARTS, part_file
from benchmarks.edge_segments import ONE_LIGHT_EACH, TARGETS, exposed
from geometry.pose import disturbed
from geometry.visibility import visible_samples
from image_server.simulator.material import MaterialChanges, Texture
from image_server.simulator.scenario import load_scenario, with_conditions
from image_server.simulator.scenario_tables import Background, Scenario
from image_server.simulator.simulator import Simulator
from numerics.arrays import Flags, Floats
from vision_server.channels.gradients import Normals
from vision_server.channels.tone import KNOWN_TONE_SD_PX
from vision_server.image_set import ImageSet
from vision_server.kinds.kinds import EdgeKinds, edge_kinds
from vision_server.kinds.likelihoods import HIGHLIGHT, PRINT, SHADOW
from vision_server.pipeline import PipelineSettings, pose_of_segments
from vision_server.pose import line_scales, observation
from vision_server.pose.edge_points import EdgePoints, search
from vision_server.segments.extraction import extract_segments
from vision_server.trust import hypotheses

Search = Callable[[Any, Any, Normals], EdgePoints]

TURN_PX = 5.0  # an edge that is turned by 90 degrees counts as twice so far away
TRUE_PX, SAME_PX = 2.5, 2.0  # from a line of the model; from the edgel that an edge point or segment is of
SURE = 0.7  # probability of the kinds that are left out
SPACING_PX = 0.7
PATTERNS: tuple[Texture, ...] = ("veins", "panels", "lines", "checker")
SUNS = (0.0, 1.0, 8.0)
BLUR_PX, MOTION_PX_PER_S = 3.0, (160.0, 110.0)  # of every second drawn scene
PLAIN = 'front = [0.0, 0.0, 1.0]\n[material]\ntexture = "plain"\nalbedo = 0.5\n'


@dataclass(frozen=True, eq=False)
class Known:
    """Oriented points of which it is known whether they are kept.

    Attributes
    ----------
    tree : of `features`.
    kept : (N,), of each.
    reach_px : what is farther from all of them ...
    otherwise : ... is kept, or not.
    """

    tree: cKDTree
    kept: Flags
    reach_px: float
    otherwise: bool

    def keeps(self, points: Floats, normals: Floats) -> Flags:
        """Which of some oriented points (M, 2), (M, 2) are kept."""
        away, nearest = self.tree.query(features(points, normals), distance_upper_bound=self.reach_px)
        near = np.isfinite(away)
        return np.asarray(np.where(near, self.kept[np.where(near, nearest, 0)], self.otherwise), np.bool_)

    def segments(self, ends: Floats) -> Flags:
        """Which segments (M, 4) are kept by more than half of their length."""
        out = np.zeros(len(ends), np.bool_)
        for number, (x0, y0, x1, y1) in enumerate(ends):
            length = max(float(np.hypot(x1 - x0, y1 - y0)), 1e-9)
            t = np.arange(0.5, max(length, 1.0)) / length
            points = np.array([x0, y0]) + t[:, None] * [x1 - x0, y1 - y0]
            normal = np.array([y0 - y1, x1 - x0]) / length
            out[number] = self.keeps(points, np.tile(normal, (len(t), 1))).mean() > 0.5
        return out

    def search(self, channels: Any, scale: Any, normals: Normals) -> EdgePoints:
        """`edge_points.search` without the edge points that are not kept."""
        found = search(channels, scale, normals)
        there = np.isfinite(found.offset)
        normal = np.broadcast_to(normals.normal[None, :, None], (*there.shape, 2))[there]
        image = np.broadcast_to(normals.image[None, :, None], (*there.shape, 2))[there]
        lost = there.copy()
        lost[there] = ~self.keeps(image + found.offset[there][:, None] * normal, normal)
        found.offset[lost], found.snr[lost] = np.nan, 0.0
        return found


def features(points: Floats, normals: Floats) -> Floats:
    """Places (N, 4) that are near each other where oriented points are and run alike."""
    angle = 2.0 * np.arctan2(normals[:, 1], normals[:, 0])
    return np.column_stack([points, TURN_PX * np.cos(angle), TURN_PX * np.sin(angle)])


def of_truth(scene: Scene) -> Known:
    """All that lies on visible lines of the model at the true pose."""
    samples = visible_samples(scene.model, scene.camera, scene.true[0], SPACING_PX)
    known = features(samples.image, samples.normal)
    return Known(cKDTree(known), np.ones(len(known), np.bool_), TRUE_PX, otherwise=False)


def of_kinds(kinds: EdgeKinds, out: Sequence[int]) -> Known:
    """All but what is told to be of some kinds."""
    edges = kinds.edges
    known = features(edges.points.astype(np.float64), edges.normals.astype(np.float64))
    kept = kinds.probability[list(out)].sum(axis=0) < SURE
    return Known(cKDTree(known), np.asarray(kept), SAME_PX, otherwise=True)


def ways(scene: Scene, ends: Floats) -> Iterator[tuple[str, Floats, Search]]:
    """Name, segments and search of each way to leave edges out."""
    true = of_truth(scene)
    kinds = edge_kinds([image.statistics for image in scene.images.images.values()])
    light, surface = of_kinds(kinds, (SHADOW, HIGHLIGHT)), of_kinds(kinds, (SHADOW, HIGHLIGHT, PRINT))
    yield "all edges", ends, search
    yield "segments of the model", ends[true.segments(ends)], search
    yield "edge points of the model", ends, true.search
    yield "both of the model", ends[true.segments(ends)], true.search
    yield "no shadows, no highlights", ends[light.segments(ends)], light.search
    yield "nor prints", ends[surface.segments(ends)], surface.search


def run(scene: Scene, starts: int) -> Iterator[dict[str, Any]]:
    """All ways and starts on one scene."""
    names = list(scene.images.images)
    ends = extract_segments(scene.images.edge_map(names)).endpoints
    rng = np.random.default_rng(sum(map(ord, scene.name)))
    seeds = [
        disturbed(
            scene.true[0], rng, RANGE.rotation_deg, RANGE.translation_px, scene.camera.fx, scene.model.middle
        )
        for _ in range(starts)
    ]
    for way, kept, looked in ways(scene, ends):
        with ExitStack() as patches:
            for module in (observation, hypotheses, line_scales):
                patches.enter_context(patch.object(module, "search", looked))
            for number, seed in enumerate(seeds):
                found = pose_of_segments(
                    kept, scene.images.gradients(names), scene.model, scene.camera, seed,
                    PipelineSettings(seed=number, tone_sd_px=scene.tone_sd_px),
                )  # fmt: skip
                right, tight, _ = judged(scene, found.pose)
                trusted = right and found.score >= TRUSTED
                yield {"scene": scene.name, "group": scene.group, "way": way} | {
                    "right": right, "tight": tight, "trusted": trusted,
                }  # fmt: skip


def drawn_conditions(rng: np.random.Generator) -> Scenario:
    """A textured target before a patterned wall, alone or among boxes, under some sun, sharp or blurred."""
    blurred = bool(rng.random() < 0.5)
    scenario = with_conditions(
        load_scenario("nominal"),
        float(rng.choice(SUNS)),
        defocus_sigma_px=BLUR_PX if blurred else 0.0,
        motion_px_per_s=MOTION_PX_PER_S if blurred else (0.0, 0.0),
    )
    target, wall = (
        MaterialChanges(
            texture=PATTERNS[rng.integers(first, len(PATTERNS))],
            size_m=float(rng.uniform(*size_m)),
            contrast=float(rng.uniform(0.3, 0.8)),
        )
        for first, size_m in ((0, (0.012, 0.04)), (1, (0.03, 0.1)))
    )
    behind = Background(
        kind="wall" if rng.random() < 0.6 else "clutter",
        material=wall,
        distance_m=float(rng.uniform(0.02, 0.2)),
    )
    return msgspec.structs.replace(scenario, target=target, background=behind)


def drawn_scene(number: int) -> Scene:
    """One of the project's targets or a part drawn for it, in drawn conditions."""
    rng = np.random.default_rng([number, 77])
    name = (*TARGETS, *PARTS)[number % (len(TARGETS) + len(PARTS))]
    with tempfile.TemporaryDirectory() as folder:
        file = part_file(name, Path(folder), rng)
        if name in PARTS:
            file.with_suffix(".toml").write_text(PLAIN)
        simulator = Simulator(file, drawn_conditions(rng), number)
        camera = simulator.camera
        images = ImageSet(camera.width, camera.height)
        for index, levels in enumerate(ONE_LIGHT_EACH):
            shot = exposed(simulator, levels)
            images.add(f"i{index}", shot.image, shot.exposure, 1.0)
    name = f"drawn {number}"
    return Scene("drawn", name, images, camera, simulator.model, (simulator.true_pose,), KNOWN_TONE_SD_PX)


def scenes(stacks: Path | None, drawn: int) -> Iterator[Scene]:
    """The set of one light each of every stack with a target, then drawn ones."""
    for table in sorted(stacks.glob("*/stack.toml")) if stacks is not None else ():
        yield next(stack_scenes(table.parent.parent.name, table.parent))
    yield from map(drawn_scene, range(drawn))


def summary(way: str, rows: list[dict[str, Any]], base: list[dict[str, Any]]) -> dict[str, Any]:
    """One way beside all edges, on the same scenes and starts in the same order."""
    out: dict[str, Any] = {"name": way, "group": rows[0]["group"], "trials": len(rows)}
    for key in ("right", "tight", "trusted"):
        change = np.array([float(a[key]) - float(b[key]) for a, b in zip(rows, base, strict=True)])
        out[key] = sum(row[key] for row in rows)
        out[f"{key}_gained_lost"] = [int((change > 0).sum()), int((change < 0).sum())]
        out[f"{key}_interval"] = interval([row["scene"] for row in rows], change)
    return out


def main() -> None:
    """Every scene, every way, every start; then one line for each group and way."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--stacks", type=Path, help="folder of light stacks with true poses")
    parser.add_argument("--drawn", type=int, default=6, help="drawn scenes (default: %(default)s)")
    parser.add_argument("--starts", type=int, default=2, help="starts of each scene (default: %(default)s)")
    options = parser.parse_args()
    rows = [row for scene in scenes(options.stacks, options.drawn) for row in run(scene, options.starts)]
    for group in dict.fromkeys(row["group"] for row in rows):
        for way in dict.fromkeys(row["way"] for row in rows):
            own, base = (
                [row for row in rows if (row["group"], row["way"]) == (group, name)]
                for name in (way, "all edges")
            )
            print(json.dumps(summary(way, own, base)), flush=True)


if __name__ == "__main__":
    main()
