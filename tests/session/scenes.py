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


@cache
def small(scenario: str = "nominal") -> Path:
    """A file of this scenario whose camera has small images, as long as the tests run."""
    told = tomllib.loads((ROOT / "scenarios" / f"{scenario}.toml").read_text())
    file = _folder() / f"{scenario}.toml"
    file.write_text(tomli_w.dumps(told | {"camera": told.get("camera", {}) | SIZE}))
    return file


@cache
def _folder() -> Path:
    goes_with_the_tests = os.environ["XDG_RUNTIME_DIR"]
    return Path(tempfile.mkdtemp(prefix="scenes-", dir=goes_with_the_tests))
