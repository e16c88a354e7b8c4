"""`python -m vision_server estimate`: the pose of a target from image files."""

from __future__ import annotations

import json
import math
from argparse import ArgumentParser, Namespace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bridge.command_line import number
from bridge.errors import EXIT_NO_POSE, BadInput
from bridge.start_messages import MATCHER_NAMES
from vision_server.commands.files import read_set, started_at, write_overlay
from vision_server.commands.options import (
    add_colour,
    add_exposures,
    add_gamma,
    add_model_and_camera,
    add_seed,
    check_outputs,
    picture_file,
    warn,
)

if TYPE_CHECKING:
    from geometry.camera import Camera
    from geometry.model import Model
    from geometry.pose import Pose
    from vision_server.matching.match import Anywhere, SearchRange
    from vision_server.trust.judgement import Estimate


def _check_use(options: Namespace) -> None:
    """Refuse what would change nothing."""
    ranges = {"--rotation-range-deg": options.rotation_range_deg}
    ranges["--translation-range-px"] = options.translation_range_px
    for name, value in ranges.items():
        if value is not None and options.seed_pose is None:
            raise BadInput(f"{name} is how far around --seed-pose is looked.", "Give both, or neither.")


def _estimated(options: Namespace) -> tuple[dict[str, Any], float]:
    """What is told of the images, and how large the model is, metres."""
    from geometry.errors import GeometryError
    from geometry.pose import SEARCH_ROTATION_DEG, Pose, search_translation_px
    from vision_server.channels.depth import stretched
    from vision_server.channels.image_files import read_image_set
    from vision_server.matching.match import SearchRange
    from vision_server.matching.region import region_of
    from vision_server.pipeline import PipelineSettings, estimate_pose
    from vision_server.serve.inputs import read_camera_file, read_model, told_raw, untold_tolerance_m
    from vision_server.serve.results import estimate_result
    from vision_server.trust.judgement import stated

    _check_use(options)
    check_outputs(options, ["images", "model", "camera", "seed_pose"], ["overlay"])
    given = read_camera_file(options.camera)
    camera, table = given.camera, given.table
    model = read_model(options.model, options.unit)
    start = started_at(options, model, given)
    usual = (SEARCH_ROTATION_DEG, search_translation_px(camera.width))
    try:
        told = (options.rotation_range_deg, options.translation_range_px)
        reach = SearchRange(*(known if one is None else one for one, known in zip(told, usual, strict=True)))
        region = region_of(model, camera, start, reach) if isinstance(start, Pose) else None
        image_set, files, tone_sd_px = read_set(options, camera, table, region)
        seen = camera if region is None else camera.part(region)
        told_m = given.tolerance_m(model)
        settings = PipelineSettings(
            matcher=options.matcher,
            seed=options.seed,
            tone_sd_px=tone_sd_px,
            tolerance_m=told_m or 0.0,
            untold_tolerance_m=untold_tolerance_m(told_m, model),
            rotation_range_deg=reach.rotation_deg,
            translation_range_px=reach.translation_px,
        )
        estimate = stated(estimate_pose(image_set, list(files), model, seen, start, settings))
    except GeometryError as error:
        raise BadInput(str(error)) from error
    _say_why(options, estimate, model, camera, start, reach)
    if options.overlay is not None:
        seed_pose = start if isinstance(start, Pose) else None
        shown = seed_pose if estimate.pose is None else estimate.pose
        support = {line.line: line.support for line in estimate.lines}
        picture = stretched(read_image_set(options.images[:1], told_raw(table), options.colour)[0].pixels)
        write_overlay(options.overlay, picture, model, camera, shown, support)
    result = estimate_result(estimate)
    result["seconds"]["total"] = sum(result["seconds"].values())
    first = {"target": model.name, "seed": options.seed, "kept": list(files), "files": files}
    return first | result, model.diameter


def _say_why(
    options: Namespace,
    estimate: Estimate,
    model: Model,
    camera: Camera,
    start: Pose | Anywhere,
    reach: SearchRange,
) -> None:
    """Say why there is no pose, or why what there is is hardly believed."""
    from vision_server.channels.image_files import shows_more_in_colour
    from vision_server.commands.no_pose import why_hardly_believed, why_no_pose
    from vision_server.matching.match import Anywhere
    from vision_server.serve.inputs import range_warning

    told = start if isinstance(start, Anywhere) else Anywhere()
    if estimate.pose is not None and (elsewhere := range_warning(model, estimate.pose, told)) is not None:
        warn(elsewhere)
    doubt = why_hardly_believed(estimate)
    if estimate.pose is not None and doubt is None:
        return
    if options.colour == "grey" and any(map(shows_more_in_colour, options.images)):
        warn("the images show edges in colour that their grey hardly shows: try --colour each")
    if doubt is not None:
        warn(doubt)
        return
    for reason in why_no_pose(estimate.segments, model, camera, start, reach):
        warn(f"no pose: {reason}")


def _print(result: dict[str, Any], diameter_m: float) -> None:
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    from vision_server.pipeline import SURE_SCORE

    console = Console()
    say = partial(console.print, soft_wrap=True)  # a line stays one, in a pipe too
    if result["pose"] is None:
        say(f"No pose of {result['target']}: nothing in the images supports one.")
        return
    pose = result["pose"]
    # its size is all that shows a wrong unit
    say(f"Pose of [bold]{result['target']}[/bold] (camera_T_target), {diameter_m:.3g} m across")
    say("  rotation vector  " + "  ".join(f"{value:+.6f}" for value in pose["rotation_vector"]) + "  rad")
    say("  translation      " + "  ".join(f"{value:+.6f}" for value in pose["translation"]) + "  m")
    spread = [math.sqrt(max(row[i], 0.0)) for i, row in enumerate(result["covariance"])]
    say("  sd of rotation   " + "  ".join(f"{math.degrees(value):.4f}" for value in spread[:3]) + "  deg")
    say("  sd of shift      " + "  ".join(f"{1e3 * value:.4f}" for value in spread[3:]) + "  mm")
    poses = result.get("poses", [])
    if len(poses) > 1:
        say(f"  one of {len(poses)} poses that fit, its probability {100 * poses[0]['probability']:.0f} %")
    say(
        f"  RMS {result['rms_px']:.2f} px, {100 * result['supported_fraction']:.0f} % of the visible lines "
        f"supported, score {result['score']:.2f}, ambiguity {result['ambiguity']:.2f}, "
        f"{result['segments']} segments"
    )
    trusted = result["score"] >= SURE_SCORE
    say(
        f"  [bold]{'trusted' if trusted else 'not trusted'}[/bold]: the score is the chance that it is right "
        f"to 1 degree and 1 % of the range; {SURE_SCORE:.3f} is asked"
    )
    for axis in result.get("free", []):
        say(f"  free: rotation about {axis}, which no image clearly shows")
    for other in poses[1:]:
        vector, place = other["pose"]["rotation_vector"], other["pose"]["translation"]
        say(
            f"  or, {100 * other['probability']:.0f} %: rotation vector "
            + "  ".join(f"{value:+.3f}" for value in vector)
            + "  translation  "
            + "  ".join(f"{value:+.3f}" for value in place)
        )
    table = Table("line", "visible px", "support", "RMS px", "image")
    for line in result["lines"]:
        table.add_row(
            str(line["line"]),
            f"{line['visible_px']:.0f}",
            f"{line['support']:.2f}",
            f"{line['rms_px']:.2f}",
            escape(Path(result["files"][line["image"]]).name) if line["image"] else "-",
        )
    console.print(table)
    say("  " + ", ".join(f"{stage} {1e3 * value:.0f} ms" for stage, value in result["seconds"].items()))


def add_options(parser: ArgumentParser) -> None:
    """Options of the command."""
    parser.description = f"{parser.description} Exit status: 0 pose, 3 no pose, 2 bad input."
    parser.add_argument(
        "images", metavar="IMAGE", nargs="+", type=Path, help="Image files of one set, one size."
    )
    add_model_and_camera(parser)
    parser.add_argument(
        "--seed-pose",
        type=Path,
        metavar="TOML",
        help="File with [target.seed_pose]; without it the target is looked for everywhere, however turned.",
    )
    add_exposures(parser)
    add_colour(parser)
    parser.add_argument(
        "--matcher",
        choices=MATCHER_NAMES,
        default="search",
        help="How the pose is found before it is refined (default: %(default)s).",
    )
    add_seed(parser)
    parser.add_argument(
        "--rotation-range-deg",
        type=number(0.0),
        metavar="DEG",
        help="How far the target may be turned from the seed pose, about each axis through its middle "
        "(default: 25).",
    )
    parser.add_argument(
        "--translation-range-px",
        type=number(0.0),
        metavar="PX",
        help="How far that middle may be moved, in pixels at its depth (default: 40, or a sixteenth of a "
        "frame that is wider than 640).",
    )
    parser.add_argument("--json", action="store_true", help="One JSON object on stdout.")
    parser.add_argument(
        "--overlay",
        type=picture_file,
        metavar="OUT.png",
        help="Draw the model at its pose (or its seed pose, where none was found) over the first image: "
        "supported lines blue, the others orange.",
    )
    add_gamma(parser)


def run(options: Namespace) -> int:
    """Estimate and print; the exit status."""
    result, diameter_m = _estimated(options)
    if options.json:
        print(json.dumps(result, allow_nan=False))
    else:
        _print(result, diameter_m)
    return EXIT_NO_POSE if result["pose"] is None else 0
