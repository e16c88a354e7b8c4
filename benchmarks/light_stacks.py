"""Where merging images wins, and where not: recorded light stacks under four suns, from poor starts.

    .venv/bin/python -m benchmarks.light_stacks STACK ... [--starts 8] [--suns 0,1,8,20] [--out DIR]

For each basis stack with a true pose, each sun and each way to photograph it (`WAYS`), the pose is estimated
from so many starts within 25 degrees and 40 px. One JSON object per way and sun: share right at 1 degree and
1 % of the range and at 0.2 degrees and 0.2 %, median errors, and how many wrong poses have a score of at
least TRUSTED. With `--out`, the worst cases are drawn: the model at the estimate over the image, or over the
brightest values of several.
"""

from __future__ import annotations

import json
import os
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import cv2
import numpy as np
import typer

from benchmarks.photographs import Photograph, Studio, image_set, stack_studio
from geometry.pose import Pose, disturbed
from report.overlay import draw_overlay
from vision_server.image_set import ImageSet
from vision_server.matching import SearchRange
from vision_server.pipeline import PipelineSettings, estimate_pose, pose_of_segments
from vision_server.segments.extraction import extract_segments
from vision_server.trust.judgement import Estimate

WAYS = ("middle", "best single", "three merged", "three united", "bracket merged")
RANGE = SearchRange()
LOOSE, TIGHT = (1.0, 0.01), (0.2, 0.002)  # degrees, share of the range
TRUSTED = 0.8


@dataclass(frozen=True)
class Case:
    """One stack under one sun."""

    folder: Path
    sun: float
    starts: int


def frames(studio: Studio) -> dict[str, list[Photograph]]:
    """What each way photographs; of the single images, all that may turn out best."""
    described = studio.device.describe()
    lights = [studio.full(only) for only in range(len(described.lights))]
    alone = [studio.photograph(levels) for levels in lights]
    shutters = sorted(described.shutters_s)
    bracket = [studio.photograph(studio.middle, shutter_s=shutter) for shutter in shutters]
    middle = studio.photograph(studio.middle)
    return {
        "middle": [middle],
        "best single": [middle, *alone, *bracket],
        "three merged": alone,
        "three united": alone,
        "bracket merged": bracket[:: max(1, len(bracket) // 2)],
    }


def estimated(way: str, images: ImageSet, shot: Photograph, start: Pose, number: int) -> Estimate:
    """The pose from a set, its images merged into one edge map or their segments united."""
    names, settings = list(images.images), PipelineSettings(seed=number)
    if way != "three united":
        return estimate_pose(images, names, shot.model, shot.camera, start, settings)
    segments = [extract_segments(images.edge_map([name])).endpoints for name in names]
    channels = images.gradients(names)
    return pose_of_segments(np.concatenate(segments), channels, shot.model, shot.camera, start, settings)


def run_case(case: Case) -> list[dict[str, Any]]:
    """All ways and starts of one stack under one sun."""
    studio = stack_studio(case.folder, case.sun)
    rng = np.random.default_rng([int(case.sun), sum(map(ord, case.folder.name))])
    starts = [
        disturbed(
            studio.true, rng, RANGE.rotation_deg, RANGE.translation_px, studio.camera.fx, studio.model.middle
        )
        for _ in range(case.starts)
    ]
    rows = []
    for way, candidates in frames(studio).items():
        shots = candidates
        if way == "best single":  # the one with the best score, which needs no truth
            tried = [estimated(way, image_set([shot]), shot, starts[0], 0).score for shot in candidates]
            shots = [candidates[int(np.argmax(tried))]]
        images = image_set(shots)
        for number, start in enumerate(starts):
            found = estimated(way, images, shots[0], start, number)
            row: dict[str, Any] = {"stack": case.folder.name, "sun": case.sun, "way": way, "start": number}
            row |= {"score": found.score, "rms_px": found.rms_px, "right": False, "tight": False}
            if found.pose is not None:
                error = found.pose.error_to(studio.true)
                row |= {"right": error.within(*LOOSE), "tight": error.within(*TIGHT)}
                row |= {"rotation_deg": error.rotation_deg}
                row |= {"share_of_range": error.translation_fraction_of_range}
                row |= {"pose": found.pose.to_dict()}
                row |= {"support": {line.line: line.support for line in found.lines}}
            rows.append(row)
    return rows


def badness(row: dict[str, Any]) -> float:
    """How far off an estimate is, in units of the loose limits; no pose comes first."""
    if "pose" not in row:
        return np.inf
    return float(max(row["rotation_deg"] / LOOSE[0], row["share_of_range"] / LOOSE[1]))


def draw_worst(rows: list[dict[str, Any]], folders: list[Path], count: int, out: Path) -> None:
    """One picture for each of the worst cases, a stack, sun and way only once."""
    out.mkdir(parents=True, exist_ok=True)
    drawn: set[tuple[str, float, str]] = set()
    for row in sorted(rows, key=badness, reverse=True):
        key = (row["stack"], row["sun"], row["way"])
        if len(drawn) == count:
            return
        if key in drawn:
            continue
        drawn.add(key)
        folder = next(folder for folder in folders if folder.name == row["stack"])
        studio = stack_studio(folder, row["sun"])
        shots = frames(studio)[row["way"]]
        brightest = (
            shots[0].pixels if row["way"] == "middle" else np.maximum.reduce([s.pixels for s in shots])
        )
        pose = Pose.from_dict(row["pose"]) if "pose" in row else None
        support = {int(line): share for line, share in row.get("support", {}).items()}
        picture = draw_overlay(brightest, studio.model, studio.camera, pose, support)
        name = f"{len(drawn):02d}-{row['stack']}-sun{row['sun']:g}-{row['way'].replace(' ', '-')}.png"
        cv2.imwrite(str(out / name), picture)
        said = {k: row.get(k) for k in ("stack", "sun", "way", "start", "score", "rms_px", "rotation_deg")}
        print(json.dumps({"picture": name, **said, "share_of_range": row.get("share_of_range")}), flush=True)


def summary(way: str, sun: float, rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Shares and medians of one way under one sun."""
    found = [row for row in rows if "pose" in row]
    out: dict[str, Any] = {"name": f"{way}, sun {sun:g}", "trials": len(rows), "unit": "share right"}
    out["value"] = round(sum(row["right"] for row in rows) / len(rows), 3)
    out["tight"] = round(sum(row["tight"] for row in rows) / len(rows), 3)
    for key in ("rotation_deg", "share_of_range"):
        out[f"median_{key}"] = round(float(np.median([row[key] for row in found] or [np.nan])), 5)
    out["no_pose"] = len(rows) - len(found)
    out["wrong_trusted"] = sum(not row["right"] and row["score"] >= TRUSTED for row in found)
    return out


def main(
    folders: list[Path],
    starts: Annotated[int, typer.Option(min=1)] = 8,
    suns: Annotated[str, typer.Option(help="Factors of the ambient image.")] = "0,1,8,20",
    worst: Annotated[int, typer.Option(min=0, help="Cases to draw.")] = 10,
    out: Annotated[Path | None, typer.Option(help="Folder for their pictures.")] = None,
) -> None:
    """Run all stacks under all suns on all cores."""
    strengths = [float(part) for part in suns.split(",")]
    folders = [folder.resolve() for folder in folders]
    for folder in folders:
        if not (folder / "stack.toml").is_file():
            raise typer.BadParameter(f"{folder} is no stack: it has no stack.toml")
    rows: list[dict[str, Any]] = []
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        for part in pool.map(run_case, [Case(f, sun, starts) for sun in strengths for f in folders]):
            rows += part
    for sun in strengths:
        for way in WAYS:
            print(json.dumps(summary(way, sun, [r for r in rows if (r["way"], r["sun"]) == (way, sun)])))
    if out is not None:
        draw_worst(rows, folders, worst, out)


if __name__ == "__main__":
    typer.run(main)
