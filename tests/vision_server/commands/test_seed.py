"""`python -m vision_server seed`: pairs in, out a seed pose that `estimate` takes; wrong ones are said."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from geometry.pose import Pose
from tests.commands import Done, command, process
from tests.vision_server.synthetic import CAMERA, POSE, camera_file, cuboid, linear_picture, photographed
from vision_server.channels.image_files import read_grey
from vision_server.serve.inputs import read_model, read_seed_pose

pytestmark = pytest.mark.slow

CORNERS = (0, 1, 2, 4)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("seed")
    model = cuboid(path)
    cv2.imwrite(str(path / "a.png"), photographed(linear_picture(model, CAMERA, POSE)))
    camera_file(path / "camera.toml")
    pixels = CAMERA.project(POSE.apply(model.vertices))
    rows = [",".join(map(str, [*pixels[k], *model.vertices[k]])) for k in CORNERS]
    (path / "points.txt").write_text("\n".join(rows) + "\n")
    return path


def words_of(folder: Path, *words: str | Path) -> list[str | Path]:
    model, camera = folder / "cuboid.cao", folder / "camera.toml"
    return ["seed", folder / "a.png", "--model", model, "--camera", camera, *words]


def seed(folder: Path, *words: str | Path) -> Done:
    return command("vision_server", *words_of(folder, *words))


def test_pairs_give_a_seed_pose_that_estimate_takes(folder: Path, tmp_path: Path) -> None:
    files = ["--out", tmp_path / "seed.toml", "--overlay", tmp_path / "o.png"]
    done = process("vision_server", *words_of(folder, "--points", folder / "points.txt", *files))
    assert done.returncode == 0, done.stderr
    assert done.stdout == (tmp_path / "seed.toml").read_text()
    model = read_model(folder / "cuboid.cao")
    assert read_seed_pose(tmp_path / "seed.toml", model).error_to(POSE).within(0.01, 1e-4)
    drawn, plain = (cv2.imread(str(file)) for file in (tmp_path / "o.png", folder / "a.png"))
    assert 0.005 < np.any(np.not_equal(drawn, plain), axis=2).mean() < 0.2
    told = command("vision_server", "estimate", folder / "a.png", "--json", "--model", folder / "cuboid.cao",
                   "--camera", folder / "camera.toml", "--seed-pose", tmp_path / "seed.toml")  # fmt: skip
    assert Pose.from_dict(json.loads(told.stdout)["pose"]).error_to(POSE).within(0.5, 0.005)


def test_a_deep_image_is_shown_in_its_own_range(folder: Path, tmp_path: Path) -> None:
    plain = read_grey(folder / "a.png")
    deep, drawn = tmp_path / "deep.tiff", tmp_path / "o.png"
    cv2.imwrite(str(deep), plain.astype(np.uint16) * 16)
    words = ["--model", folder / "cuboid.cao", "--camera", folder / "camera.toml", "--overlay", drawn]
    assert not command("vision_server", "seed", deep, *words, "--points", folder / "points.txt").returncode
    shown = read_grey(drawn)
    assert np.median(np.abs(shown.astype(int) - plain)) < 30


def test_three_pairs_say_that_a_fourth_decides_and_a_wrong_one_is_named(folder: Path) -> None:
    lines = (folder / "points.txt").read_text().split()
    words = [word for line in lines[:3] for word in ("--pair", line)]
    done = seed(folder, *words, "--json")
    found = json.loads(done.stdout)
    assert Pose.from_dict(found["pose"]).error_to(POSE).within(0.1, 0.001)
    assert len(found["points"]) == 3
    assert bool(found["others"]) is ("another point decides" in done.stderr)
    wrong = "20,220," + lines[3].split(",", 2)[2]
    done = seed(folder, *words, "--pair", wrong)
    assert done.returncode == 0 and "px RMS is much: is pair" in done.stderr


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--points", "{folder}/none.txt"], "none.txt"),
        (["--points", "{folder}/a.png"], "not a text file"),
        (["--pair", "1,2 3,4,5"], "at least 3"),
        (["--pair", "1,2 3,4"], "is not a pair"),
        (["--points", "{folder}/none.txt", "--out", "{folder}/no/seed.toml"], "Cannot write"),
        (["--points", "{folder}/none.txt", "--overlay", "{folder}/no/o.png"], "Cannot write"),
        (["--points", "{folder}/points.txt", "--unit", "mile"], "unknown unit"),
    ],
)
def test_bad_input_is_one_plain_line(folder: Path, words: list[str], told: str) -> None:
    done = seed(folder, *(word.format(folder=folder) for word in words))
    assert done.returncode == 2 and done.stdout == ""
    assert told in done.stderr and done.stderr.count("\n") == 1


def test_a_page_that_nobody_opens_ends(folder: Path) -> None:
    done = seed(folder, "--wait-s", "0.5")
    assert done.returncode == 3
    assert done.stderr.startswith("Open http://127.0.0.1:") and "nobody opened the page" in done.stderr
