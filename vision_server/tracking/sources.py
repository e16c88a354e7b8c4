"""Frames from image files, a folder, a video, a camera or an image server, one at a time."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from bridge.endpoints import CurveClient
from bridge.errors import BadInput, DeviceError, LightsAndCameraError
from bridge.messages import CameraDescription
from stack.format import STACK_FILE
from stack.read import recorded_frames
from vision_server.channels.depth import Pixels, Raw
from vision_server.channels.image_files import PLAIN, one_band, read_pixels
from vision_server.channels.tone import file_gamma
from vision_server.tracking.served_frames import SCHEMES, ServedFrames

IMAGES = {".png", ".jpg", ".jpeg", ".tif", ".tiff", ".pgm", ".ppm", ".pnm", ".bmp", ".webp"}
DRAWN = ("-overlay", "-edges")  # pictures for people, beside a session's frames
DEVICE = "/dev/video"
RATES = (1.0, 1000.0)  # frames a second of films; files without an even rate tell e.g. 90000 (by hand)


@dataclass(frozen=True, eq=False)
class Frame:
    """One frame.

    Attributes
    ----------
    name : of its file, or its number in the video.
    pixels : grey, (H, W): see `channels.depth`.
    time_s : when it was taken; None where nothing tells.
    """

    name: str
    pixels: Pixels
    time_s: float | None = None


def _frames_of(folder: Path) -> list[Path]:
    """Those of its stack, in their order; else all images by name and number.

    But what sessions draw, and hidden files: `._x.png` is what macOS knows of `x.png`, and no image.
    """
    recorded = recorded_frames(folder).values() if (folder / STACK_FILE).is_file() else ()
    if recorded:
        return [folder / frame.image for frame in recorded]
    images = (file for file in folder.iterdir() if file.suffix.lower() in IMAGES)
    meant = (file for file in images if not (file.name.startswith(".") or file.stem.endswith(DRAWN)))
    return sorted(meant, key=_by_number)


def _by_number(file: Path) -> tuple[list[str | int], str]:
    """Names in the order in which people count: f2 before f10."""
    parts = re.split("([0-9]+)", file.name)
    return [int(part) if place % 2 else part for place, part in enumerate(parts)], file.name


def _is_live(place: Path) -> bool:
    """Whether it is a camera, not a file."""
    return str(place).startswith(DEVICE)


def _opened(place: Path) -> cv2.VideoCapture:
    """A video or camera, to be released; raises BadInput where there is none."""
    if not place.exists():
        raise BadInput(f"There is no {place}.", "Check the path.")
    video = cv2.VideoCapture(str(place))
    if not video.isOpened():
        raise BadInput(f"{place} is no video or camera that can be read.", "Is the file whole?")
    return video


def is_served(words: Sequence[str]) -> bool:
    """Whether the words of a command line are an image server."""
    return len(words) == 1 and words[0].startswith(SCHEMES)


class Source:
    """What the words of a command line stand for.

    Parameters
    ----------
    words : image files, or one folder of them, one video, one camera (/dev/videoN) or one image server
        (ipc:// or tcp://).
    raw : what the pixels of image files are; of unknown depth, the least that holds the values so far.
    switch : of an image server's lights, one is on in each frame, in turn.
    curve : keys, for an image server that wants them.
    colour : what is taken of colour frames, see `read_pixels`; an image server's are grey.

    Attributes
    ----------
    camera : what an image server tells of its camera; else None.
    gamma : what the files tell of their tone curve, linear = grey^gamma; None if nothing.
    warning : after the last frame, what was wrong with the source; empty mostly.

    Raises
    ------
    BadInput : nothing there, or nothing that can be read.
    DeviceError : while it is read, a camera or image server that fails.
    """

    def __init__(
        self,
        words: Sequence[str],
        raw: Raw = PLAIN,
        switch: bool = False,
        curve: CurveClient | None = None,
        colour: str = "grey",
    ) -> None:
        self._raw, self._colour = raw, colour
        self.warning = ""
        self.camera: CameraDescription | None = None
        self._files: list[Path] = []
        self._video: Path | None = None
        self._server: ServedFrames | None = None
        if is_served(words):
            self._server = ServedFrames(words[0], switch, curve)
            self.gamma, self.camera = self._server.gamma, self._server.camera
            return
        if switch:
            raise BadInput("Only an image server's lights can be switched.", "Give its endpoint as FRAME.")
        self._open([Path(word) for word in words])
        told = file_gamma(self._files[0]) if self._files else 1.0
        self.gamma = None if told == 1.0 else told

    def _open(self, words: Sequence[Path]) -> None:
        if len(words) == 1 and words[0].is_dir():
            self._files = _frames_of(words[0])
            if not self._files:
                raise BadInput(f"{words[0]} holds no images.", f"Endings: {' '.join(sorted(IMAGES))}.")
        elif all(word.suffix.lower() in IMAGES for word in words):
            self._files = list(words)
        elif len(words) == 1:
            self._video = words[0]
        else:
            strange = next(word for word in words if word.suffix.lower() not in IMAGES)
            raise BadInput(f"{strange} is no image file.", "Give images, or one folder, video or camera.")

    def rate(self) -> float | None:
        """Frames a second that a video file tells; None where it tells none, and of any other source."""
        if self._video is None or _is_live(self._video):
            return None
        video = _opened(self._video)
        rate = float(video.get(cv2.CAP_PROP_FPS))
        video.release()
        return rate if RATES[0] <= rate <= RATES[1] else None

    def __iter__(self) -> Iterator[Frame]:
        if self._server is not None:
            return self._captured(self._server)
        if self._video is None:
            return self._read()
        return self._recorded(self._video)

    def _captured(self, server: ServedFrames) -> Iterator[Frame]:
        number = 0
        try:
            with closing(server):
                for pixels, taken_s in server.frames(self._raw):
                    yield Frame(f"{server.endpoint} {number}", pixels, taken_s)
                    number += 1
        except LightsAndCameraError as error:
            if number == 0 or isinstance(error, BadInput):
                raise
            raise DeviceError(
                f"{server.endpoint} ends after {number} frames: {error.message}", error.hint
            ) from error

    def _read(self) -> Iterator[Frame]:
        seen = 0
        for file in self._files:
            pixels = read_pixels(file, self._colour)
            if pixels.dtype == np.uint16:
                seen = max(seen, int(pixels.max()))
            yield Frame(str(file), self._raw.grey(pixels, seen))

    def _recorded(self, place: Path) -> Iterator[Frame]:
        live = _is_live(place)
        video = _opened(place)
        try:
            rate, count = video.get(cv2.CAP_PROP_FPS), int(video.get(cv2.CAP_PROP_FRAME_COUNT))
            number = 0
            while True:
                there, pixels = video.read()
                if not there:
                    break
                passed = video.get(cv2.CAP_PROP_POS_MSEC) / 1e3
                if live:
                    passed = time.monotonic()
                elif passed == 0.0 and number > 0 and rate > 0.0:
                    passed = number / rate
                grey = np.asarray(one_band(pixels, self._colour), dtype=np.uint8)
                yield Frame(f"{place} {number}", grey, passed)
                number += 1
            if live:
                raise DeviceError(f"{place} ends after {number} frames.", "Is the camera still there?")
            if number < count or number == 0:
                end = f"of {count} frames" if count > 0 else "frames"
                self.warning = f"{place} ends after {number} {end}."
        finally:
            video.release()
