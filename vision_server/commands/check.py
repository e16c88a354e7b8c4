"""`python -m vision_server check`: whether a pose from elsewhere is right."""

from __future__ import annotations

import json
from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import Any

from bridge.errors import BadInput
from vision_server.commands.files import read_set
from vision_server.commands.options import (
    add_colour,
    add_edge_radius,
    add_exposures,
    add_gamma,
    add_model_and_camera,
    add_seed,
    told_edge_radius,
    warn,
)

EXITS = {"ok": 0, "doubtful": 1, "lost": 3}


def add_options(parser: ArgumentParser) -> None:
    """Options of the command."""
    parser.description = f"{parser.description} Exit status: 0 ok, 1 doubtful, 3 lost, 2 bad input."
    parser.add_argument(
        "images", metavar="IMAGE", nargs="+", type=Path, help="Image files of one set, one size."
    )
    add_model_and_camera(parser)
    parser.add_argument(
        "--pose", required=True, type=Path, metavar="FILE",
        help="TOML with rotation_vector (rad) and translation (m), camera_T_target, in no table; "
        "or one object of --json in a .json file.",
    )  # fmt: skip
    add_exposures(parser)
    add_colour(parser)
    add_edge_radius(parser)
    parser.add_argument("--json", action="store_true", help="One JSON object on stdout.")
    add_seed(parser)
    add_gamma(parser)


def run(options: Namespace) -> int:
    """Judge and print; the exit status."""
    values = _judged(options)
    if options.json:
        print(json.dumps(values, allow_nan=False))
    else:
        _print(values)
    return EXITS[values["state"]]


def _judged(options: Namespace) -> dict[str, Any]:
    from geometry.errors import GeometryError
    from vision_server.commands.no_pose import is_out_of_frame
    from vision_server.pipeline import PipelineSettings
    from vision_server.serve.inputs import model_warning, read_camera_file, read_model, read_pose
    from vision_server.serve.results import judgement_result
    from vision_server.serve.witnesses import disagreeing_images
    from vision_server.tracking.referee import judged

    given = read_camera_file(options.camera)
    model = read_model(options.model, options.unit)
    pose = read_pose(options.pose, model)
    if (doubt := model_warning(model, given.camera, pose)) is not None:
        warn(doubt)
    if is_out_of_frame(model, given.camera, pose):
        warn("from the pose no line of the model is in the frame.")
    images, files, tone_sd_px = read_set(options, given.camera, given.table)
    names = list(files)
    settings = PipelineSettings(
        seed=options.seed, tone_sd_px=tone_sd_px, tolerance_m=given.tolerance_m(model) or 0.0
    )
    try:
        radius_m = told_edge_radius(options.edge_radius, given, model)
        found = judged(images, names, model, given.camera, pose, settings, edge_radius_m=radius_m)
    except GeometryError as error:
        raise BadInput(str(error)) from error
    against = disagreeing_images(images, names, model, given.camera, pose, found.better, settings)
    elsewhere = [files[name] for name in against]
    if elsewhere:
        warn(
            f"{', '.join(elsewhere)}: each alone shows the target elsewhere. A set is "
            "of one still scene: leave out what moved."
        )
    return judgement_result(found, elsewhere)


def _print(values: dict[str, Any]) -> None:
    print(f"{values['state']}: right to 1 degree and 1 % with probability {values['probability']:.2f}")
    if values["better"] is not None:
        apart, better = values["difference"], values["better"]
        print(
            f"A better pose, right with probability {values['better_probability']:.2f}, is "
            f"{apart['rotation_deg']:.2f} degrees and {1e3 * apart['translation_m']:.2f} mm away: "
            f"rotation_vector = {better['rotation_vector']}, translation = {better['translation']}"
        )
    if values["disagreeing_lines"]:
        print("Lines of the model that are not seen: " + ", ".join(map(str, values["disagreeing_lines"])))
