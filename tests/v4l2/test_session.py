"""Whole sessions and commands on the virtual camera, with emulated lights."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from stack.read import load_stack
from tests.v4l2.conftest import DEADLINE_S, image_server, session

SEED_POSE = """
[target.seed_pose]
rotation_vector = [0.5, 0.7, 0.1]
translation = [0.0, 0.0, 0.6]
"""


@pytest.fixture
def lights(tmp_path: Path) -> Iterator[tuple[Path, "subprocess.Popen[str]"]]:
    """Emulated lights of three channels; faults go to their standard input."""
    link = tmp_path / "lights"
    process = subprocess.Popen(
        [sys.executable, "-m", "tests.equipment", "lights", "line", "--link", str(link)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == f"device {link}\n"
    yield link, process
    process.terminate()
    process.communicate(timeout=DEADLINE_S)


def test_a_session_whose_light_dies_ends_in_an_honest_no_pose(
    camera_file: Path, lights: tuple[Path, "subprocess.Popen[str]"], tmp_path: Path
) -> None:
    """The virtual camera shows a grey ramp: there is nothing to find. Light 2 is dead from the start."""
    link, emulator = lights
    assert emulator.stdin is not None
    emulator.stdin.write("dead:2\n")
    emulator.stdin.flush()
    seed_pose = tmp_path / "seed.toml"
    seed_pose.write_text(SEED_POSE)
    out = tmp_path / "run"
    status, result, said = session(
        out, "--camera", camera_file, "--lights", link, "--target", "cube", "--seed-pose", seed_pose,
        "--max-iterations", "3",
    )  # fmt: skip
    assert status == 3, said
    assert "event: light_fault(light2)" in said
    assert result["status"] == "exhausted"
    assert result["pose"] is None or result["rms_px"] is not None
    assert result["iterations"] == 3
    later = [step["settings"]["lights"] for step in result["steps"][1:]]
    assert all(levels[1] == 0 for levels in later)  # the session went on without it
    assert any(any(levels) for levels in later)
    stack = load_stack(out / "images")
    assert len(stack.table.frames) == 3  # type: ignore[union-attr]
    emulator.terminate()
    shown, _ = emulator.communicate(timeout=DEADLINE_S)
    outputs = [line for line in shown.splitlines() if line.startswith("outputs")]
    assert len(outputs) > 1 and outputs[-1] == "outputs 0 0 0"  # dark at the end


def test_the_camera_is_listed_calibrated_and_recorded(
    camera_file: Path, lights: tuple[Path, "subprocess.Popen[str]"], fresh: str, tmp_path: Path
) -> None:
    listed = image_server("cameras")
    assert listed.returncode == 0, listed.stderr
    assert f"{fresh}: vivid" in listed.stdout
    assert "brightness (integer) 0..255 step 1 default 128" in listed.stdout
    assert "20 = Gray Ramp" in listed.stdout
    made = tmp_path / "made.toml"
    done = image_server("calibrate", "--camera", camera_file, made)
    assert done.returncode == 0, done.stderr
    assert "frames late" in done.stdout
    assert 'card = "vivid"' in made.read_text()
    stack = tmp_path / "stack"
    done = image_server(
        "record", stack, "--kind", "frames", "--camera", made, "--lights", lights[0], "--target", "cube",
        "--settings", "7,0,0:0.004:4", "--settings", "0,7,7:0.016:4",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "2 frames recorded, 0 of them unverified" in done.stdout
    loaded = load_stack(stack)
    assert loaded.images[0].mean() < loaded.images[1].mean() - 20  # type: ignore[union-attr]
    refused = image_server(
        "record", tmp_path / "no", "--kind", "frames", "--camera", made, "--settings", ":0.5:4"
    )
    assert refused.returncode == 2
    assert "shutter_s = 0.5 is not offered. Allowed: 0.004, 0.008, 0.016 s" in refused.stderr
