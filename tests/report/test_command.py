"""`python -m report`: what it writes, and one plain line for what it cannot use."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from bridge.errors import BadInput
from bridge.result_file import read_result
from report.__main__ import main
from tests.commands import started
from tests.report.run_folders import RunMaker

pytestmark = pytest.mark.slow


def run(root: Path, *arguments: str, said: str = "") -> subprocess.CompletedProcess[str]:
    """Run the command in the project's folder, with this on its standard input."""
    return subprocess.run(
        [sys.executable, "-m", "report", *arguments],
        cwd=root, input=said, capture_output=True, text=True, check=False,
    )  # fmt: skip


def test_it_writes_the_page(root: Path, make_run: RunMaker) -> None:
    folder = make_run()
    done = run(root, str(folder))
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.strip() == str(folder / "report.html")
    assert (folder / "report.html").stat().st_size > 10_000


@pytest.mark.parametrize(("said", "written"), [("\n", True), ("", False)])
def test_what_waits_writes_when_it_is_told_and_nothing_when_nobody_will(
    root: Path, make_run: RunMaker, said: str, written: bool
) -> None:
    folder = make_run()
    done = run(root, str(folder), "--when-told", said=said)
    assert (done.returncode, done.stderr) == (0, "")
    assert (folder / "report.html").exists() == written


@pytest.mark.parametrize(("sent", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_ends_it_without_a_word(make_run: RunMaker, sent: signal.Signals, status: int) -> None:
    folder = make_run()
    line = [sys.executable, "-m", "report", str(folder), "--when-told"]
    with started(line, stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as running:
        while "futex" not in (wait := Path(f"/proc/{running.pid}/wchan").read_text()) and "pipe" not in wait:
            time.sleep(0.01)
        running.send_signal(sent)
        assert running.wait(60) == status
        assert running.stderr is not None
        assert running.stderr.read() == ""


def test_help_lists_the_commands(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(sys, "argv", ["report", "--help"])
    with pytest.raises(SystemExit):
        main()
    lines = capsys.readouterr().out.split("Commands:\n")[1].splitlines()
    assert [line.split()[0] for line in lines if line[2:3].strip()][:2] == ["live", "whatif"]


def test_bad_input_is_one_plain_line(root: Path, tmp_path: Path) -> None:
    done = run(root, str(tmp_path / "nowhere"))
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    assert "no such folder" in done.stderr


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (None, "no result.json"),
        ("{", "not valid JSON"),
        ("[]", "Expected `object`"),
        ("{}", "status"),
        ('{"status": "converged", "rms_px": "low"}', "rms_px"),
        ('{"status": "converged", "covariance": [[1, 2], [3, 4]]}', "covariance"),
        ('{"status": "converged", "pose": {"rotation_vector": [0, 0], "translation": [0, 0, 1]}}', "pose"),
        (b"\xff\xfe\x00", "not valid JSON"),
    ],
)
def test_broken_results_are_named(tmp_path: Path, content: str | bytes | None, words: str) -> None:
    if content is not None:
        (tmp_path / "result.json").write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(BadInput, match=words) as caught:
        read_result(tmp_path)
    assert "\n" not in str(caught.value)


def test_a_session_that_was_killed_is_told_how_to_go_on(tmp_path: Path) -> None:
    (tmp_path / "history.pl").touch()
    with pytest.raises(BadInput, match=rf"has not ended\. Where it was killed, --resume {tmp_path} goes on"):
        read_result(tmp_path)


def test_a_result_is_read_whole(make_run: RunMaker) -> None:
    result = read_result(make_run())
    assert result.status == "converged"
    assert [step.decision for step in result.steps] == ["keep", "discard", "keep"]
    assert result.pose is not None
    assert json.loads(json.dumps(result.seconds))["total"] == 2.0
