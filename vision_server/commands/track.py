"""`python -m vision_server track`: the pose of a moving target in every frame."""

from __future__ import annotations

import json
import signal
import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from itertools import islice
from pathlib import Path
from threading import Event
from types import FrameType
from typing import TYPE_CHECKING

from bridge.command_line import number, whole_number
from bridge.errors import EXIT_NO_POSE, BadInput
from vision_server.commands.estimate import started_at
from vision_server.commands.options import (
    add_edge_radius,
    add_gamma,
    add_model_and_camera,
    add_seed,
    told_edge_radius,
    told_gamma,
)

if TYPE_CHECKING:
    from vision_server.serve.inputs import GivenCamera
    from vision_server.tracking.sources import Frame
    from vision_server.tracking.tracked import Tracked
    from vision_server.tracking.tracker import Tracker


EXIT_INTERRUPTED = 130  # as a shell says of a program that Ctrl-C ends
FPS = 30.0  # of a film of image files, where nothing tells


def add_options(parser: ArgumentParser) -> None:
    """Options of the command."""
    parser.description = (
        f"{parser.description} Exit status: 0 found in some frame, 3 in none, 2 bad input, 4 a camera or "
        f"server that failed, {EXIT_INTERRUPTED} stopped by Ctrl-C."
    )
    parser.add_argument(
        "frames", metavar="FRAME", nargs="+",
        help="Image files in order; or one folder of them, one video, one camera (/dev/video0), "
        "one image server (ipc:///path).",
    )  # fmt: skip
    add_model_and_camera(parser)
    parser.add_argument(
        "--seed-pose", type=Path, metavar="TOML",
        help="File with [target.seed_pose], where the target is at first; without it, anywhere.",
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
    add_edge_radius(parser)
    add_seed(parser)
    add_gamma(parser)


def run(options: Namespace) -> int:
    """Track and print; the exit status."""
    from report.errors import ReportError

    try:
        return _tracked(options)
    except ReportError as error:
        raise BadInput(str(error)) from error
    except KeyboardInterrupt:  # what ends a camera; the film is whole
        return EXIT_INTERRUPTED


def _tracked(options: Namespace) -> int:
    from vision_server.channels.depth import rounded
    from vision_server.serve.inputs import read_camera_file, told_raw
    from vision_server.tracking.sources import Source

    camera = read_camera_file(options.camera)
    source = Source(options.frames, told_raw(camera.table), options.switch_lights)
    tracker = _tracker(options, camera, told_gamma(options.gamma, camera.table), source.gamma)
    film = None
    if options.overlay is not None:
        from report.film import Film

        film = Film(options.overlay, tracker.model, tracker.camera, options.fps or FPS)
    found = 0
    try:
        with _ctrl_c() as heed:
            for frame in _timed(islice(source, options.count), options.fps):
                heed()
                told = _stepped(tracker, frame)
                found += told.pose is not None
                _show(told, frame, options.json)
                if film is not None:
                    film.add(rounded(frame.pixels), told.pose, told.support, f"{told.frame} {told.state}")
    finally:
        if film is not None:
            film.close()
    if source.warning:
        print(f"vision_server: {source.warning}", file=sys.stderr)
    return 0 if found else EXIT_NO_POSE


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


@contextmanager
def _ctrl_c() -> Iterator[Callable[[], None]]:
    """Ctrl-C at once, and again by the call that is given, to be made each frame.

    An exception at any place may be caught by a library that is just there.
    """
    pressed = Event()

    def interrupt(signum: int, frame: FrameType | None) -> None:
        pressed.set()
        signal.default_int_handler(signum, frame)

    def heed() -> None:
        if pressed.is_set():
            raise KeyboardInterrupt

    before = signal.signal(signal.SIGINT, interrupt)
    try:
        yield heed
    finally:
        signal.signal(signal.SIGINT, before)


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
        print(f"vision_server: {frame.name}: {told.note}", file=sys.stderr)
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
