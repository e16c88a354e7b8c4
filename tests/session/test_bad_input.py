"""What a user can get wrong: one plain line, exit status 2, nothing left running."""

import json
import os
import subprocess
import tempfile
from pathlib import Path

import pytest

from bridge.start_messages import MATCHER_NAMES
from tests.commands import Done
from tests.session.command import DEADLINE_S, ROOT, controller, refused, start_controller
from tests.session.serving import served

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


def test_the_matchers_are_those_of_the_messages() -> None:
    assert f"--matcher: 'best' is not one of {', '.join(MATCHER_NAMES)}" in refused("--matcher", "best")


def test_a_controller_s_file_may_be_the_first_option(tmp_path: Path) -> None:
    strategy = tmp_path / "mine.pl"
    strategy.write_text("proc(control, []).\n")
    for options in ([f"--controller={strategy}", "--dry-run"], ["--controller", str(strategy), "--dry-run"]):
        done = served(*options)
        assert done.returncode == 0, done.stderr
        assert str(strategy) in done.stderr
    assert "no such" in refused("--controller=no such.pl")
    made = subprocess.run(
        ["make", "--no-print-directory", "-n", "dock", f"ARGS=--controller={strategy} --dry-run"],
        cwd=ROOT, capture_output=True, text=True, timeout=DEADLINE_S, check=True,
    )  # fmt: skip
    assert made.stdout.splitlines()[-1] == f"swipl main.pl --controller={strategy} --dry-run"


def test_help_lists_the_options() -> None:
    done = controller("--help")
    assert done.returncode == 0
    text = done.stdout + done.stderr
    for option in ("--controller", "--target", "--stack", "--threshold", "--resume", "--approach", "--json"):
        assert option in text


def test_help_may_be_read_in_part() -> None:
    ours, theirs = os.pipe()
    os.close(ours)
    words = ["swipl", str(ROOT / "main.pl"), "--help"]
    done = subprocess.run(words, stdout=theirs, stderr=subprocess.PIPE, timeout=60, check=False)
    os.close(theirs)
    assert (done.returncode, done.stderr) == (0, b"")


REFUSED: list[tuple[list[str], list[str]]] = [
    (["--colour"], ["unknown option --colour (see --help)"]),
    (["--scenari", "nominal"], ["unknown option --scenari", "Did you mean --scenario?"]),
    (["--max-iteration", "3"], ["unknown option --max-iteration", "Did you mean --max-iterations?"]),
    (["--controller", "heuristc"], ["Did you mean heuristic?"]),
    (["--target", "sattelite"], ["Did you mean satellite?"]),
    (["--first-range", "2"], ["--first-range is of --approach"]),
    (["--contact-range", "2"], ["--contact-range is of --approach"]),
    (["--idle-s", "2"], ["--idle-s is of --keep-servers"]),
    (
        ["--keep-servers", "--image-server", "ipc:///a", "--vision-server", "ipc:///b"],
        ["--keep-servers has no"],
    ),
    (["--stack", ".", "--scenario", "nominal"], ["--scenario is of the simulator", "--stack"]),
    (["--image-server", "ipc:///a", "--scenario", "nominal"], ["--scenario is of the simulator"]),
    (["--quiet", "--explain"], ["--explain says what --quiet leaves out"]),
    (["--json", "--dry-run"], ["--json prints a result, and --dry-run comes to none"]),
    (["--approach", "--first-range", "0.2"], ["--first-range 0.2 must be more than --contact-range, 0.3 m"]),
    (["--out", str(ROOT / "README.md")], ["README.md is a file; name a folder"]),
    (["--threshold"], ["--threshold needs a value"]),
    (["--threshold", "low"], ["--threshold", "'low' is not a number"]),
    (["--threshold", "-1"], ["--threshold must be a positive number"]),
    (["--threshold", "1.5NaN"], ["--threshold must be a positive number of pixels, not 1.5NaN"]),
    (["--approach", "--first-range", "1.0Inf"], ["--first-range must be a positive number of metres"]),
    (["--seed", "1", "--seed", "2"], ["--seed is given more than once"]),
    (["--resume", "a", "--resume", "b"], ["--resume is given more than once"]),
    (["--resume", "a", "--report", "--no-report"], ["--report is given more than once"]),
    (["--report", "--no-report"], ["--report is given more than once"]),
    (["--explain", "--explain"], []),
    (["--max-iterations", "0"], ["--max-iterations must be at least 1"]),
    (["--seed", "x"], ["--seed", "whole number"]),
    (["--seed", "9223372036854775808"], ["--seed must be a whole number from 0 to 9223372036854775807"]),
    (["--instead", "i0: left 7, 1/60 s, f/4"], ["--instead: there is no image i0; the first one is i1"]),
    (["--instead", "i11: left 7, 1/60 s, f/4"], ["no image i11; a session takes at most 10"]),
    (["--matcher", "genetc"], ["is not one of search, genetic. Did you mean genetic?"]),
    (["cube"], ["unexpected argument 'cube'"]),
    (["--controller", "wizard"], ["--controller", "'wizard'", "heuristic"]),
    (["--target", "teapot"], ["teapot", "cube", "satellite"]),
    (["--scenario", "disco"], ["disco", "nominal"]),
    (["--stack", "/nowhere"], ["--stack", "/nowhere"]),
    (["--resume", "/nowhere"], ["--resume", "/nowhere"]),
    (["--again", "/nowhere"], ["--again", "/nowhere"]),
    (["--image-server", "localhost:1"], ["--image-server", "endpoint"]),
    (["--image-server", "tcp://localhost"], ["'tcp://localhost' is not an endpoint"]),
    (["--unit", "ell"], ["--unit", "m, cm, mm, in"]),
    (["--unit", "mm"], ["--unit", "--target"]),
    (["--camera-model", "/nowhere.toml"], ["--camera-model", "/nowhere.toml"]),
    (["--approach", "--stack", "."], ["--approach"]),
    (["--camera", "/dev/null", "--stack", "."], ["--stack and --camera exclude each other"]),
    (["--camera", "/dev/null"], ["--camera needs --target", "cube"]),
    (["--camera", "/dev/nowhere", "--target", "cube"], ["--camera", "there is no '/dev/nowhere'"]),
    (["--lights", "/dev/null"], ["--lights needs --camera"]),
    (["--out", "/proc/none"], ["--out", "/proc/none"]),
    (["--dry-run", "--out", "/proc/none"], ["--out: cannot make /proc/none"]),
    (["--dry-run", "--out", str(ROOT / "session")], ["session is in use for something else"]),
]
"""Options, and words of what is said of them."""


@pytest.fixture(scope="module")
def told() -> dict[str, str]:
    """What is said of each of them, all asked of one process."""
    asked = json.dumps([options for options, _ in REFUSED])
    done = subprocess.run(
        ["swipl", str(Path(__file__).with_name("refusals.pl"))],
        cwd=ROOT, input=asked, capture_output=True, text=True, timeout=DEADLINE_S, check=True,
    )  # fmt: skip
    return dict(zip((str(options) for options, _ in REFUSED), json.loads(done.stdout), strict=True))


@pytest.mark.parametrize(("options", "words"), REFUSED)
def test_options(told: dict[str, str], options: list[str], words: list[str]) -> None:
    message = told[str(options)]
    for word in words:
        assert word in message
    assert "Unknown" not in message


def test_an_option_is_refused_in_few_lines() -> None:
    assert "ERROR: unknown option --colour (see --help)" in refused("--colour")


def test_a_hold_point_inside_the_target_is_refused_before_anything_is_done() -> None:
    message = refused("--approach", "--target", "cube", "--contact-range", "0.1", "--dry-run", by=served)
    assert "--contact-range" in message
    assert "cannot come to 0.1 m" in message


def leaving_no_folder(*options: str | Path) -> Done:
    """A session that leaves none of its folders for temporary files."""
    session = start_controller(*options)
    out, err = session.communicate(timeout=DEADLINE_S)
    assert list(Path(tempfile.gettempdir()).glob(f"swipl_*_{session.pid}_*")) == []
    return subprocess.CompletedProcess(session.args, session.returncode, out, err)


@pytest.mark.slow
def test_a_dry_run_checks_what_a_session_needs_and_leaves_nothing(tmp_path: Path) -> None:
    (tmp_path / "bad.toml").write_text("x = [")
    message = refused("--scenario", tmp_path / "bad.toml", "--dry-run", by=leaving_no_folder)
    assert "bad.toml" in message
    assert "its log is" not in message
    (tmp_path / "bad.cao").write_text("V1 garbage")
    assert "bad.cao:1" in refused("--target", tmp_path / "bad.cao", "--dry-run")
    done = served("--dry-run", "--out", "new/run", cwd=tmp_path)
    assert done.returncode == 0
    assert "3 lights, 5 shutters, 3 apertures" in done.stderr
    assert {file.name for file in tmp_path.iterdir()} == {"bad.toml", "bad.cao"}


def test_stack_with_a_missing_image(tmp_path: Path) -> None:
    (tmp_path / "stack.toml").write_text(STACK)
    message = refused("--stack", tmp_path, "--out", tmp_path / "run")
    assert ".png" in message or "m.cao" in message


@pytest.mark.slow
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
