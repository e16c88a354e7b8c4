"""What is wrong with the files of a laboratory is said before a device is opened."""

from argparse import ArgumentParser
from pathlib import Path

import pytest

from bridge.errors import BadInput
from image_server.commands import hardware

CAMERA = """[camera]
width = 640
height = 480
fx = 700.0
fy = 700.0
cx = 319.5
cy = 239.5
"""


def test_a_misspelt_key_of_the_camera_model_is_refused(tmp_path: Path) -> None:
    model = tmp_path / "camera-model.toml"
    model.write_text(CAMERA + "distorsion = [0.1, 0.0, 0.0, 0.0]\n")
    parser = ArgumentParser()
    hardware.add_options(parser)
    nowhere = str(tmp_path / "video0")
    words = ["--camera", nowhere, "--camera-model", str(model), "--endpoint", "ipc:///tmp/nobody"]
    with pytest.raises(BadInput, match=r"unknown key `distorsion` in \[camera\]. Did you mean distortion"):
        hardware.laboratory_device(parser.parse_args(words))
    model.write_text(CAMERA + "distortion = [0.1, 0.0, 0.0, 0.0]\n")
    with pytest.raises(BadInput, match="video0"):
        hardware.laboratory_device(parser.parse_args(words))
