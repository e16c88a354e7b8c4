"""Saving captured frames as a stack that can be replayed, without making captures wait."""

from __future__ import annotations

import json
import queue
import shutil
import threading
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from bridge.errors import BadInput
from bridge.messages import Describe, Settings
from geometry.pose import Pose

STACK_FILE = "stack.toml"
FOLDER = "images"


@dataclass(frozen=True)
class Frame:
    """One recorded frame: its image's name, and the settings it was taken under."""

    image: str
    settings: Settings


@dataclass(eq=False)
class Recorder:
    """Writes frames to ``out/images/`` in its own thread: one PNG each, and a stack.toml of kind "frames".

    Parameters
    ----------
    out
        Folder of the run.
    head
        Text of the stack file before its frames, from `stack_head`.
    model
        The target's model file; a copy joins the frames, so that the folder can be moved.

    Raises
    ------
    BadInput
        The folder cannot be written.
    """

    out: Path
    head: str
    model: Path
    frames: list[Frame] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.folder = self.out / FOLDER
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            copy = self.folder / self.model.name
            if not (copy.exists() and copy.samefile(self.model)):
                shutil.copyfile(self.model, copy)
            self._write_stack()
        except OSError as error:
            raise BadInput(
                f"Cannot write to {self.folder}: {error.strerror or error}.", "Choose another folder."
            ) from error
        self._failure: OSError | None = None
        self._queue: queue.Queue[tuple[Frame, NDArray[np.uint8]] | None] = queue.Queue()
        self._thread = threading.Thread(target=self._run, name="recorder", daemon=True)
        self._thread.start()

    def save(self, image: str, settings: Settings, pixels: NDArray[np.uint8]) -> None:
        """Hand a frame over; it is on the disk after `flush`.

        Raises
        ------
        BadInput
            An earlier frame could not be written.
        """
        self._check()
        self._queue.put((Frame(image, settings), pixels))

    def flush(self) -> None:
        """Wait until every frame is on the disk."""
        self._queue.join()
        self._check()

    def close(self) -> None:
        """Write what is left and stop."""
        self._queue.put(None)
        self._thread.join()

    def _check(self) -> None:
        if self._failure is not None:
            reason = self._failure.strerror or self._failure
            raise BadInput(
                f"Cannot write to {self.folder}: {reason}.", "Free space there, or choose another folder."
            )

    def _run(self) -> None:
        while True:
            item = self._queue.get()
            try:
                if item is None:
                    return
                frame, pixels = item
                encoded, content = cv2.imencode(".png", pixels, [cv2.IMWRITE_PNG_COMPRESSION, 1])
                if not encoded:
                    raise OSError(f"{frame.image}.png cannot be encoded")
                (self.folder / f"{frame.image}.png").write_bytes(content.tobytes())
                self.frames.append(frame)
                self._write_stack()
            except OSError as error:
                self._failure = error
            finally:
                self._queue.task_done()

    def _write_stack(self) -> None:
        text = self.head + "".join(_frame_text(frame) for frame in self.frames)
        new = self.folder / f"{STACK_FILE}.new"
        new.write_text(text, encoding="utf-8")
        new.replace(self.folder / STACK_FILE)


def recorded_frames(out: Path) -> list[Frame]:
    """The frames that an earlier session saved in ``out``.

    Raises
    ------
    BadInput
        No readable stack file there.
    """
    path = out / FOLDER / STACK_FILE
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise BadInput(
            f"Cannot read {path}: {error}.", "Resume from the folder of an earlier run."
        ) from error
    return [
        Frame(
            Path(entry["image"]).stem,
            Settings(
                lights=tuple(entry["lights"]),
                shutter_s=entry["shutter_s"],
                aperture=entry["aperture"],
                focal_length_mm=entry.get("focal_length_mm"),
                focus_m=entry.get("focus_m"),
            ),
        )
        for entry in data.get("frames", [])
    ]


def stack_head(describe: Describe, camera: Mapping[str, Any], model: str, unit: str, seed_pose: Pose) -> str:
    """The stack file's text before its frames: camera, lights and target."""
    parts = ['kind = "frames"\n', _table("[camera]", camera)]
    for light in describe.lights:
        values: dict[str, Any] = {"name": light.name, "levels": light.levels, "power": light.power}
        if light.position is not None:
            values["position"] = list(light.position)
        parts.append(_table("[[lights]]", values))
    parts.append(_table("[target]", {"model": model, "unit": unit}))
    parts.append(_table("[target.seed_pose]", seed_pose.to_dict()))
    return "\n".join(parts)


def _frame_text(frame: Frame) -> str:
    settings = frame.settings
    values: dict[str, Any] = {
        "image": f"{frame.image}.png",
        "lights": list(settings.lights),
        "shutter_s": settings.shutter_s,
        "aperture": settings.aperture,
    }
    if settings.focal_length_mm is not None:
        values["focal_length_mm"] = settings.focal_length_mm
    if settings.focus_m is not None:
        values["focus_m"] = settings.focus_m
    return "\n" + _table("[[frames]]", values)


def _table(name: str, values: Mapping[str, Any]) -> str:
    return f"{name}\n" + "".join(f"{key} = {_value(value)}\n" for key, value in values.items())


def _value(value: str | float | Sequence[float]) -> str:
    """A TOML value; JSON strings, numbers and lists of numbers are TOML as they stand."""
    return json.dumps(value, ensure_ascii=False)
