"""Scenes in small images, for sessions that show how one ends or goes on, whatever it sees."""

import os
import tempfile
import tomllib
from functools import cache
from pathlib import Path

import tomli_w

ROOT = Path(__file__).resolve().parents[2]
SIZE = {"width": 320, "height": 240}
"""A quarter of the pixels that a session has by default, of the same field of view."""


def small(scenario: str = "nominal") -> Path:
    """A file of this scenario whose camera has small images, as long as the servers that are kept now."""
    return _written(scenario, os.environ["XDG_RUNTIME_DIR"])


@cache
def _written(scenario: str, goes_with: str) -> Path:
    told = tomllib.loads((ROOT / "scenarios" / f"{scenario}.toml").read_text())
    file = _folder(goes_with) / f"{scenario}.toml"
    file.write_text(tomli_w.dumps(told | {"camera": told.get("camera", {}) | SIZE}))
    return file


@cache
def _folder(goes_with: str) -> Path:
    return Path(tempfile.mkdtemp(prefix="scenes-", dir=goes_with))
