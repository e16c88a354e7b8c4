"""A frame taken into the set of a session, and what is answered (docs/protocol.md: `capture`, `add`)."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import msgspec

from bridge.arrays import FramePixels
from bridge.messages import Settings
from vision_server.serve.task import PoseTask


def taken(
    task: PoseTask,
    image: str,
    applied: Settings,
    pixels: FramePixels,
    verified: bool,
    capture_s: float,
    events: Sequence[str] = (),
) -> dict[str, Any]:
    """Take a frame into the set; what is answered is on the disk, so that a session can be resumed.

    ``events`` were published with it: it is the first to see them.
    """
    began = time.perf_counter()
    if task.recorder is not None:
        task.recorder.save(image, applied, pixels)  # while its edges are looked for
    statistics = task.add(image, pixels, applied)
    moved = task.images.moved(image)
    cause = doubt = None
    task.hear(events, image)
    if task.to_be_judged(image):
        from vision_server.serve.surprises import surprise_of

        cause, doubt = surprise_of(task, image)
    if task.recorder is not None:
        task.recorder.flush()
    return {
        "image": image,
        "applied": applied,
        "verified": verified,
        "statistics": statistics,
        "moved": None if moved is None else moved._asdict(),
        "repeats": task.images.images[image].repeats,
        "surprise": cause and msgspec.to_builtins(cause),
        "doubt": doubt and msgspec.to_builtins(doubt),
        "seconds": {"capture": capture_s, "edges": time.perf_counter() - began},
    }
