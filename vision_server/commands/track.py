"""`python -m vision_server track`: the pose of a moving target in every frame."""

from __future__ import annotations

import json
import os
import signal
from argparse import ArgumentParser, Namespace
from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

from bridge.command_line import add_keys, number, whole_number
from bridge.errors import EXIT_NO_POSE, BadInput
from bridge.stopping import STATUS, Stopping
from vision_server.commands.files import started_at
from vision_server.commands.options import (
    add_colour,
    add_edge_radius,
    add_gamma,
    add_model_and_camera,
    add_seed,
    check_outputs,
    told_edge_radius,
    warn,
)

if TYPE_CHECKING:
    from vision_server.serve.inputs import GivenCamera
    from vision_server.tracking.sources import Frame, Source
    from vision_server.tracking.tracked import Tracked
    from vision_server.tracking.tracker import Tracker


FPS = 30.0  # of a film, where nothing tells
QUIET = "-8"  # of FFmpeg's levels


def add_options(parser: ArgumentParser) -> None:
    """Options of the command."""
    parser.description = (
        f"{parser.description} Exit status: 0 found in some frame, 3 in none, 2 bad input, 4 a camera or "
        f"server that failed, {STATUS + signal.SIGINT} Ctrl-C, {STATUS + signal.SIGTERM} SIGTERM."
    )
    parser.add_argument(
        "frames", metavar="FRAME", nargs="+",
        help="Image files in order; or one folder of them, one video, one camera (/dev/video0), "
        "one image server (ipc:///path).",
    )  # fmt: skip
    add_model_and_camera(parser, or_described=True)
    add_keys(parser)
    parser.add_argument(
        "--seed-pose", type=Path, metavar="TOML",
        help="File with [target.seed_pose], or one object of --json (.json), where the target is at first; "
        "without it, anywhere.",
    )  # fmt: skip
    parser.add_argument("--json", action="store_true", help="One JSON object a frame on stdout.")
    parser.add_argument(
        "--overlay", type=Path, metavar="OUT.mp4", help="A film of the frames with the model drawn."
    )
    parser.add_argument(
        "--fps", type=number(0.01, 1e5), metavar="N",
        help="Frames a second of image files; untold, they are followed as 30, and have no time.",
    )  # fmt: skip
    parser.add_argument(
        "--switch-lights", action="store_true", help="Of an image server: each frame under another light."
    )
    parser.add_argument(
        "--count", type=whole_number(1), metavar="N", help="End after so many frames; else Ctrl-C ends."
    )
    add_colour(parser, several=False)
    add_edge_radius(parser)
    add_seed(parser)
    add_gamma(parser)


def run(options: Namespace) -> int:
    """Track and print; the exit status."""
    from bridge.keys import client_keys
    from vision_server.channels.image_files import PLAIN
    from vision_server.serve.described import camera_doubt, used_camera
    from vision_server.serve.inputs import read_camera_file, told_raw
    from vision_server.tracking.sources import Source, is_served

    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", QUIET)  # what counts of videos is said here
    check_outputs(options, ["frames", "model", "camera", "seed_pose"], ["overlay"])
    _check_source(options, is_served(options.frames))
    given = None if options.camera is None else read_camera_file(options.camera)
    raw = PLAIN if given is None else told_raw(given.table)
    curve = client_keys(options.keys, "vision_server", "image_server")
    source = Source(options.frames, raw, options.switch_lights, curve, options.colour)
    camera = used_camera(given, source.camera, options.frames[0])
    if (doubt := camera_doubt(camera.camera, source.camera)) is not None:
        warn(doubt)
    gamma = options.gamma or (given.table.get("gamma") if given else None)
    tracker = _tracker(options, camera, gamma, source.gamma)
    found = _followed(options, tracker, source)
    if source.warning:
        warn(source.warning)
    if not found:
        warn(_in_none(options, tracker.model.diameter))
    return 0 if found else EXIT_NO_POSE


def _in_none(options: Namespace, diameter_m: float) -> str:
    """What may help where the target was found in no frame."""
    where = "" if options.seed_pose is None else " Leave out --seed-pose to look everywhere."
    return (
        f"the target was found in no frame. The model is {diameter_m:.3g} m across: check --unit, and fx and "
        f"fy of the camera.{where} Of a single frame, estimate says more."
    )


def _check_source(options: Namespace, served: bool) -> None:
    """Refuse what fits only another source."""
    if options.camera is None and not served:
        raise BadInput(
            "There is no camera.", "Give --camera FILE; only an image server may describe its own."
        )
    if options.colour != "grey" and served:
        raise BadInput("An image server's frames are grey.", "Leave out --colour.")
    if options.keys is not None and not served:
        raise BadInput("Only an image server takes --keys.", "Give its endpoint as FRAME.")


def _followed(options: Namespace, tracker: Tracker, source: Source) -> int:
    """Track, print and film each frame; in how many the target was found."""
    from vision_server.channels.depth import rounded

    found, film = 0, None
    with Stopping() as stopping:
        if options.overlay is not None:
            from report.film import Film

            rate = source.rate() or options.fps or FPS
            film = Film(options.overlay, tracker.model, tracker.camera, rate)
        try:
            for frame in stopping.each(_timed(islice(source, options.count), options.fps)):
                told = _stepped(tracker, frame)
                found += told.pose is not None
                _show(told, frame, options.json)
                if film is not None:
                    film.add(rounded(frame.pixels), told.pose, told.support, f"{told.frame} {told.state}")
        finally:
            if film is not None:
                film.close()
    return found


def _timed(frames: Iterable[Frame], fps: float | None) -> Iterator[Frame]:
    """Frames whose times nothing tells with those of a rate, if there is one."""
    for index, frame in enumerate(frames):
        yield frame if frame.time_s is not None or fps is None else replace(frame, time_s=index / fps)


def _stepped(tracker: Tracker, frame: Frame) -> Tracked:
    """What a frame says; one that is refused is named."""
    try:
        return tracker.step(frame.pixels, frame.time_s)
    except BadInput as error:
        raise BadInput(f"{frame.name}: {error.message}", error.hint) from error


def _tracker(
    options: Namespace, camera: GivenCamera, given: float | None, file_gamma: float | None
) -> Tracker:
    from vision_server.channels.tone import KNOWN_TONE_SD_PX, NOMINAL_TONE_SD_PX
    from vision_server.serve.inputs import read_model
    from vision_server.tracking.tracker import Tracker

    model = read_model(options.model, options.unit)
    start = started_at(options, model, camera)
    nominal = given is None and file_gamma is not None
    gamma = given or file_gamma or 1.0
    return Tracker(
        model,
        camera.camera,
        start,
        gamma,
        NOMINAL_TONE_SD_PX if nominal else KNOWN_TONE_SD_PX,
        options.seed,
        told_edge_radius(options.edge_radius, camera, model),
    )


def _show(told: Tracked, frame: Frame, as_json: bool) -> None:
    if told.note:
        warn(f"{frame.name}: {told.note}")
    if as_json:
        from vision_server.serve.results import tracked_result

        time = {} if frame.time_s is None else {"time": frame.time_s}
        print(json.dumps(tracked_result(told) | time, allow_nan=False), flush=True)
        return
    place = ""
    if told.pose is not None:
        x, y, z = told.pose.translation
        place = f"  {x:+.4f} {y:+.4f} {z:+.4f} m"
    print(f"{told.frame:6d}  {told.state:<6}{place}  {1e3 * told.seconds:.1f} ms processor time", flush=True)
