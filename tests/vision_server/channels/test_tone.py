import struct
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest

from vision_server.channels.tone import KNOWN_TONE_SD_PX, NOMINAL_TONE_SD_PX, file_gamma, file_tone


def with_chunk(png: bytes, kind: bytes, data: bytes) -> bytes:
    """A PNG file with one more chunk after its header."""
    chunk = struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    return png[:33] + chunk + png[33:]


@pytest.fixture
def files(tmp_path: Path) -> dict[str, Path]:
    image = np.arange(256, dtype=np.uint8).reshape(16, 16)
    png, jpeg = (cv2.imencode(kind, image)[1].tobytes() for kind in (".png", ".jpg"))
    contents = {
        "plain.png": png,
        "srgb.png": with_chunk(png, b"sRGB", b"\0"),
        "gama.png": with_chunk(png, b"gAMA", struct.pack(">I", 50000)),
        "photo.jpg": jpeg,
        "cut.png": png[:10],
    }
    for name, content in contents.items():
        (tmp_path / name).write_bytes(content)
    return {name: tmp_path / name for name in contents}


def test_the_file_tells_its_curve(files: dict[str, Path]) -> None:
    found = {name: file_gamma(path) for name, path in files.items()}
    assert found == {
        "plain.png": 1.0, "srgb.png": 2.2, "gama.png": pytest.approx(2.0), "photo.jpg": 2.2, "cut.png": 1.0,
    }  # fmt: skip


def test_only_a_nominal_curve_leaves_room(files: dict[str, Path]) -> None:
    assert file_tone([files["plain.png"]], None) == ([1.0], KNOWN_TONE_SD_PX)
    assert file_tone([files["plain.png"], files["photo.jpg"]], None) == ([1.0, 2.2], NOMINAL_TONE_SD_PX)
    assert file_tone([files["photo.jpg"]], 1.8) == ([1.8], KNOWN_TONE_SD_PX)
