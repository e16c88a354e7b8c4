"""What a user can get wrong: one plain line, exit status 2, nothing left running."""

from pathlib import Path

import pytest

from bridge.messages import MATCHERS
from tests.session.command import controller

STACK = """
kind = "basis"
ambient = "sun.png"
[camera]
width = 4
height = 4
fx = 4.0
fy = 4.0
cx = 1.5
cy = 1.5
[[lights]]
name = "left"
levels = 8
radiance = "left.png"
[target]
model = "m.cao"
[target.seed_pose]
rotation_vector = [0.0, 0.0, 0.0]
translation = [0.0, 0.0, 1.0]
"""


def refused(*options: str | Path) -> str:
    """Run with bad options; returns the message after checking that it is short and the status is 2."""
    done = controller(*options, deadline_s=30)
    assert done.returncode == 2, done.stderr
    lines = done.stderr.strip().splitlines()
    assert 1 <= len(lines) <= 4, done.stderr
    assert "Traceback" not in done.stderr
    return done.stderr


def test_the_matchers_are_those_of_the_messages() -> None:
    assert f"--matcher: 'best' is not one of {', '.join(MATCHERS)}" in refused("--matcher", "best")


def test_a_controller_s_file_may_be_the_first_option(tmp_path: Path) -> None:
    strategy = tmp_path / "mine.pl"
    strategy.write_text("proc(control, []).\n")
    for options in ([f"--controller={strategy}", "--dry-run"], ["--controller", str(strategy), "--dry-run"]):
        done = controller(*options)
        assert done.returncode == 0, done.stderr
        assert str(strategy) in done.stderr
    assert "no such" in refused("--controller=no such.pl")


def test_help_lists_the_options() -> None:
    done = controller("--help")
    assert done.returncode == 0
    text = done.stdout + done.stderr
    for option in ("--controller", "--target", "--stack", "--threshold", "--resume", "--approach", "--json"):
        assert option in text


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--colour"], ["unknown option --colour", "--help"]),
        (["--threshold"], ["--threshold needs a value"]),
        (["--threshold", "low"], ["--threshold", "'low' is not a number"]),
        (["--threshold", "-1"], ["--threshold must be a positive number"]),
        (["--max-iterations", "0"], ["--max-iterations must be at least 1"]),
        (["--seed", "x"], ["--seed", "whole number"]),
        (["--matcher", "magic"], ["--matcher", "search, genetic"]),
        (["cube"], ["unexpected argument 'cube'"]),
        (["--controller", "wizard"], ["--controller", "'wizard'", "heuristic"]),
        (["--target", "teapot"], ["teapot", "cube", "satellite"]),
        (["--scenario", "disco"], ["disco", "nominal"]),
        (["--stack", "/nowhere"], ["--stack", "/nowhere"]),
        (["--resume", "/nowhere"], ["--resume", "/nowhere"]),
        (["--image-server", "localhost:1"], ["--image-server", "endpoint"]),
        (["--unit", "ell"], ["--unit", "m, cm, mm, in"]),
        (["--unit", "mm"], ["--unit", "--target"]),
        (["--camera-model", "/nowhere.toml"], ["--camera-model", "/nowhere.toml"]),
        (["--approach", "--stack", "."], ["--approach"]),
        (["--camera", "/dev/null", "--stack", "."], ["--stack and --camera exclude each other"]),
        (["--camera", "/dev/null"], ["--camera needs --target", "cube"]),
        (["--camera", "/dev/nowhere", "--target", "cube"], ["--camera", "there is no '/dev/nowhere'"]),
        (["--lights", "/dev/null"], ["--lights needs --camera"]),
        (["--out", "/proc/none"], ["--out", "/proc/none"]),
    ],
)
def test_options(options: list[str], words: list[str]) -> None:
    message = refused(*options)
    for word in words:
        assert word in message
    assert "Unknown" not in message


def test_controller_with_a_syntax_error(tmp_path: Path) -> None:
    file = tmp_path / "mine.pl"
    file.write_text("proc(control,\n  [choose_random take_image]).\n")
    message = refused("--controller", file, "--out", tmp_path / "run")
    assert "mine.pl:2" in message


def test_controller_with_an_unknown_action(tmp_path: Path) -> None:
    file = tmp_path / "mine.pl"
    file.write_text("proc(control, [choose_random, take_picture]).\n")
    message = refused("--controller", file, "--out", tmp_path / "run")
    assert "take_picture" in message
    assert "mine.pl:1" in message


def test_controller_without_control(tmp_path: Path) -> None:
    file = tmp_path / "mine.pl"
    file.write_text("proc(other, []).\n")
    message = refused("--controller", file, "--out", tmp_path / "run")
    assert "control" in message
    assert not (tmp_path / "run").exists()


def test_stack_with_a_missing_image(tmp_path: Path) -> None:
    (tmp_path / "stack.toml").write_text(STACK)
    message = refused("--stack", tmp_path, "--out", tmp_path / "run")
    assert ".png" in message or "m.cao" in message


def test_model_without_faces(tmp_path: Path) -> None:
    model = tmp_path / "lines.cao"
    model.write_text("V1\n2\n0 0 0\n1 0 0\n1\n0 1\n0\n0\n0\n0\n")
    message = refused("--target", model, "--out", tmp_path / "run")
    assert "lines.cao" in message
    assert "face" in message


def test_finished_run_folder_is_not_overwritten(tmp_path: Path) -> None:
    (tmp_path / "result.json").write_text("{}")
    message = refused("--out", tmp_path)
    assert "--out" in message
    assert (tmp_path / "result.json").read_text() == "{}"
