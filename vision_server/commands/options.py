"""Options that several commands share."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from bridge.command_line import MOST_SEED, number, output_file, whole_number
from bridge.errors import BadInput
from vision_server.channels.colours import COLOURS, ONE

if TYPE_CHECKING:
    from geometry.model import Model
    from vision_server.serve.inputs import GivenCamera


def warn(words: str) -> None:
    """Say on standard error what is doubtful of a command's input or outcome."""
    print(f"vision_server: {words}", file=sys.stderr)


def add_model_and_camera(parser: ArgumentParser, or_described: bool = False) -> None:
    """The target and the camera, of every command that looks for a target."""
    untold = "; else what the image server describes" if or_described else ""
    parser.add_argument(
        "--model", required=True, type=Path, metavar="FILE", help="Model file: .cao, OBJ, STL, PLY or glTF."
    )
    parser.add_argument(
        "--camera",
        required=not or_described,
        type=Path,
        metavar="FILE",
        help=f"File with [camera], or of OpenCV, ROS, Kalibr or ViSP{untold}.",
    )
    parser.add_argument(
        "--unit", default="m", help="Unit of the model file: m, cm, mm or in (default: %(default)s)."
    )


def add_seed(parser: ArgumentParser) -> None:
    """Where random draws come from."""
    parser.add_argument(
        "--seed", type=whole_number(0, MOST_SEED), default=0, metavar="N",
        help="Seed of the search's draws (default: %(default)s).",
    )  # fmt: skip


def add_gamma(parser: ArgumentParser) -> None:
    """The tone curve of the images."""
    parser.add_argument(
        "--gamma", type=number(0.01, 100.0),
        help="Tone curve to undo: linear = grey^gamma; else [camera] gamma, or what the files tell.",
    )  # fmt: skip


def add_edge_radius(parser: ArgumentParser) -> None:
    """How round the target's edges are."""
    parser.add_argument(
        "--edge-radius", type=number(0.0, 1e6), metavar="M",
        help="Radius of the target's rounded edges, m; else [target] edge_radius_m of the camera's file, "
        "or what the frames show.",
    )  # fmt: skip


def picture_file(word: str) -> Path:
    """Read the name of a picture that is written at the end, PNG without an ending.

    Raises
    ------
    BadInput
        As `output_file`, or pictures of the kind that it says cannot be written.
    """
    import cv2
    import numpy as np

    file = output_file(word)
    try:
        written = cv2.haveImageWriter(file.name) and all(
            cv2.imencode(file.suffix, np.zeros(shape, np.uint8))[0] for shape in ((8, 8), (8, 8, 3))
        )
    except cv2.error:  # GIF, of greys
        written = False
    if file.suffix and not written:
        raise BadInput(f"Cannot write pictures of the kind {file.suffix!r}.", "Name it something.png.")
    return file


def check_outputs(options: Namespace, inputs: Sequence[str], outputs: Sequence[str]) -> None:
    """Raise BadInput where a file that is to be written is one that is read, or two are one file.

    ``inputs`` and ``outputs`` name options, each with a path, a list of paths or None.
    """
    taken: dict[Path, str] = {}
    for name in (*inputs, *outputs):
        value = getattr(options, name)
        for word in value if isinstance(value, list) else [value]:
            if word is None or ((file := Path(word)).exists() and not file.is_file()):  # as /dev/null
                continue
            place = file.resolve()
            if name in outputs and place in taken:
                raise BadInput(f"Cannot write {file} as --{name}: it is {taken[place]}.", "Name another.")
            taken[place] = "read as well" if name in inputs else f"--{name} as well"


def told_edge_radius(option: float | None, given: GivenCamera, model: Model) -> float | None:
    """What the command line or [target] says of that, None if nothing; raises as `checked_edge_radius`."""
    from vision_server.serve.inputs import checked_edge_radius

    if option is None:
        return given.edge_radius_m(model)
    return checked_edge_radius(option, model, "--edge-radius")


def add_exposures(parser: ArgumentParser) -> None:
    """The option of `parse_exposures`."""
    parser.add_argument(
        "--exposures",
        metavar="E,...",
        help="Relative exposure of each image (default: 1; measured of one brighter than all others).",
    )


def add_colour(parser: ArgumentParser, several: bool = True) -> None:
    """What is made of colour images; ``several``: whether one may be more than one image of a set."""
    each = ", or each channel as an image of its own" if several else ""
    parser.add_argument(
        "--colour", choices=COLOURS if several else ONE, default="grey",
        help=f"What is taken of colour images: grey, or a channel{each} (default: %(default)s).",
    )  # fmt: skip
