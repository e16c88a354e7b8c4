"""`python -m vision_server edges`."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from numerics.arrays import Field
from tests.commands import Done, command, process
from tests.vision_server.edge_scenes import polygon_with_shadows, square_outline
from vision_server.channels.channel import channel_statistics
from vision_server.channels.image_files import read_grey
from vision_server.commands.edges import SELECTABLE_KINDS
from vision_server.edges.merging import merge_channels
from vision_server.kinds.kinds import edge_kinds
from vision_server.kinds.kinds_table import COLOURS
from vision_server.kinds.likelihoods import FIXED, KINDS, NOISE, SHADOW

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def images(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("images")
    paths = []
    for number, image in enumerate(polygon_with_shadows(3)):
        paths.append(folder / f"{number}.png")
        cv2.imwrite(str(paths[-1]), image)
    return paths


def edges(*arguments: object) -> Done:
    return command("vision_server", "edges", *arguments)


def test_magnitude_is_that_of_the_fixed_edges(images: list[Path], tmp_path: Path) -> None:
    written = ("--out", tmp_path / "e.png", "--magnitude", tmp_path / "m.npy")
    done = process("vision_server", "edges", *images, *written)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    magnitude = np.load(tmp_path / "m.npy")
    assert magnitude.dtype == np.float32
    kinds = edge_kinds([channel_statistics(read_grey(path)) for path in images])
    np.testing.assert_array_equal(magnitude, kinds.of_kinds(FIXED).ridge)
    picture = read_grey(tmp_path / "e.png")
    assert picture.shape == magnitude.shape
    assert set(np.unique(picture)) == {0, 255}
    assert np.all(magnitude[picture > 0] > 0)


def test_one_image_has_its_own_ridge(images: list[Path], tmp_path: Path) -> None:
    done = edges(images[0], "--out", tmp_path / "e.png", "--magnitude", tmp_path / "m.npy")
    assert (done.returncode, done.stderr) == (0, "")
    expected = merge_channels([channel_statistics(read_grey(images[0]))]).ridge
    np.testing.assert_array_equal(np.load(tmp_path / "m.npy"), expected)


def test_a_saturated_image_among_good_ones_is_said_and_hides_nothing(
    images: list[Path], tmp_path: Path
) -> None:
    saturated, out = tmp_path / "saturated.png", tmp_path / "m.npy"
    cv2.imwrite(str(saturated), cv2.convertScaleAbs(polygon_with_shadows(4)[3], alpha=4.0))
    asked = ("--out", tmp_path / "e.png", "--magnitude", out)
    assert edges(*images, *asked).returncode == 0
    without = outline_kept(np.load(out))
    done = edges(*images, saturated, *asked)
    assert (done.returncode, str(saturated) in done.stderr, "--exposures" in done.stderr) == (0, True, True)
    assert outline_kept(np.load(out)) > 0.9 * without
    done = edges(*images, saturated, *asked, "--exposures", "1,1,1,1")
    assert (done.returncode, done.stderr) == (0, "")


def outline_kept(magnitude: Field) -> float:
    """Strength that four of five edgels of the square's outline have."""
    return float(np.quantile(magnitude[square_outline() & (magnitude > 0)], 0.2))


def test_kinds_come_as_picture_and_tables(images: list[Path], tmp_path: Path) -> None:
    picture, table = tmp_path / "k.png", tmp_path / "k.npz"
    asked = ("--out", tmp_path / "e.png", "--kinds", picture, "--npz", table, "--json")
    done = edges(*images, *asked)
    assert (done.returncode, done.stderr) == (0, "")
    said = json.loads(done.stdout)
    with np.load(table, allow_pickle=False) as saved:
        assert set(saved) == set(said)
        for name in saved:
            np.testing.assert_array_equal(saved[name], np.array(said[name]))
    assert said["names"] == [*SELECTABLE_KINDS, "noise"]
    drawn = np.asarray(cv2.imread(str(picture)))
    colours = {tuple(colour) for colour in drawn.reshape(-1, 3)[:, ::-1].tolist()}
    assert {COLOURS[SHADOW], COLOURS[NOISE]} < colours <= set(COLOURS)


def test_one_image_twice_is_one_and_a_white_one_is_called_white(images: list[Path], tmp_path: Path) -> None:
    out, white = ("--out", tmp_path / "e.png"), tmp_path / "white.png"
    twice = edges(images[0], images[0], *out, "--kinds", tmp_path / "k.png")
    assert twice.returncode == 2
    assert "under different lights" in twice.stderr
    assert edges(images[0], images[0], *out).returncode == 0
    cv2.imwrite(str(white), np.full((120, 160), 255, np.uint8))
    done = edges(*images, white, *out)
    assert done.returncode == 0
    assert "white.png is white all over" in done.stderr
    assert "exposed" not in done.stderr


def test_the_kind_that_is_asked_for(images: list[Path], tmp_path: Path) -> None:
    kinds = edge_kinds([channel_statistics(read_grey(path)) for path in images])
    for name in ("shadow", "outline"):
        asked = ("--out", tmp_path / "e.png", "--magnitude", tmp_path / "m.npy", "--kind", name)
        assert edges(*images, *asked).returncode == 0
        expected = kinds.of_kinds([KINDS.index(name)]).ridge
        np.testing.assert_array_equal(np.load(tmp_path / "m.npy"), expected)


def test_levels_that_were_not_learnt_are_asked_for(images: list[Path], tmp_path: Path) -> None:
    square = np.full((120, 160), 90.0)
    square[30:90, 40:120] = 180.0
    random = np.random.default_rng(0)
    prints = []
    for gain in (1.0, 0.8):  # no shadow ends in either
        prints.append(tmp_path / f"{gain}.png")
        cv2.imwrite(str(prints[-1]), np.clip(gain * square + random.normal(size=square.shape), 0, 255))
    asked = ("--out", tmp_path / "e.png", "--json")
    for pictures, levels, known in (
        (prints, (), "unknown"),
        (prints, ("--levels", "1;0.8"), "told"),
        (images, (), "learnt"),
    ):
        done = edges(*pictures, *asked, *levels)
        assert done.returncode == 0, done.stderr
        assert json.loads(done.stdout)["levels"] == known
        assert ("Give --levels" in done.stderr) == (known == "unknown")


def test_levels_of_the_lights_tell_more(images: list[Path], tmp_path: Path) -> None:
    tables = []
    for levels in (
        "1,0,0;0,1,0;0,0,1",
        "1,0;0,1;1,1",
    ):
        out = tmp_path / "k.npz"
        done = edges(*images, "--out", tmp_path / "e.png", "--npz", out, "--levels", levels)
        assert done.returncode == 0, done.stderr
        with np.load(out) as table:
            tables.append(table["probability"])
    assert tables[0].shape == tables[1].shape
    assert not np.array_equal(*tables)


@pytest.mark.parametrize("method", ["mean", "max-image", "max-gradient", "di-zenzo", "mertens"])
def test_other_methods(images: list[Path], tmp_path: Path, method: str) -> None:
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
    done = edges(*images, *arguments)
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
        (["nosuch.png", "--out", "e.png", "--magnitude", "no/m.npy"], "there is no folder"),
        (["nosuch.png", "--out", "e.png", "--npz", "no/m.npz"], "there is no folder"),
        (["nosuch.png", "--out", "e.png", "--kinds", "no/k.png"], "there is no folder"),
        (["nosuch.png", "--out", "."], "it is a folder"),
        (["{image}", "--out", "e.strange"], ".strange"),
        (["{image}", "--out", "e.gif"], "of the kind '.gif'"),
        (["{image}", "--out", "{image}"], "it is read as well"),
        (["{image}", "--out", "e.png", "--magnitude", "{image}"], "it is read as well"),
        (["{image}", "--out", "e.png", "--kinds", "e.png"], "it is --out as well"),
        (["{image}", "--out", "e.png", "--method", "median"], "--method"),
        (["{image}", "--out", "e.png", "--gamma", "0"], "--gamma"),
        (["{image}", "--out", "e.png", "--levels", "7,x"], "--levels"),
        (["{image}", "--out", "e.png", "--levels", "7,0;0,7"], "--levels"),
        (["{image}", "--out", "e.png", "--levels", "0,0"], "--levels"),
        (["{image}", "--out", "e.png", "--kind", "outline"], "kinds"),
        (["{image}", "--out", "e.png", "--kind", "noise"], "--kind"),
        (["{image}", "--out", "e.png", "--json", "--method", "mean"], "--json"),
        (["{image}"], "--out"),
        (["--out", "e.png"], "IMAGE"),
    ],
)
def test_bad_input_ends_with_2_and_a_plain_message(
    images: list[Path], tmp_path: Path, arguments: list[str], words: str
) -> None:
    filled = [
        str(tmp_path / a) if a.startswith(("e.", "no/")) else a.format(image=images[0]) for a in arguments
    ]
    done = edges(*filled)
    assert done.returncode == 2
    assert words in done.stderr
    assert "Traceback" not in done.stderr


def test_bits_of_files_that_have_8_are_said_to_be_for_others(images: list[Path], tmp_path: Path) -> None:
    done = edges(images[0], "--out", tmp_path / "e.png", "--bits", "12")
    assert done.returncode == 0
    assert f"{images[0]} has 8 bits a pixel" in done.stderr


def test_a_moved_target_is_said(tmp_path: Path) -> None:
    lit = [np.repeat(np.repeat(image, 2, axis=0), 2, axis=1) for image in polygon_with_shadows(3)]
    files = [tmp_path / f"{number}.png" for number in range(3)]
    for file, image, shift in zip(files, lit, (0, 0, 12), strict=True):
        cv2.imwrite(str(file), np.roll(image, (shift, shift), axis=(0, 1)))
    assert edges(*files[:2], "--out", tmp_path / "e.png").stderr == ""
    done = edges(*files, "--out", tmp_path / "e.png")
    assert done.returncode == 0
    assert "2.png" in done.stderr
    assert "elsewhere" in done.stderr
