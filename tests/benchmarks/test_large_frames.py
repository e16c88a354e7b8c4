"""The scene of large frames is one that the command finds, and what it costs is measured."""

from pathlib import Path

import pytest

from benchmarks import large_frames
from geometry.model import find_target, load_model
from vision_server.channels.image_files import read_pixels


@pytest.mark.slow
@pytest.mark.parametrize("bits", [8, 16])
def test_one_frame_is_found_and_measured(bits: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(large_frames, "IMAGES", 1)
    monkeypatch.setattr(large_frames, "CAMERA", large_frames.CAMERA.scaled(0.25))
    large_frames.write_scene(tmp_path, load_model(find_target(large_frames.TARGET)), 0.4, bits)
    assert read_pixels(tmp_path / "0.png").dtype == large_frames.DEPTHS[bits]
    megabytes, seconds = large_frames.measured(tmp_path, 1)
    assert megabytes > 50.0
    assert seconds > 0.0


@pytest.mark.slow
def test_a_scene_that_is_not_there_ends_it(tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match="estimate ended with 2"):
        large_frames.measured(tmp_path / "nowhere", 1)
