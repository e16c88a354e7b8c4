"""A camera table for tests of its sensor."""

from typing import Any

from stack.format import CameraTable


def camera(**sensor: Any) -> CameraTable:
    """A camera with these keys of `[camera]`, whatever its calibration."""
    return CameraTable(width=1, height=1, fx=1.0, fy=1.0, cx=0.0, cy=0.0, **sensor)
