"""What is wrong with the files of a laboratory is said before a device is opened; a busy one is awaited."""

import threading
import time
from argparse import ArgumentParser
from pathlib import Path

import pytest

from bridge.errors import BadInput, DeviceBusy
from image_server.commands import hardware
from image_server.lights.opening import open_rig
from tests.equipment.line import EmulatedLineDriver

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


def test_lights_that_another_server_lets_go_of_are_had(monkeypatch: pytest.MonkeyPatch) -> None:
    emulator = EmulatedLineDriver()
    before = open_rig(emulator.path)
    refused = threading.Event()

    def opened():  # type: ignore[no-untyped-def]
        try:
            return open_rig(emulator.path)
        except DeviceBusy:
            refused.set()
            raise

    def leaves() -> None:
        refused.wait(60)
        before.close()

    leaving = threading.Thread(target=leaves)
    leaving.start()
    monkeypatch.setattr(hardware, "LET_GO_S", 60.0)
    hardware.when_free(opened).close()
    leaving.join()
    assert refused.is_set()
    emulator.close()


def test_lights_that_stay_busy_are_said_to_be(monkeypatch: pytest.MonkeyPatch) -> None:
    emulator = EmulatedLineDriver()
    monkeypatch.setattr(hardware, "LET_GO_S", 0.3)
    began = time.monotonic()
    before = open_rig(emulator.path)
    with pytest.raises(DeviceBusy, match="are busy"):
        hardware.when_free(lambda: open_rig(emulator.path))
    assert time.monotonic() - began >= 0.3
    before.close()
    emulator.close()
