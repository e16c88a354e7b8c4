"""`python -m vision_server estimate`: the pose of a target from image files."""

from __future__ import annotations

import json
import math
import sys
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from bridge.errors import EXIT_BAD_INPUT, BadInput, LightsAndCameraError

EXIT_NO_POSE = 3


class Matcher(StrEnum):
    """How the pose is found before it is refined."""

    SEARCH = "search"
    GENETIC = "genetic"


def _estimated(
    images: list[Path],
    model_file: Path,
    camera_file: Path,
    seed_pose_file: Path,
    exposures: str | None,
    matcher: Matcher,
    seed: int,
    unit: str,
    gamma: float | None,
) -> dict[str, Any]:
    from geometry.errors import GeometryError
    from vision_server.commands.edges import parse_exposures
    from vision_server.image_files import read_image_set
    from vision_server.image_set import ImageSet
    from vision_server.pipeline import PipelineSettings, estimate_pose
    from vision_server.results import estimate_result
    from vision_server.session_inputs import read_camera, read_model, read_seed_pose
    from vision_server.tone import file_tone

    camera, table = read_camera(camera_file)
    model, seed_pose = read_model(model_file, unit), read_seed_pose(seed_pose_file)
    pixels = read_image_set(images)
    times = parse_exposures(exposures, len(pixels))
    given = table.get("gamma") if gamma is None else gamma
    if given is not None and not (isinstance(given, (int, float)) and 0.0 < given < math.inf):
        raise BadInput(f"The value of gamma must be a positive number, not {given!r}.")
    gammas, tone_sd_px = file_tone(images, None if given is None else float(given))
    settings = PipelineSettings(matcher=matcher.value, seed=seed, tone_sd_px=tone_sd_px)
    image_set = ImageSet(camera.width, camera.height)
    names = []
    for number, (grey, exposure, curve) in enumerate(zip(pixels, times, gammas, strict=True), start=1):
        names.append(f"i{number}")
        image_set.add(names[-1], grey, exposure, curve)
    try:
        estimate = estimate_pose(image_set, names, model, camera, seed_pose, settings)
    except GeometryError as error:
        raise BadInput(str(error)) from error
    result = estimate_result(estimate)
    result["seconds"]["total"] = sum(result["seconds"].values())
    files = dict(zip(names, map(str, images), strict=True))
    return {"target": model.name, "seed": seed, "kept": names, "files": files, **result}


def _print(result: dict[str, Any]) -> None:
    from rich.console import Console
    from rich.table import Table

    console = Console()
    if result["pose"] is None:
        console.print(f"No pose of {result['target']}: nothing in the images supports one.")
        return
    pose = result["pose"]
    console.print(f"Pose of [bold]{result['target']}[/bold] (camera_T_target)")
    console.print(
        "  rotation vector  " + "  ".join(f"{value:+.6f}" for value in pose["rotation_vector"]) + "  rad"
    )
    console.print("  translation      " + "  ".join(f"{value:+.6f}" for value in pose["translation"]) + "  m")
    spread = [math.sqrt(max(row[i], 0.0)) for i, row in enumerate(result["covariance"])]
    console.print(
        "  sd of rotation   " + "  ".join(f"{math.degrees(value):.4f}" for value in spread[:3]) + "  deg"
    )
    console.print("  sd of shift      " + "  ".join(f"{1e3 * value:.4f}" for value in spread[3:]) + "  mm")
    console.print(
        f"  RMS {result['rms_px']:.2f} px, {100 * result['supported_fraction']:.0f} % of the visible lines "
        f"supported, score {result['score']:.2f}, ambiguity {result['ambiguity']:.2f}, "
        f"{result['segments']} segments"
    )
    table = Table("line", "visible px", "support", "RMS px", "image")
    for line in result["lines"]:
        table.add_row(
            str(line["line"]),
            f"{line['visible_px']:.0f}",
            f"{line['support']:.2f}",
            f"{line['rms_px']:.2f}",
            line["image"] or "-",
        )
    console.print(table)
    console.print(
        "  " + ", ".join(f"{stage} {1e3 * value:.0f} ms" for stage, value in result["seconds"].items())
    )


def estimate_command(
    images: Annotated[
        list[Path], typer.Argument(metavar="IMAGE...", help="Image files of one set, one size.")
    ],
    model: Annotated[Path, typer.Option(help="Model file: .cao, OBJ, STL or PLY.")],
    camera: Annotated[Path, typer.Option(metavar="TOML", help="File with [camera].")],
    seed_pose: Annotated[Path, typer.Option(metavar="TOML", help="File with [target.seed_pose].")],
    exposures: Annotated[
        str | None,
        typer.Option(metavar="E,...", help="Relative exposure of each image; 1 each when left out."),
    ] = None,
    matcher: Annotated[Matcher, typer.Option(help="How the pose is found.")] = Matcher.SEARCH,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the matcher's draws.")] = 0,
    as_json: Annotated[bool, typer.Option("--json", help="One JSON object on stdout.")] = False,
    unit: Annotated[str, typer.Option(help="Unit of the model file: m, cm, mm or in.")] = "m",
    gamma: Annotated[
        float | None,
        typer.Option(
            help="Tone curve to undo: linear = grey^gamma; else [camera] gamma, or what the files tell."
        ),
    ] = None,
) -> None:
    """Estimate the pose of a target from image files of one set.

    Exit status: 0 pose, 3 no pose, 2 bad input.
    """
    try:
        result = _estimated(images, model, camera, seed_pose, exposures, matcher, seed, unit, gamma)
    except LightsAndCameraError as error:
        print(f"vision_server: {error}", file=sys.stderr)
        raise typer.Exit(EXIT_BAD_INPUT) from None
    if as_json:
        print(json.dumps(result, allow_nan=False))
    else:
        _print(result)
    if result["pose"] is None:
        raise typer.Exit(EXIT_NO_POSE)
