"""Emulated drivers of lights, and rigs on them."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from image_server.lights.opening import open_rig
from image_server.lights.rig import LightRig
from tests.equipment.dmx import EmulatedDmxUsbPro
from tests.equipment.emulator import Emulator
from tests.equipment.line import EmulatedLineDriver
from tests.image_server.lights.lights_files import lights_file

KINDS = {"line": EmulatedLineDriver, "dmx_usb_pro": EmulatedDmxUsbPro}


@pytest.fixture(params=sorted(KINDS))
def bench(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[tuple[Emulator, Path]]:
    """An emulated driver and its lights file."""
    emulator: Emulator = KINDS[request.param]()
    yield emulator, lights_file(tmp_path, emulator.path, request.param)
    emulator.close()


@pytest.fixture
def line(tmp_path: Path) -> Iterator[tuple[EmulatedLineDriver, LightRig, list[str]]]:
    """A rig on an emulated line driver, and the names of the lights that die."""
    emulator = EmulatedLineDriver()
    rig = open_rig(str(lights_file(tmp_path, emulator.path, "line")))
    died: list[str] = []
    rig.listen(lambda name, _why: died.append(name))
    yield emulator, rig, died
    rig.close()
    emulator.close()
