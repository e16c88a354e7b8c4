"""`python -m vision_server edges`: the multi-channel edge map of image files."""

from __future__ import annotations

import io
import json
import math
from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from bridge.command_line import output_file, whole_number
from bridge.errors import BadInput
from vision_server.baselines import MERGE_RULES
from vision_server.commands.files import exposures_of, warn_of_movement, write_file, write_picture
from vision_server.commands.options import add_colour, add_exposures, check_outputs, picture_file, warn

if TYPE_CHECKING:
    from numerics.arrays import Field, Floats
    from vision_server.kinds.kinds import EdgeKinds


METHODS = ("em", *MERGE_RULES)
"""Rules by which several images become one edge map."""
SELECTABLE_KINDS = ("outline", "crease", "print", "shadow", "highlight")

LEVELS_UNKNOWN = (
    "how far each light was on could not be learnt from these images: creases, shadows and highlights are "
    "easily taken for each other. Give --levels with a row for each image, as --levels '1,0,0;0,1,0;0,0,1' "
    "for three images with a lamp of its own each."
)


def parse_levels(text: str | None, count: int) -> Floats | None:
    """Levels (images, lamps) of the lights from "L,L,…;L,L,…;…", as shares of the largest one.

    Raises
    ------
    BadInput
        Not numbers, negative, none above 0, or not one row of as many lights for each image.
    """
    import numpy as np

    if text is None:
        return None
    try:
        rows = [[float(level) for level in row.split(",")] for row in text.split(";")]
    except ValueError:
        raise BadInput(
            f"--levels {text!r} is not a list of numbers.", "Write e.g. --levels '7,0;0,7;4,4'."
        ) from None
    if len(rows) != count or len({len(row) for row in rows}) != 1:
        raise BadInput(f"--levels {text!r} must name the level of each light for {count} images.")
    levels = np.array(rows, np.float64)
    if not (np.isfinite(levels).all() and levels.min() >= 0.0 and levels.max() > 0.0):
        raise BadInput(f"--levels {text!r} must be numbers from 0 on, one at least above it.")
    return np.asarray(levels / levels.max(), np.float64)


def run(options: Namespace) -> None:
    """Merge, and write the files that are asked for."""
    from vision_server.baselines.merge_rules import comparison_edges
    from vision_server.channels.channel import channel_statistics
    from vision_server.channels.depth import Raw, is_deep, rounded
    from vision_server.channels.image_files import read_image_set
    from vision_server.edges.merging import merge_channels
    from vision_server.edges.moved import moved_since, sure_edgels
    from vision_server.edges.suppression import edge_picture
    from vision_server.kinds.kinds import UNKNOWN, different, edge_kinds
    from vision_server.kinds.likelihoods import FIXED, KINDS

    check_outputs(options, ["images"], ["out", "magnitude", "kinds", "npz"])
    pictures = read_image_set(options.images, Raw(options.bits, options.bayer), options.colour)
    pixels = [picture.pixels for picture in pictures]
    shallow = [picture for picture in pictures if not is_deep(picture.pixels)]
    if options.bits is not None and shallow:
        warn(f"{shallow[0]} has 8 bits a pixel: --bits is of files of 16.")
    levels = parse_levels(options.levels, len(options.images))
    if levels is not None:
        levels = levels[[picture.number for picture in pictures]]
    gamma = options.gamma
    if not (math.isfinite(gamma) and gamma > 0.0):
        raise BadInput(f"--gamma must be a positive number, not {gamma}.")
    times = exposures_of(options, pictures, [gamma] * len(pictures))
    asked = [name for name in ("kind", "kinds", "npz", "json") if getattr(options, name)]
    if asked and options.method != "em":
        raise BadInput(
            f"--{asked[0]} needs the kinds of edges, which --method {options.method} does not tell."
        )
    if options.method != "em":
        edges = comparison_edges([rounded(one) for one in pixels], options.method, times, gamma)
    else:
        channels = [channel_statistics(i, e, gamma) for i, e in zip(pixels, times, strict=True)]
        seen = [sure_edgels(channel) for channel in channels]
        for number, picture in enumerate(pictures[1:], start=1):
            if (moved := moved_since(seen[:number], seen[number])) is not None:
                warn_of_movement(picture, moved)
        if len(different(channels)) > 1 or asked:
            several = len(pictures) > len(options.images)
            kinds = edge_kinds(channels, levels, [one.number for one in pictures] if several else None)
            edges = kinds.of_kinds([KINDS.index(options.kind)] if options.kind else FIXED)
            if asked and kinds.levels == UNKNOWN:
                warn(LEVELS_UNKNOWN)
            write_kinds(kinds, options)
        else:
            edges = merge_channels(channels)
    write_picture(options.out, edge_picture(edges))
    if options.magnitude is not None:
        write_array(options.magnitude, edges.ridge)


def write_kinds(kinds: EdgeKinds, options: Namespace) -> None:
    """The picture and the tables of kinds that are asked for."""
    import numpy as np

    from vision_server.kinds.kinds_table import kinds_picture, kinds_table

    if options.kinds is not None:
        write_picture(options.kinds, kinds_picture(kinds))
    if options.npz is not None:
        content = io.BytesIO()
        np.savez_compressed(content, allow_pickle=False, **kinds_table(kinds))
        write_file(options.npz, content.getvalue())
    if options.json:
        columns = {name: column.tolist() for name, column in kinds_table(kinds).items()}
        print(json.dumps(columns, allow_nan=False))


def write_array(path: Path, array: Field) -> None:
    """Write one array as NumPy does; errors as `write_file`."""
    import numpy as np

    content = io.BytesIO()
    np.save(content, array, allow_pickle=False)
    write_file(path, content.getvalue())


def add_options(parser: ArgumentParser) -> None:
    """Options of the command."""
    parser.description = f"{parser.description} Exit status: 0 written, 2 bad input."
    parser.add_argument(
        "images", metavar="IMAGE", nargs="+", type=Path, help="Image files of one set, one size."
    )
    parser.add_argument(
        "--out", required=True, type=picture_file, metavar="PNG", help="Picture of the edges to write."
    )
    add_exposures(parser)
    add_colour(parser)
    parser.add_argument(
        "--magnitude",
        type=output_file,
        metavar="NPY",
        help="Also save the merged magnitude on its ridges, before any threshold (float32).",
    )
    parser.add_argument(
        "--kind",
        choices=SELECTABLE_KINDS,
        help="Edges of this kind in --out and --magnitude, not all that are of the scene.",
    )
    parser.add_argument(
        "--levels",
        metavar="L,..;..",
        help="Levels of the lights in each image, where they are known: shadows are told better.",
    )
    parser.add_argument(
        "--kinds", type=picture_file, metavar="PNG", help="Also draw all edges, with a colour for each kind."
    )
    parser.add_argument(
        "--npz",
        type=output_file,
        metavar="NPZ",
        help="Also save edgels with place, axis and probabilities of kinds.",
    )
    parser.add_argument("--json", action="store_true", help="Print what --npz saves as one JSON object.")
    parser.add_argument(
        "--method",
        choices=METHODS,
        default="em",
        help="How the images are merged (default: %(default)s).",
    )
    parser.add_argument(
        "--bits", type=whole_number(8, 16), metavar="N",
        help="Bits of the camera in files of 16; else the fewest that hold their values.",
    )  # fmt: skip
    parser.add_argument("--bayer", action="store_true", help="The files are a Bayer mosaic, of any order.")
    parser.add_argument(
        "--gamma",
        type=float,
        default=1.0,
        help="Tone curve of the files to undo: linear = grey^gamma (default: %(default)s).",
    )
