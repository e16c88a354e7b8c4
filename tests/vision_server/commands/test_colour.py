"""Colour images: a part whose colours are as bright as what is behind it, so that its grey shows nothing."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from geometry.pose import Pose
from numerics.arrays import Floats, Grey
from tests.commands import Done, command
from tests.vision_server.synthetic import CAMERA, POSE, camera_file, cuboid, linear_picture, photographed
from vision_server.channels.image_files import read_image_set, read_pixels

LUMA = np.array([0.299, 0.587, 0.114])  # BT.601: red, green, blue
FRAMES = 4


def as_bright(rng: np.random.Generator) -> Floats:
    """A colour of the brightness 0.45, red, green and blue."""
    while (colour := rng.uniform(0.1, 0.9, 3)) is not None:
        colour *= 0.45 / float(LUMA @ colour)
        if colour.max() < 0.95:
            return np.asarray(colour)
    raise AssertionError


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("colour")
    model = cuboid(path)
    rng = np.random.default_rng(3)
    behind, faces = as_bright(rng), [as_bright(rng) for _ in model.faces]
    bands = [
        linear_picture(model, CAMERA, POSE, tuple(face[k] for face in faces), behind[k]) for k in (2, 1, 0)
    ]
    for number in range(FRAMES):
        pixels: list[Grey] = [photographed(band, seed=3 * number + k) for k, band in enumerate(bands)]
        cv2.imwrite(str(path / f"f{number}.png"), np.stack(pixels, axis=-1))
    camera_file(path / "camera.toml")
    off = POSE.stepped([0.1, 0.05, -0.1, 0.01, 0.0, 0.02])
    for name, pose, table in (("seed", off, True), ("pose", POSE, False)):
        lines = [f"{key} = {list(value)}\n" for key, value in pose.to_dict().items()]
        (path / f"{name}.toml").write_text("".join(["[target.seed_pose]\n"] * table + lines))
    return path


def asked(folder: Path, program: str, *words: object) -> Done:
    there = ["--model", folder / "cuboid.cao", "--camera", folder / "camera.toml"]
    return command("vision_server", program, *there, "--json", *words)


def test_what_grey_does_not_show_each_channel_does(folder: Path) -> None:
    words = ("estimate", "--seed-pose", folder / "seed.toml", folder / "f0.png")
    grey = asked(folder, *words)
    assert grey.returncode == 3
    assert "in colour that their grey hardly shows: try --colour each" in grey.stderr
    each = asked(folder, *words, "--colour", "each")
    assert each.returncode == 0, each.stderr
    found = json.loads(each.stdout)
    assert Pose.from_dict(found["pose"]).error_to(POSE).within(0.2, 0.002)
    named = [f"{folder / 'f0.png'} ({band})" for band in ("red", "green", "blue")]
    assert list(found["files"].values()) == named


def test_a_pose_is_checked_on_a_channel_or_on_each(folder: Path) -> None:
    for colour, status in (("each", 0), ("red", 0), ("grey", 3)):
        done = asked(folder, "check", "--pose", folder / "pose.toml", "--colour", colour, folder / "f0.png")
        assert done.returncode == status, (colour, done.stdout, done.stderr)


def test_it_is_tracked_on_a_channel(folder: Path) -> None:
    frames = [folder / f"f{number}.png" for number in range(FRAMES)]
    words = ("track", "--seed-pose", folder / "seed.toml", *frames)
    told = asked(folder, *words, "--colour", "red").stdout.splitlines()
    assert json.loads(told[-1])["state"] == "sure"
    assert asked(folder, *words).returncode == 3


def test_levels_and_exposures_are_told_for_files_and_count_for_their_channels(folder: Path) -> None:
    out = folder / "edges.png"
    words = ("edges", "--out", out, "--colour", "each", "--exposures", "1,1", "--levels", "7,0;0,7", "--json")
    done = command("vision_server", *words, folder / "f0.png", folder / "f1.png")
    assert done.returncode == 0, done.stderr
    assert len(json.loads(done.stdout)["step"][0]) == 6


def test_an_overexposed_image_is_said_once_for_all_its_colours(tmp_path: Path, folder: Path) -> None:
    for name, share in (("a.png", 0.25), ("b.png", 0.24), ("c.png", 1.0)):
        pixels = cv2.imread(str(folder / "f0.png"), cv2.IMREAD_COLOR)
        assert pixels is not None
        cv2.imwrite(str(tmp_path / name), np.round(share * pixels).astype(np.uint8))
    files = [tmp_path / name for name in ("a.png", "b.png", "c.png")]
    done = command("vision_server", "edges", "--out", tmp_path / "edges.png", "--colour", "each", *files)
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("is brighter than all others") == 1
    assert f"{tmp_path / 'c.png'} is brighter" in done.stderr


def test_what_is_grey_in_colour_is_one_image(tmp_path: Path, folder: Path) -> None:
    grey = read_pixels(folder / "f0.png", "red")
    for name, pixels in (("plain.png", grey), ("three.png", np.stack([grey] * 3, axis=-1))):
        cv2.imwrite(str(tmp_path / name), pixels)
        (only,) = read_image_set([tmp_path / name], colour="each")
        assert str(only) == str(tmp_path / name)
        np.testing.assert_array_equal(only.pixels, grey)


def test_frames_of_an_image_server_are_grey(folder: Path) -> None:
    done = command(
        "vision_server", "track", "--model", folder / "cuboid.cao", "--colour", "red", "ipc:///tmp/nobody"
    )
    assert done.returncode == 2
    assert "frames are grey" in done.stderr
