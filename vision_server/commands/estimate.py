"""`python -m vision_server estimate`: the pose of a target from image files."""

from __future__ import annotations

import json
import math
import sys
from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import Any

from bridge.command_line import whole_number
from bridge.errors import EXIT_BAD_INPUT, BadInput, LightsAndCameraError
from bridge.messages import MATCHERS
from vision_server.commands.edges import add_exposures, parse_exposures

EXIT_NO_POSE = 3


def _estimated(options: Namespace) -> dict[str, Any]:
    from geometry.errors import GeometryError
    from vision_server.channels.image_files import read_image_set
    from vision_server.channels.tone import file_tone
    from vision_server.image_set import ImageSet
    from vision_server.pipeline import PipelineSettings, estimate_pose
    from vision_server.serve.inputs import read_camera, read_model, read_seed_pose, size_warning
    from vision_server.serve.results import estimate_result

    camera, table = read_camera(options.camera)
    model = read_model(options.model, options.unit)
    seed_pose = read_seed_pose(options.seed_pose, model)
    if (doubt := size_warning(model, camera, seed_pose)) is not None:
        print(f"vision_server: {doubt}", file=sys.stderr)
    pixels = read_image_set(options.images)
    times = parse_exposures(options.exposures, len(pixels))
    given = table.get("gamma") if options.gamma is None else options.gamma
    if given is not None and not (isinstance(given, (int, float)) and 0.0 < given < math.inf):
        raise BadInput(f"The value of gamma must be a positive number, not {given!r}.")
    gammas, tone_sd_px = file_tone(options.images, None if given is None else float(given))
    settings = PipelineSettings(matcher=options.matcher, seed=options.seed, tone_sd_px=tone_sd_px)
    image_set = ImageSet(camera.width, camera.height)
    names = []
    for number, (grey, exposure, curve) in enumerate(zip(pixels, times, gammas, strict=True), start=1):
        names.append(f"i{number}")
        image_set.add(names[-1], grey, exposure, curve)
    try:
        estimate = estimate_pose(image_set, names, model, camera, seed_pose, settings)
    except GeometryError as error:
        raise BadInput(str(error)) from error
    if options.overlay is not None:
        import cv2

        from report.overlay import draw_overlay

        support = {line.line: line.support for line in estimate.lines}
        drawn = draw_overlay(pixels[0], model, camera, estimate.pose, support)
        try:
            options.overlay.write_bytes(cv2.imencode(".png", drawn)[1].tobytes())
        except OSError as error:
            raise BadInput(f"Cannot write {options.overlay}: {error.strerror}.", "Check the path.") from error
    result = estimate_result(estimate)
    result["seconds"]["total"] = sum(result["seconds"].values())
    files = dict(zip(names, map(str, options.images), strict=True))
    return {"target": model.name, "seed": options.seed, "kept": names, "files": files, **result}


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


def add_options(parser: ArgumentParser) -> None:
    """Options of the command."""
    parser.description = f"{parser.description} Exit status: 0 pose, 3 no pose, 2 bad input."
    parser.add_argument(
        "images", metavar="IMAGE", nargs="+", type=Path, help="Image files of one set, one size."
    )
    parser.add_argument(
        "--model", required=True, type=Path, metavar="FILE", help="Model file: .cao, OBJ, STL or PLY."
    )
    parser.add_argument("--camera", required=True, type=Path, metavar="TOML", help="File with [camera].")
    parser.add_argument(
        "--seed-pose", required=True, type=Path, metavar="TOML", help="File with [target.seed_pose]."
    )
    add_exposures(parser)
    parser.add_argument(
        "--matcher",
        choices=MATCHERS,
        default="search",
        help="How the pose is found before it is refined (default: %(default)s).",
    )
    parser.add_argument(
        "--seed",
        type=whole_number(0),
        default=0,
        metavar="N",
        help="Seed of the matcher's draws (default: %(default)s).",
    )
    parser.add_argument("--json", action="store_true", help="One JSON object on stdout.")
    parser.add_argument(
        "--overlay",
        type=Path,
        metavar="OUT.png",
        help="Draw the model at its pose over the first image: supported lines blue, the others orange.",
    )
    parser.add_argument(
        "--unit", default="m", help="Unit of the model file: m, cm, mm or in (default: %(default)s)."
    )
    parser.add_argument(
        "--gamma",
        type=float,
        help="Tone curve to undo: linear = grey^gamma; else [camera] gamma, or what the files tell.",
    )


def run(options: Namespace) -> int:
    """Estimate and print; the exit status."""
    try:
        result = _estimated(options)
    except LightsAndCameraError as error:
        print(f"vision_server: {error}", file=sys.stderr)
        return EXIT_BAD_INPUT
    if options.json:
        print(json.dumps(result, allow_nan=False))
    else:
        _print(result)
    return EXIT_NO_POSE if result["pose"] is None else 0
