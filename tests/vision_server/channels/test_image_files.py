"""Image files as grey arrays."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest

from bridge.errors import BadInput
from tests.turned_jpeg import write_turned_jpeg
from vision_server.channels.depth import PER_GREY, in_grey
from vision_server.channels.image_files import read_grey, read_image_set


@pytest.fixture
def colour() -> np.ndarray:
    return np.random.default_rng(0).integers(0, 256, (12, 15, 3), dtype=np.uint8)


def test_colour_becomes_grey_as_bt601(tmp_path: Path, colour: np.ndarray) -> None:
    cv2.imwrite(str(tmp_path / "a.png"), colour)
    np.testing.assert_array_equal(read_grey(tmp_path / "a.png"), cv2.cvtColor(colour, cv2.COLOR_BGR2GRAY))


def test_alpha_is_ignored(tmp_path: Path, colour: np.ndarray) -> None:
    cv2.imwrite(str(tmp_path / "a.png"), np.dstack([colour, np.full((12, 15), 128, np.uint8)]))
    np.testing.assert_array_equal(read_grey(tmp_path / "a.png"), cv2.cvtColor(colour, cv2.COLOR_BGR2GRAY))


def test_missing_and_broken_files_are_named(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=r"nosuch\.png"):
        read_grey(tmp_path / "nosuch.png")
    (tmp_path / "broken.png").write_text("this is no picture")
    with pytest.raises(BadInput, match=r"broken\.png"):
        read_grey(tmp_path / "broken.png")
    (tmp_path / "empty.png").touch()
    with pytest.raises(BadInput, match=r"empty\.png"):
        read_grey(tmp_path / "empty.png")
    with pytest.raises(BadInput):
        read_grey(tmp_path)
    for value in (-0.1, 1.1, np.nan):
        cv2.imwrite(str(tmp_path / "float.tiff"), np.full((5, 5), value, np.float32))
        with pytest.raises(BadInput, match="float32"):
            read_grey(tmp_path / "float.tiff")


@pytest.mark.parametrize("kind", ["bmp", "pgm", "tiff"])
def test_of_a_file_that_is_cut_short_a_library_says_nothing(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], kind: str
) -> None:
    file = tmp_path / f"short.{kind}"
    pixels = np.random.default_rng(0).integers(0, 256, (100, 100), np.uint8)
    content = cv2.imencode(f".{kind}", pixels)[1].tobytes()
    file.write_bytes(content[: len(content) // 2])
    with pytest.raises(BadInput, match=rf"short\.{kind} is not an image that can be read"):
        read_grey(file)
    assert capfd.readouterr().err == ""


def test_a_huge_image_is_refused_by_its_header(tmp_path: Path) -> None:
    """Memory is measured by what numpy and OpenCV are asked for: the file itself has a few bytes."""
    header = struct.pack(">IIBBBBB", 40_000, 40_000, 8, 0, 0, 0, 0)
    for width, said in ((40_000, "40000x40000 px"), (20_000, "20000x40000")):
        chunk = b"IHDR" + struct.pack(">I", width) + header[4:]
        (tmp_path / "huge.png").write_bytes(
            b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + chunk + struct.pack(">I", zlib.crc32(chunk))
        )
        with pytest.raises(BadInput, match=said):
            read_grey(tmp_path / "huge.png")


def test_float_images_are_from_0_to_1(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "float.tiff"), np.full((5, 5), 0.2, np.float32))
    np.testing.assert_allclose(read_grey(tmp_path / "float.tiff"), 51.0, rtol=1e-6)


@pytest.mark.parametrize("bits", [10, 12, 14, 16])
def test_the_depth_of_a_camera_is_that_of_all_its_images(tmp_path: Path, bits: int) -> None:
    top = 2**bits - 1
    for name, value in (("bright", top), ("dark", top // 5)):
        cv2.imwrite(str(tmp_path / f"{name}.png"), np.full((5, 5), value, np.uint16))
    dark, bright = read_image_set([tmp_path / "dark.png", tmp_path / "bright.png"])
    assert (in_grey(bright.pixels) == 255.0).all()
    np.testing.assert_allclose(in_grey(dark.pixels), 255.0 * (top // 5) / top, atol=0.51 / PER_GREY)


def test_images_are_turned_as_their_camera_was_held(tmp_path: Path) -> None:
    image = np.zeros((16, 32), np.uint8)
    image[:, 16:] = 200
    write_turned_jpeg(tmp_path / "a.jpg", image)
    seen = read_grey(tmp_path / "a.jpg")
    assert seen.shape == (32, 16)
    assert seen[24:].min() > 150
    assert seen[:8].max() < 50


def test_a_set_has_one_size(tmp_path: Path, colour: np.ndarray) -> None:
    cv2.imwrite(str(tmp_path / "a.png"), colour)
    cv2.imwrite(str(tmp_path / "b.png"), colour[:10])
    cv2.imwrite(str(tmp_path / "thin.png"), colour[:, :1])
    assert len(read_image_set([tmp_path / "a.png", tmp_path / "a.png"])) == 2
    with pytest.raises(BadInput, match=r"b\.png has 15x10 px"):
        read_image_set([tmp_path / "a.png", tmp_path / "b.png"])
    with pytest.raises(BadInput, match="1x12"):
        read_image_set([tmp_path / "thin.png"])
    with pytest.raises(BadInput, match="No image files"):
        read_image_set([])


def test_photographs_are_upright(tmp_path: Path) -> None:
    """Orientation 6 of EXIF: the camera was turned by a quarter to the right."""
    picture = np.zeros((20, 30), np.uint8)
    picture[:, :10] = 200
    (coded,) = cv2.imencode(".jpg", picture)[1:]
    entry = struct.pack("<HHIHH", 0x0112, 3, 1, 6, 0)
    exif = b"Exif\0\0II*\0" + struct.pack("<IH", 8, 1) + entry + struct.pack("<I", 0)
    marker = b"\xff\xe1" + struct.pack(">H", len(exif) + 2) + exif
    (tmp_path / "a.jpg").write_bytes(coded[:2].tobytes() + marker + coded[2:].tobytes())
    upright = read_grey(tmp_path / "a.jpg")
    assert upright.shape == (30, 20)
    assert upright[:9].min() > 150
    assert upright[12:].max() < 50
