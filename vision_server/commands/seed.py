"""`python -m vision_server seed`: a seed pose from corners of the model and their places in an image."""

from __future__ import annotations

import json
from argparse import ArgumentParser, Namespace
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from bridge.command_line import number, output_file, whole_number
from bridge.errors import BadInput
from vision_server.commands.files import check_image_size, write_file, write_overlay
from vision_server.commands.options import add_model_and_camera, check_outputs, picture_file, warn

if TYPE_CHECKING:
    from geometry.camera import Camera
    from geometry.model import Model
    from numerics.arrays import Grey
    from vision_server.seeding.pairs import Pairs
    from vision_server.seeding.points_pose import PointsPose

PAGE_FILE = Path("seed.toml")  # what a page saves where no name is given


def add_options(parser: ArgumentParser) -> None:
    """Options of the command."""
    parser.description = (
        f"{parser.description} Without --points and --pair a page is served on which they are clicked. "
        "Exit status: 0 pose, 3 none was saved, 2 bad input."
    )
    parser.add_argument("image", metavar="IMAGE", type=Path, help="Image file.")
    add_model_and_camera(parser)
    parser.add_argument(
        "--points", type=Path, metavar="FILE",
        help="Pairs, one a line: u,v x,y,z (px; the model file's coordinates, in its unit).",
    )  # fmt: skip
    parser.add_argument(
        "--pair", action="append", default=[], metavar="'u,v x,y,z'", help="One such pair; again for each."
    )
    parser.add_argument(
        "--out",
        type=output_file,
        metavar="TOML",
        help=f"File to write; of a page, {PAGE_FILE} where none is given.",
    )
    parser.add_argument(
        "--overlay", type=picture_file, metavar="OUT.png", help="Draw the model at its pose over the image."
    )
    parser.add_argument("--json", action="store_true", help="One JSON object on stdout.")
    parser.add_argument(
        "--port", type=whole_number(0, 65535), default=0, help="Of the page (default: any that is free)."
    )
    parser.add_argument(
        "--wait-s", type=number(0), default=600.0, metavar="S",
        help="How long a browser is waited for (default: %(default)g).",
    )  # fmt: skip


def run(options: Namespace) -> int:
    """Solve, or serve the page; the exit status."""
    scene = _read(options)
    if options.points is not None or options.pair:
        return _of_points(options, scene)
    return _of_clicks(options, scene)


@dataclass(frozen=True, eq=False)
class _Scene:
    model: Model
    camera: Camera
    grey: Grey  # (H, W); of a deep image its own range


def _read(options: Namespace) -> _Scene:
    from vision_server.channels.depth import stretched
    from vision_server.channels.image_files import read_grey
    from vision_server.serve.inputs import model_warning, read_camera, read_model, told_raw

    check_outputs(options, ["image", "model", "camera", "points"], ["out", "overlay"])
    camera, table = read_camera(options.camera)
    model = read_model(options.model, options.unit)
    grey = stretched(read_grey(options.image, told_raw(table)))
    check_image_size(options.image, grey.shape, camera)
    if (doubt := model_warning(model, camera, None)) is not None:
        warn(doubt)
    return _Scene(model, camera, grey)


def _of_points(options: Namespace, scene: _Scene) -> int:
    from vision_server.seeding.pairs import parsed_pairs, read_lines
    from vision_server.seeding.points_pose import pose_of_points

    lines = [] if options.points is None else read_lines(options.points)
    pairs = parsed_pairs(lines + options.pair, options.unit)
    found = pose_of_points(pairs, scene.model, scene.camera, scene.grey)
    _write(options, scene, found, options.out)
    _print(options, scene, found, pairs)
    return 0


def _of_clicks(options: Namespace, scene: _Scene) -> int:
    from vision_server.seeding.serving import serve_page
    from vision_server.seeding.view import SeedView

    out: Path = options.out or PAGE_FILE
    saved: list[tuple[PointsPose, Pairs]] = []

    def save(found: PointsPose, pairs: Pairs) -> str:
        _write(options, scene, found, out)
        saved.append((found, pairs))
        return f"Saved as {out}. The command has ended; this page can be closed."

    status = serve_page(SeedView(scene.model, scene.camera, scene.grey, save), options.port, options.wait_s)
    if saved:
        _print(options, scene, *saved[-1])
    return status


def _write(options: Namespace, scene: _Scene, found: PointsPose, out: Path | None) -> None:
    """Seed pose and overlay as files; BadInput where the pose is no seed pose, or they cannot be written."""
    from geometry.errors import GeometryError
    from vision_server.serve.inputs import checked_pose

    try:
        checked_pose(found.pose, scene.model)
    except GeometryError as error:
        raise BadInput(f"The pose of these pairs is none to start from: {error}.") from error
    if out is not None:
        write_file(out, _toml(found).encode())
    if options.overlay is not None:
        write_overlay(options.overlay, scene.grey, scene.model, scene.camera, found.pose)


def _toml(found: PointsPose) -> str:
    rows = [f"# RMS {found.rms_px:.2f} px of {len(found.errors_px)} points", "[target.seed_pose]"]
    rows += [f"{name} = {values}" for name, values in found.pose.to_dict().items()]
    return "\n".join(rows) + "\n"


def _print(options: Namespace, scene: _Scene, found: PointsPose, pairs: Pairs) -> None:
    from vision_server.seeding.points_pose import wrong_pair

    wrong = wrong_pair(found, pairs, scene.model, scene.camera)
    if wrong is not None:
        warn(wrong)
    elif found.others:
        warn(
            f"{len(found.others) + 1} poses fit these points; this one fits the image best, "
            "and another point decides"
        )
    if not options.json:
        print(_toml(found), end="")
        return
    rows = zip(pairs.pixels.tolist(), pairs.points.tolist(), found.errors_px.tolist(), strict=True)
    values = {
        "pose": found.pose.to_dict(),
        "rms_px": found.rms_px,
        "points": [{"image": image, "model_m": model, "error_px": error} for image, model, error in rows],
        "others": [pose.to_dict() for pose in found.others],
    }
    print(json.dumps(values, allow_nan=False))
