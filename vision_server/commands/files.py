"""Files that several commands read and write: images of a set, a seed pose, pictures of what was found."""

from __future__ import annotations

import math
from argparse import Namespace
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bridge.command_line import counted
from bridge.errors import BadInput
from vision_server.commands.options import warn

if TYPE_CHECKING:
    from geometry.camera import Camera, Region
    from geometry.model import Model
    from geometry.pose import Pose
    from numerics.arrays import Grey
    from vision_server.channels.depth import Pixels
    from vision_server.channels.image_files import Picture
    from vision_server.edges.moved import Movement
    from vision_server.image_set import ImageSet
    from vision_server.matching.match import Anywhere
    from vision_server.serve.inputs import GivenCamera


def read_set(
    options: Namespace, camera: Camera, table: dict[str, Any], region: Region | None = None
) -> tuple[ImageSet, dict[str, str], float]:
    """The image files of a command with ``images``, ``colour``, ``exposures`` and ``gamma``.

    Parameters
    ----------
    region
        The part of the frames that is looked at; all without it.

    Returns
    -------
    The set; the names of its different pictures, and what file each is of; how well the tone curve is known,
    px, see `file_tone`.
    """
    from vision_server.channels.image_files import read_image_set
    from vision_server.channels.tone import file_tone
    from vision_server.image_set import ImageSet
    from vision_server.serve.inputs import told_raw

    pictures = read_image_set(options.images, told_raw(table), options.colour)
    files = [picture.file for picture in pictures]
    gammas, tone_sd_px = file_tone(files, options.gamma or table.get("gamma"))
    check_image_size(files[0], pictures[0].pixels.shape, camera)
    times = exposures_of(options, pictures, gammas)
    width, height = camera.width, camera.height
    if region is not None:
        left, top, right, bottom = region
        width, height = right - left, bottom - top
        for number, whole in enumerate(pictures):
            pictures[number] = replace(whole, pixels=whole.pixels[top:bottom, left:right].copy())
    image_set = ImageSet(width, height)
    named = {f"i{number}": picture for number, picture in enumerate(pictures, start=1)}
    for (name, picture), exposure, curve in zip(named.items(), times, gammas, strict=True):
        image_set.add(name, picture.pixels, exposure, curve)
        if (first := image_set.images[name].repeats) is not None:
            warn(f"{picture} is the same picture as {named[first]}: it is not counted again.")
        if (moved := image_set.moved(name)) is not None:
            warn_of_movement(picture, moved)
    return image_set, {name: str(named[name]) for name in image_set.distinct(list(named))}, tone_sd_px


def exposures_of(options: Namespace, pictures: Sequence[Picture], gamma: Sequence[float]) -> list[float]:
    """Relative exposures of ``images``: as told, or where an image shows it by itself, which is said.

    Raises
    ------
    BadInput
        As in `parse_exposures`.
    """
    from vision_server.channels.depth import rounded
    from vision_server.channels.noise import SATURATED_GREY
    from vision_server.channels.overexposure import overexposures

    if options.exposures is not None or len(options.images) < 2:
        told = parse_exposures(options.exposures, len(options.images))
        return [told[picture.number] for picture in pictures]
    bands: dict[int, list[Picture]] = {}
    for picture in pictures:
        bands.setdefault(picture.number, []).append(picture)
    greys = [_mean_of(colours) for colours in bands.values()]
    curves = [gamma[pictures.index(colours[0])] for colours in bands.values()]
    found = overexposures(greys, curves)
    for colours, grey, exposure in zip(bands.values(), greys, found, strict=True):
        file = colours[0].file
        if exposure > 1.0 and rounded(grey).min() >= SATURATED_GREY:
            warn(f"{file} is white all over and shows no edge.")
        elif exposure > 1.0:
            warn(
                f"{file} is brighter than all others and counts as exposed"
                f" {exposure:.1f} times as long. Give --exposures where they are known."
            )
    return [found[picture.number] for picture in pictures]


def _mean_of(colours: Sequence[Picture]) -> Pixels:
    """The grey of an image's colours, of their depth."""
    import numpy as np

    if len(colours) == 1:
        return colours[0].pixels
    mean: Pixels = np.mean([one.pixels for one in colours], axis=0).astype(colours[0].pixels.dtype)
    return mean


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
            f"--exposures names {counted(len(exposures), 'number')} for {counted(count, 'image')}.",
            "Give one for each.",
        )
    if not all(math.isfinite(e) and e > 0.0 for e in exposures):
        raise BadInput(f"--exposures {text!r} must be positive numbers.")
    return exposures


def check_image_size(image: Path, shape: tuple[int, ...], camera: Camera) -> None:
    """Raise BadInput for an image (H, W) of another size than the camera's."""
    height, width = shape
    if (width, height) != (camera.width, camera.height):
        raise BadInput(
            f"{image} has {width}x{height} px, the camera {camera.width}x{camera.height}.",
            "Give the camera model of the image's size.",
        )


def warn_of_movement(image: Picture, moved: Movement) -> None:
    """Say that an image of a set shows something elsewhere than those before it."""
    (dx, dy), (left, top, right, bottom) = moved
    warn(
        f"{image} shows what lies in x {left} to {right}, y {top} to {bottom} px"
        f" elsewhere than all images before it, by {dx:.0f}, {dy:.0f} px."
        " A set is of one scene: leave the image out if this moved."
    )


def started_at(options: Namespace, model: Model, given: GivenCamera) -> Pose | Anywhere:
    """Where a command with ``seed_pose`` looks first; what is doubtful of the model is said."""
    from vision_server.serve.inputs import model_warning, read_seed_pose

    seed_pose = None if options.seed_pose is None else read_seed_pose(options.seed_pose, model)
    if (doubt := model_warning(model, given.camera, seed_pose)) is not None:
        warn(doubt)
    return given.anywhere(model) if seed_pose is None else seed_pose


def write_overlay(
    path: Path,
    pixels: Any,
    model: Model,
    camera: Camera,
    pose: Pose | None,
    support: dict[int, float] | None = None,
) -> None:
    """The model at a pose over an image, see `draw_overlay`; raises as `write_picture`."""
    from report.overlay import draw_overlay

    write_picture(path, draw_overlay(pixels, model, camera, pose, support))


def write_picture(path: Path, picture: Grey) -> None:
    """Write a picture of the kind that its name says, see `picture_file`.

    Raises
    ------
    BadInput
        The file cannot be written.
    """
    import cv2

    write_file(path, cv2.imencode(path.suffix or ".png", picture)[1].tobytes())


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
