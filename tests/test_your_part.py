"""docs/your_part.md is followed literally, with a part and photographs of it that are drawn at random."""

import json
import re
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from benchmarks.machined_parts import machined, surface_of
from benchmarks.synthetic_parts import random_view, rendered
from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from numerics.arrays import Field, Grey
from tests.followed_pages import blocks_of, clean_copy, runs
from tests.vision_server.boards import write_boards
from vision_server.channels.image_files import read_grey

pytestmark = pytest.mark.slow

__all__ = ["clean_copy"]

CAMERA = Camera(640, 480, 768.0, 768.0, 322.0, 236.0, (-0.1, 0.03, 0.0, 0.0, 0.0))
GAMMA = 2.2
CORNERS = (9, 6)
LIMITS = (1.0, 0.01)  # right: degrees, share of the range; the calibration's error included


def write_stl(file: Path, model: Model) -> None:
    """Binary STL in millimetres."""
    corners = 1e3 * model.vertices[model.triangles]
    facet = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    facets = np.zeros(len(corners), facet)
    facets["corners"] = corners
    file.write_bytes(bytes(80) + np.uint32(len(corners)).tobytes() + facets.tobytes())


def through_the_lens(model: Model, pose: Pose, seed: int) -> Field:
    """As the lens shows it under one lamp."""
    ideal = rendered(model, CAMERA.ideal, pose, np.random.default_rng(seed))
    row, column = np.mgrid[: CAMERA.height, : CAMERA.width]
    sources = CAMERA.undistort_points(np.column_stack([column.ravel(), row.ravel()]).astype(np.float64))
    x, y = sources.T.reshape(2, CAMERA.height, CAMERA.width).astype(np.float32)
    seen = cv2.remap(ideal.astype(np.float32), x, y, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(seen, np.float32)


def photographed(seen: Field, exposure: float) -> Grey:
    """As a webcam shows it, by its tone curve."""
    linear = np.clip(exposure * seen / 255.0, 0.0, 1.0)
    return np.asarray(np.round(255.0 * linear ** (1.0 / GAMMA)), np.uint8)


def put_what_the_reader_has(folder: Path, seed: int) -> Pose:
    """The part's file and its photographs; its true pose, which nothing reads."""
    folder.mkdir()
    rng = np.random.default_rng(seed)
    model = Model.of_surface("part", surface_of(machined(rng, 48)))
    write_stl(folder / "part.stl", model)
    write_boards(folder / "boards", CAMERA, CORNERS, 12)
    pose = random_view(rng, model, CAMERA)
    one, other = (through_the_lens(model, pose, 10 * seed + lamp) for lamp in (1, 2))
    for number, (seen, exposure) in enumerate([(one, 1.0), (other, 1.0), (one, 0.5)], start=1):
        cv2.imwrite(str(folder / f"photo{number}.png"), photographed(seen, exposure))
    return pose


def is_shown(line: str, shown: str) -> bool:
    """Whether a line was shown, whatever its numbers."""
    pattern = re.sub(r"\d+(\\\.\d+)?", r"[-\\d.]+", re.escape(line.strip()))
    return re.search(pattern.replace("images", "images?"), shown) is not None


def is_right(told: dict[str, Any], true: Pose) -> bool:
    pose = Pose.from_dict(told)
    return pose.error_to(true).within(*LIMITS)


def follow(folder: Path) -> None:
    """Do what the page says."""
    shown = ""
    for language, file, text in blocks_of("your_part.md"):
        if language == "sh":
            shown = runs(text, folder)
        elif language == "text":
            missing = [line for line in text.splitlines() if not is_shown(line, shown)]
            assert not missing, f"{missing} is not in\n{shown}"
        else:
            (folder / file).write_text(text)


@pytest.mark.parametrize("seed", [12])
def test_the_page_goes_as_it_says(clean_copy: Path, seed: int) -> None:
    true = put_what_the_reader_has(clean_copy / "mine", seed)
    follow(clean_copy)
    mine = clean_copy / "mine"
    simulated, session, pose = (
        json.loads((mine / name).read_text())
        for name in ("simulated/result.json", "session/result.json", "pose.json")
    )
    assert simulated["error"]["rotation_deg"] < LIMITS[0]
    assert is_right(pose["pose"], true)
    assert is_right(session["pose"], true)
    assert session["estimated_with"]["parameters"]["seed_pose"] == "anywhere"
    assert read_grey(mine / "found.png").shape == (480, 640)


def test_every_block_is_one_that_is_followed() -> None:
    kinds = [(language, bool(file)) for language, file, _ in blocks_of("your_part.md")]
    assert set(kinds) == {("sh", False), ("text", False), ("toml", True)}
    assert kinds.count(("sh", False)) >= 7
