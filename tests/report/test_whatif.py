"""`python -m report whatif`: a session again with another choice, and what it refuses."""

import json
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from bridge.result_file import read_result
from tests.commands import Done, process, report, started
from tests.session.cases import stack
from tests.session.serving import served

pytestmark = pytest.mark.slow

OTHER = "left 7 top 0, 1/15 s, f/2.8"


def what_if(*words: str | Path) -> Done:
    """In the process of the tests; `test_both_ways_are_the_same_up_to_the_choice` runs it as a user does."""
    return report("whatif", *words)


@pytest.fixture
def copy(three_images: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(three_images, tmp_path / "run"))


def test_both_ways_are_the_same_up_to_the_choice(three_images: Path, tmp_path: Path) -> None:
    words = (three_images, "--at", "2", "--settings", OTHER, "--out", tmp_path / "other")
    done = process("report", "whatif", *words, env={"COLUMNS": "80"})
    assert done.returncode == 0, done.stderr
    was, other = read_result(three_images), read_result(tmp_path / "other")
    assert other.steps[0] == was.steps[0]
    assert other.steps[1].settings_words == "left 7 right 0 top 0, 1/15 s, f/2.8"
    assert was.steps[1].settings_words != other.steps[1].settings_words
    assert len(other.steps) == 3
    for word in ("as it was", "what if", "merit", "true error"):
        assert word in done.stdout
    assert max(map(len, done.stdout.splitlines()[:-1])) <= 80
    page = (tmp_path / "other" / "whatif.html").read_text()
    assert page.count("<image ") == 4
    assert str(done.stdout.splitlines()[-1]) == str(tmp_path / "other" / "whatif.html")


@pytest.mark.parametrize("kind", ["basis", "frames"])
def test_a_stack_is_replayed_with_another_choice(kind: str, three_images: Path, tmp_path: Path) -> None:
    if kind == "frames":
        replayed = Path(shutil.copytree(three_images / "images", tmp_path / "stack"))
        other = "i1", read_result(three_images).steps[1].settings_words
    else:
        replayed = stack()
        other = "i2", "left 7, 1/15 s, f/4"
    never = ("--threshold", "0.000001", "--max-iterations", "3", "--no-report")
    assert served("--stack", replayed, "--out", tmp_path / "was", *never).returncode == 3
    at = other[0].removeprefix("i")
    done = what_if(tmp_path / "was", "--at", at, "--settings", str(other[1]), "--out", tmp_path / "new")
    assert done.returncode == 0, done.stderr
    was, new = read_result(tmp_path / "was"), read_result(tmp_path / "new")
    number = int(at)
    assert new.steps[: number - 1] == was.steps[: number - 1]
    assert new.steps[number - 1].settings != was.steps[number - 1].settings
    assert new.stack == was.stack == str(replayed)
    assert (tmp_path / "new" / "whatif.html").read_text().count("<image ") == 2 * (4 - number)


def test_the_nearest_recorded_frame_is_told_as_such(three_images: Path, tmp_path: Path) -> None:
    replayed = Path(shutil.copytree(three_images / "images", tmp_path / "stack"))
    never = ("--threshold", "0.000001", "--max-iterations", "2", "--no-report")
    assert served("--stack", replayed, "--out", tmp_path / "was", *never).returncode == 3
    exposure = str(read_result(three_images).steps[1].settings_words).split(", ", 1)[1]
    words = ("--at", "1", "--settings", f"left 1, {exposure}", "--out", tmp_path / "new")
    done = what_if(tmp_path / "was", *words)
    assert done.returncode == 0, done.stderr
    asked = f"asked for left 1 right 0 top 0, {exposure}; taken under"
    assert "asked for left 1" in done.stdout
    assert asked in (tmp_path / "new" / "whatif.html").read_text()


def test_the_same_settings_change_nothing(three_images: Path, tmp_path: Path) -> None:
    chosen = json.loads((three_images / "result.json").read_text())["steps"][1]["settings_words"]
    done = what_if(three_images, "--at", "2", "--settings", chosen, "--out", tmp_path / "same")
    assert done.returncode == 0, done.stderr
    assert read_result(tmp_path / "same").steps == read_result(three_images).steps


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--at", "4", "--settings", OTHER), "--at 4: there is no such image; it took 3 images"),
        (
            ("--at", "2", "--settings", "left 7 left 3, 1/60 s, f/4"),
            "--settings: the light left is named twice",
        ),
        (("--at", "2", "--settings", "left 8, 1/60 s, f/4"), "--settings: light left has no level 8"),
        (
            ("--at", "2", "--settings", "bright"),
            "--settings: 'bright' does not tell lights, shutter and aperture, as 'left",
        ),
    ],
)
def test_a_choice_that_cannot_be_made_leaves_nothing(copy: Path, words: tuple[str, ...], said: str) -> None:
    done = what_if(copy, *words)
    assert (done.returncode, done.stdout) == (2, "")
    assert said in done.stderr
    assert done.stderr.count("\n") == 1
    assert list(copy.parent.iterdir()) == [copy]


def test_a_signal_ends_the_session_and_leaves_nothing(copy: Path) -> None:
    other = copy.with_name("run-whatif-2")
    line = [sys.executable, "-m", "report", "whatif", str(copy), "--at", "2", "--settings", OTHER]
    with started(line, stderr=subprocess.PIPE) as running:
        while not (other / "images").exists():
            assert running.poll() is None
            time.sleep(0.01)
        running.send_signal(signal.SIGTERM)
        _, said = running.communicate(timeout=60)
    assert (running.returncode, said) == (143, b"")
    assert list(copy.parent.iterdir()) == [copy]


def test_a_folder_that_cannot_be_done_again_is_refused(copy: Path) -> None:
    def refused() -> str:
        done = what_if(copy, "--at", "1", "--settings", OTHER)
        assert done.returncode == 2
        assert done.stderr.count("\n") == 1
        return done.stderr

    told = (copy / "session.pl").read_text()
    (copy / "session.pl").write_text(told[:40])
    assert "session.pl is empty, cut or changed" in refused()
    (copy / "session.pl").write_text(told.replace("version(1).", "version(2)."))
    assert "session.pl is empty, cut or changed" in refused()
    (copy / "session.pl").write_text(told.replace("seed(5).", "seed(6)."))
    assert "session.pl is empty, cut or changed" in refused()
    (copy / "session.pl").unlink()
    assert "holds no session that was begun" in refused()
    (copy / "session.pl").write_text(told)
    result = json.loads((copy / "result.json").read_text())
    result["steps"][0]["rms_px"] += 0.01
    (copy / "result.json").write_text(json.dumps(result))
    assert "another way already at i1" in what_if(copy, "--at", "2", "--settings", OTHER).stderr
    shutil.rmtree(copy.with_name("run-whatif-2"))
    result["command"] = "swipl main.pl --image-server ipc:///tmp/x"
    (copy / "result.json").write_text(json.dumps(result))
    assert "--image-server, which cannot do the same again" in refused()
