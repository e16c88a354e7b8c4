"""What docs/hardware.md shows is read, sent and run as it stands there."""

import re
import shlex
from pathlib import Path

import pytest

from image_server.lights.lights_file import load_lights_file
from image_server.lights.line_protocol import decoded
from image_server.v4l2.camera_file import load_camera_file
from stack.read import load_stack
from tests.commands import command, module
from tests.session.command import ROOT

pytestmark = pytest.mark.slow

PAGE = (ROOT / "docs" / "hardware.md").read_text()


def shown(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)


def commands(name: str) -> list[str]:
    return re.findall(rf"^    \.venv/bin/python -m image_server {name} (.*)$", PAGE, re.MULTILINE)


def test_the_files_shown_can_be_used(tmp_path: Path) -> None:
    camera, lights = shown("toml")
    (tmp_path / "camera.toml").write_text(camera)
    (tmp_path / "lights.toml").write_text(lights)
    read = load_camera_file(str(tmp_path / "camera.toml"))
    assert set(read.axes()) == {"shutter_s", "aperture", "focal_length_mm", "focus_m"}
    assert [light.name for light in load_lights_file(tmp_path / "lights.toml").lights] == ["left", "top"]


def test_the_lines_shown_have_the_right_check() -> None:
    lines = re.findall(r"^    (17 .*?\*[0-9A-F]{2})", PAGE, re.MULTILINE)
    assert [decoded(line.encode())[1] for line in lines] == ["SET 0 128 255", "OUT 0 128 255"]


@pytest.mark.parametrize("line", commands("record"))
def test_recordings_shown_can_be_made(line: str, tmp_path: Path) -> None:
    out, *options = shlex.split(line)
    quick = ("--average", "1")  # which of the frames' means are taken is shown by the tests of recording
    done = command("image_server", "record", tmp_path / out, *options, *quick)
    assert done.returncode == 0, done.stderr
    assert load_stack(tmp_path / out).table.kind in line


def test_the_options_of_commands_that_need_hardware_are_there() -> None:
    lines = re.findall(
        r"^    (?:sudo )?\.venv/bin/python -m (image_server hardware|tests\.equipment \w+) (.*)$",
        PAGE.replace("\\\n", " "),
        re.MULTILINE,
    )
    assert {line[0].split()[1] for line in lines} == {"hardware", "lights", "bench"}
    for program_and_name, rest in lines:
        program, name = program_and_name.split()
        help_of = command if program == "image_server" else module
        usage = help_of(program, name, "--help").stdout
        assert all(word in usage for word in shlex.split(rest) if word.startswith("--")), rest


def test_every_command_is_there() -> None:
    names = re.findall(r"^\| `(\w+)", PAGE[: PAGE.index("## The camera")], re.MULTILINE)
    assert {"cameras", "calibrate", "hardware", "record"} <= set(names)
    assert len(commands("record")) == 2
    for name in names:
        assert command("image_server", name, "--help").returncode == 0, name
