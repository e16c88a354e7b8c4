"""`python -m tests.equipment lights`: a light driver in a terminal of its own."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from image_server.lights.opening import open_rig
from tests.commands import module
from tests.image_server.lights.lights_files import until

pytestmark = pytest.mark.slow

DEADLINE_S = 120.0


def emulate(*arguments: str | Path) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [sys.executable, "-m", "tests.equipment", "lights", *map(str, arguments)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.mark.parametrize("kind", ["line", "dmx"])
def test_it_shows_its_outputs_and_takes_faults(tmp_path: Path, kind: str) -> None:
    link = tmp_path / "lights"
    process = emulate(kind, "--link", link)
    assert process.stdout is not None and process.stdin is not None
    assert process.stdout.readline() == f"device {link}\n"
    rig = open_rig(str(link))
    died: list[str] = []
    rig.listen(lambda name, _why: died.append(name))
    rig.light((7, 0, 7))
    assert process.stdout.readline() == "outputs 255 0 255\n"
    process.stdin.write("unplugged\n")
    process.stdin.flush()
    assert process.stdout.readline() == "fault unplugged\n"
    assert until(lambda: len(died) == 3)
    rig.close()
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=DEADLINE_S)
    assert process.returncode == 143
    assert not os.path.lexists(link)


def test_a_fault_may_be_planned(tmp_path: Path) -> None:
    process = emulate("line", "--link", tmp_path / "lights", "--fault", "dead:2")
    assert process.stdout is not None
    process.stdout.readline()
    rig = open_rig(str(tmp_path / "lights"))
    assert until(lambda: list(rig.health()["dead_lights"]) == ["light2"])
    rig.close()
    process.terminate()
    process.communicate(timeout=DEADLINE_S)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["line", "--fault", "5:explode"], "no fault 'explode'"),
        (["line", "--fault", "dead:9"], "no fault 'dead:9'"),
        (["line", "--link", "/proc/lights"], "Cannot make the link /proc/lights"),
        (["laser"], "laser"),
    ],
)
def test_bad_input_is_refused(arguments: list[str], message: str) -> None:
    done = module("tests.equipment", "lights", *arguments)
    assert done.returncode == 2
    assert message in done.stderr
