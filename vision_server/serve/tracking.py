"""Frames of a moving target, as a session's operations take them."""

from __future__ import annotations

from typing import Any

from bridge.arrays import FramePixels
from vision_server.serve.results import tracked_result
from vision_server.serve.task import PoseTask
from vision_server.tracking.tracker import Tracker


def tracked(task: PoseTask, pixels: FramePixels, time_s: float | None) -> dict[str, Any]:
    """The next frame of the session; the first one is looked for around its seed pose."""
    if task.tracker is None:
        tone_sd_px, seed = task.settings.tone_sd_px, task.settings.seed
        task.tracker = Tracker(
            task.model, task.camera, task.seed_pose, task.gamma, tone_sd_px, seed, task.edge_radius_m
        )
    told = task.tracker.step(task.raw.grey(pixels), time_s)
    return {**tracked_result(told), "note": told.note}
