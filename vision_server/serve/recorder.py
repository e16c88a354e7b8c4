"""Saving frames as a stack that can be replayed, and what was found in them, while captures go on."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import msgspec

from bridge.arrays import FramePixels
from bridge.errors import BadInput
from bridge.messages import Describe, Settings
from geometry.camera import Camera
from geometry.drawn_wireframes import WIREFRAMES, wireframe_line
from geometry.model import Model
from geometry.pose import Pose
from geometry.wireframe import visible_runs
from stack.format import FrameTable
from stack.write import described, file_sha256, frame_table, write_png, write_table
from vision_server.edges.edge_map import EdgeMap
from vision_server.edges.suppression import edge_picture

FOLDER = "images"
PNG_COMPRESSION = 1  # of 9: the fastest that compresses, since an estimate waits for the disk


@dataclass(eq=False)
class Recorder:
    """Writes frames to ``out/images/`` in its own thread: one PNG each, and a stack.toml of kind "frames";
    beside them, for people, the edge maps that estimates saw, and the model at the poses that they found.

    Parameters
    ----------
    out
        Folder of the run.
    describe
        Camera, lights and target of the session; a copy of the model file joins the frames, so that the
        folder can be moved.
    frames
        What an earlier session has saved there, by name of the image.

    Raises
    ------
    BadInput
        The folder cannot be written.
    """

    out: Path
    describe: Describe
    frames: dict[str, FrameTable] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.folder = self.out / FOLDER
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            self._head = described(self.folder, self.describe)
        except OSError as error:
            raise BadInput(
                f"Cannot write to {self.folder}: {error.strerror or error}.", "Choose another folder."
            ) from error
        self._write_stack()
        self._failure: BadInput | None = None
        self._queue: queue.Queue[Callable[[], None] | None] = queue.Queue()
        self._thread = threading.Thread(target=self._run, name="recorder", daemon=True)
        self._thread.start()

    def save(self, image: str, settings: Settings, pixels: FramePixels) -> None:
        """Hand a frame over; it is on the disk after `flush`.

        Raises
        ------
        BadInput
            An earlier frame could not be written.
        """
        self._check()
        self._queue.put(partial(self._write_frame, image, settings, pixels))

    def draw(self, image: str, edges: EdgeMap) -> None:
        """Hand over the edge map of a set that this image was the last to join, as a picture for people."""
        file = self.folder / f"{image}-edges.png"
        self._queue.put(lambda: write_png(file, edge_picture(edges), PNG_COMPRESSION))

    def outline(self, model: Model, camera: Camera, pose: Pose) -> None:
        """Hand over a pose that was found: what is seen of the model there becomes a line of WIREFRAMES."""
        self._queue.put(lambda: self._write_outline(model, camera, pose))

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
            raise self._failure

    def _run(self) -> None:
        while (write := self._queue.get()) is not None:
            try:
                write()
            except BadInput as error:
                self._failure = error
            finally:
                self._queue.task_done()

    def _write_frame(self, image: str, settings: Settings, pixels: FramePixels) -> None:
        file = f"{image}.png"
        write_png(self.folder / file, pixels, PNG_COMPRESSION)
        table = frame_table(file, settings)
        self.frames[image] = msgspec.structs.replace(table, sha256=file_sha256(self.folder / file))
        self._write_stack()

    def _write_outline(self, model: Model, camera: Camera, pose: Pose) -> None:
        line = wireframe_line(pose, visible_runs(model, camera, pose))
        file = self.folder / WIREFRAMES
        try:
            with file.open("ab") as out:
                out.write(line)
        except OSError as error:
            raise BadInput(f"Cannot write {file}: {error.strerror}.", "Is there space?") from error

    def _write_stack(self) -> None:
        frames = msgspec.to_builtins(list(self.frames.values()))
        write_table(self.folder, {"kind": "frames", **self._head, "frames": frames})
