"""A film of frames with the target's model drawn over each."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import cv2

from bridge.errors import BadInput, DeviceError
from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from numerics.arrays import Grey
from report.overlay import FRAME, HALO, draw_overlay

CODEC = "mp4v"  # OpenCV's own, in every build
ENDINGS = (".mp4", ".mov")  # containers that hold it
TEXT_AT, TEXT_SIZE, FONT = (10, 24), 0.6, cv2.FONT_HERSHEY_SIMPLEX


class Film:
    """A video file that grows frame by frame.

    Parameters
    ----------
    path : with one of ENDINGS.
    rate : frames a second.

    Raises
    ------
    BadInput : it cannot be written.
    """

    def __init__(self, path: Path, model: Model, camera: Camera, rate: float) -> None:
        self._path, self._model, self._camera = path, model, camera
        if path.suffix.lower() not in ENDINGS:
            raise BadInput(f"cannot write the film {path}; its name must end in {' or '.join(ENDINGS)}")
        code = cv2.VideoWriter.fourcc(*CODEC)
        self._video = cv2.VideoWriter(str(path), code, rate, (camera.width, camera.height))
        if not self._video.isOpened():
            raise BadInput(f"cannot write the film {path}; give a .mp4 in a folder that exists")
        self._count = 0

    def add(self, pixels: Grey, pose: Pose | None, support: Mapping[int, float] | None, words: str) -> None:
        """One frame (H, W), with the model at a pose as in `draw_overlay`, and some words on it."""
        drawn = draw_overlay(pixels, self._model, self._camera, pose, support, inset=False)
        for colour, width in ((HALO, 3), (FRAME, 1)):
            cv2.putText(drawn, words, TEXT_AT, FONT, TEXT_SIZE, colour, width, cv2.LINE_AA)
        self._video.write(drawn)
        self._count += 1

    def close(self) -> None:
        """Finish the file.

        Raises
        ------
        DeviceError : not all of its frames are there; of a disk that is full OpenCV says nothing.
        """
        self._video.release()
        written = cv2.VideoCapture(str(self._path))
        count = int(written.get(cv2.CAP_PROP_FRAME_COUNT))
        written.release()
        if count < self._count:
            raise DeviceError(f"The film {self._path} cannot be written to its end.", "Is the disk full?")
