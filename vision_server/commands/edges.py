"""`python -m vision_server edges`: the multi-channel edge map of image files."""

from __future__ import annotations

import sys
from enum import StrEnum
from pathlib import Path
from typing import Annotated, cast

import cv2
import numpy as np
import typer
from numpy.typing import NDArray

from bridge.errors import EXIT_BAD_INPUT, BadInput
from vision_server.canny import hysteresis
from vision_server.channel import channel_statistics
from vision_server.comparison_edges import ComparisonMethod, comparison_edges
from vision_server.edge_map import EdgeMap
from vision_server.edges import merge_channels
from vision_server.image_files import read_image_set
from vision_server.segments import edgel_thresholds


class Method(StrEnum):
    """Rule by which several images become one edge map."""

    EM = "em"
    MEAN = "mean"
    MAX_IMAGE = "max-image"
    MAX_GRADIENT = "max-gradient"
    DI_ZENZO = "di-zenzo"
    MERTENS = "mertens"


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
    if not all(np.isfinite(e) and e > 0.0 for e in exposures):
        raise BadInput(f"--exposures {text!r} must be positive numbers.")
    return exposures


def edge_picture(edges: EdgeMap) -> NDArray[np.uint8]:
    """Edgels that survive hysteresis, white on black, uint8 (H, W)."""
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


def _run(
    images: list[Path], out: Path, exposures: str | None, magnitude: Path | None, method: Method, gamma: float
) -> None:
    pixels = read_image_set(images)
    times = parse_exposures(exposures, len(pixels))
    if not (np.isfinite(gamma) and gamma > 0.0):
        raise BadInput(f"--gamma must be a positive number, not {gamma}.")
    if method is Method.EM:
        edges = merge_channels([channel_statistics(i, e, gamma) for i, e in zip(pixels, times, strict=True)])
    else:
        edges = comparison_edges(pixels, cast(ComparisonMethod, method.value), times, gamma)
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


def edges_command(
    images: Annotated[
        list[Path], typer.Argument(metavar="IMAGE...", help="Image files of one set, one size.")
    ],
    out: Annotated[Path, typer.Option(help="Picture of the edges to write.")],
    exposures: Annotated[
        str | None,
        typer.Option(metavar="E,...", help="Relative exposure of each image; 1 each when left out."),
    ] = None,
    magnitude: Annotated[
        Path | None,
        typer.Option(
            help="Also save the merged magnitude on its ridges, before any threshold (.npy, float32)."
        ),
    ] = None,
    method: Annotated[Method, typer.Option(help="How the images are merged.")] = Method.EM,
    gamma: Annotated[float, typer.Option(help="Tone curve of the files to undo: linear = grey^gamma.")] = 1.0,
) -> None:
    """Merge image files of one set into one edge map."""
    try:
        _run(images, out, exposures, magnitude, method, gamma)
    except BadInput as error:
        print(error, file=sys.stderr)
        raise typer.Exit(EXIT_BAD_INPUT) from None
