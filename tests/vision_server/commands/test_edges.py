"""`python -m vision_server edges`."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.vision_server.edge_scenes import polygon_with_shadows
from vision_server.channels.channel import channel_statistics
from vision_server.channels.image_files import read_grey
from vision_server.edges.merging import merge_channels

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def images(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("images")
    paths = []
    for number, image in enumerate(polygon_with_shadows(3)):
        paths.append(folder / f"{number}.png")
        cv2.imwrite(str(paths[-1]), image)
    return paths


def edges(root: Path, *arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "vision_server", "edges", *map(str, arguments)]
    return subprocess.run(command, cwd=root, capture_output=True, text=True, check=False, timeout=120)


def test_magnitude_is_the_ridge_before_any_threshold(root: Path, images: list[Path], tmp_path: Path) -> None:
    done = edges(root, *images, "--out", tmp_path / "e.png", "--magnitude", tmp_path / "m.npy")
    assert (done.returncode, done.stderr) == (0, "")
    magnitude = np.load(tmp_path / "m.npy")
    assert magnitude.dtype == np.float32
    expected = merge_channels([channel_statistics(read_grey(path)) for path in images]).ridge
    np.testing.assert_array_equal(magnitude, expected)
    picture = read_grey(tmp_path / "e.png")
    assert picture.shape == magnitude.shape
    assert set(np.unique(picture)) == {0, 255}
    assert np.all(magnitude[picture > 0] > 0)


@pytest.mark.parametrize("method", ["mean", "max-image", "max-gradient", "di-zenzo", "mertens"])
def test_other_methods(root: Path, images: list[Path], tmp_path: Path, method: str) -> None:
    arguments = (
        "--out",
        tmp_path / "e.png",
        "--magnitude",
        tmp_path / "m",
        "--method",
        method,
        "--exposures",
        "1,2,0.5",
    )
    done = edges(root, *images, *arguments)
    assert done.returncode == 0, done.stderr
    magnitude = np.load(tmp_path / "m")
    assert magnitude.max() > 10
    assert 0.01 < np.mean(read_grey(tmp_path / "e.png") > 0) < 0.2


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nosuch.png", "--out", "e.png"], "nosuch.png"),
        (["{image}", "--out", "e.png", "--exposures", "1,2"], "--exposures"),
        (["{image}", "--out", "e.png", "--exposures", "one"], "--exposures"),
        (["{image}", "--out", "e.png", "--exposures", "-1"], "--exposures"),
        (["{image}", "--out", "no/such/folder/e.png"], "no/such/folder"),
        (["{image}", "--out", "e.strange"], ".strange"),
        (["{image}", "--out", "e.png", "--method", "median"], "--method"),
        (["{image}", "--out", "e.png", "--gamma", "0"], "--gamma"),
        (["{image}"], "--out"),
        (["--out", "e.png"], "IMAGE"),
    ],
)
def test_bad_input_ends_with_2_and_a_plain_message(
    root: Path, images: list[Path], tmp_path: Path, arguments: list[str], words: str
) -> None:
    filled = [
        str(tmp_path / a) if a.startswith(("e.", "no/")) else a.format(image=images[0]) for a in arguments
    ]
    done = edges(root, *filled)
    assert done.returncode == 2
    assert words in done.stderr
    assert "Traceback" not in done.stderr
