"""`python -m vision_server edges`: the multi-channel edge map of image files."""

from __future__ import annotations

import math
import sys
from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from bridge.errors import EXIT_BAD_INPUT, BadInput

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from vision_server.edges.edge_map import EdgeMap


METHODS = ("em", "mean", "max-image", "max-gradient", "di-zenzo", "mertens")
"""Rules by which several images become one edge map."""


def parse_exposures(text: str | None, count: int) -> list[float]:
    """Relative exposures from "E,E,…", one for each image; 1 each when not given.

    Raises
    ------
    BadInput
        Not numbers, not positive, or not as many as images.
    """
    if text is None:
        return [1.0] * count
    try:
        exposures = [float(part) for part in text.split(",")]
    except ValueError:
        raise BadInput(
            f"--exposures {text!r} is not a list of numbers.", "Write e.g. --exposures 1,0.5,2."
        ) from None
    if len(exposures) != count:
        raise BadInput(
            f"--exposures names {len(exposures)} numbers for {count} images.", "Give one for each."
        )
    if not all(math.isfinite(e) and e > 0.0 for e in exposures):
        raise BadInput(f"--exposures {text!r} must be positive numbers.")
    return exposures


def edge_picture(edges: EdgeMap) -> NDArray[np.uint8]:
    """Edgels that survive hysteresis, white on black, uint8 (H, W)."""
    import numpy as np

    from vision_server.edges.suppression import hysteresis
    from vision_server.segments.extraction import edgel_thresholds

    low, high = edgel_thresholds(edges)
    picture = np.zeros(edges.shape, np.uint8)
    picture.ravel()[edges.places[hysteresis(edges, low, high)]] = 255
    return picture


def write_file(path: Path, content: bytes) -> None:
    """Write bytes, or say plainly why not.

    Raises
    ------
    BadInput
        The file cannot be written.
    """
    try:
        path.write_bytes(content)
    except OSError as error:
        raise BadInput(f"Cannot write {path}: {error.strerror or error}.", "Check the folder.") from error


def _write(options: Namespace) -> None:
    import cv2
    import numpy as np

    from vision_server.channels.channel import channel_statistics
    from vision_server.channels.image_files import read_image_set
    from vision_server.edges.merging import merge_channels
    from vision_server.rivals.merge_rules import comparison_edges

    pixels = read_image_set(options.images)
    times = parse_exposures(options.exposures, len(pixels))
    gamma, out, magnitude = options.gamma, options.out, options.magnitude
    if not (math.isfinite(gamma) and gamma > 0.0):
        raise BadInput(f"--gamma must be a positive number, not {gamma}.")
    if options.method == "em":
        edges = merge_channels([channel_statistics(i, e, gamma) for i, e in zip(pixels, times, strict=True)])
    else:
        edges = comparison_edges(pixels, options.method, times, gamma)
    try:
        encoded, content = cv2.imencode(out.suffix or ".png", edge_picture(edges))
    except cv2.error:
        encoded = False
    if not encoded:
        raise BadInput(f"Cannot write pictures of the kind {out.suffix!r}.", "Name --out something.png.")
    write_file(out, content.tobytes())
    if magnitude is not None:
        try:
            with magnitude.open("wb") as file:
                np.save(file, edges.ridge, allow_pickle=False)
        except OSError as error:
            raise BadInput(
                f"Cannot write {magnitude}: {error.strerror or error}.", "Check the folder."
            ) from error


def add_options(parser: ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument(
        "images", metavar="IMAGE", nargs="+", type=Path, help="Image files of one set, one size."
    )
    parser.add_argument(
        "--out", required=True, type=Path, metavar="PNG", help="Picture of the edges to write."
    )
    add_exposures(parser)
    parser.add_argument(
        "--magnitude",
        type=Path,
        metavar="NPY",
        help="Also save the merged magnitude on its ridges, before any threshold (float32).",
    )
    parser.add_argument(
        "--method",
        choices=METHODS,
        default="em",
        help="How the images are merged (default: %(default)s).",
    )
    parser.add_argument(
        "--gamma",
        type=float,
        default=1.0,
        help="Tone curve of the files to undo: linear = grey^gamma (default: %(default)s).",
    )


def add_exposures(parser: ArgumentParser) -> None:
    """The option of `parse_exposures`."""
    parser.add_argument(
        "--exposures", metavar="E,...", help="Relative exposure of each image; 1 each when left out."
    )


def run(options: Namespace) -> int:
    """Merge, and write the files that are asked for; the exit status."""
    try:
        _write(options)
    except BadInput as error:
        print(error, file=sys.stderr)
        return EXIT_BAD_INPUT
    return 0
