"""Tests in forked processes: each is run once, with what its file shares, and no end of one is lost."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
HEAD = "import os, sys, time, warnings, pytest\n"


def begun(folder: Path, *words: str) -> "subprocess.Popen[str]":
    """Pytest on a folder of tests of its own."""
    (folder / "pytest.ini").write_text("[pytest]\n")
    command = [sys.executable, "-m", "pytest", "-p", "tests.side_by_side", "-p", "no:cacheprovider", "-v"]
    alone = {"PYTHONPATH": str(ROOT), "PYTHONDONTWRITEBYTECODE": "1", "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    return subprocess.Popen(
        [*command, *words], cwd=folder, env=os.environ | alone, text=True, stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )  # fmt: skip


def told(folder: Path, *words: str) -> tuple[int, str]:
    """Its exit status, and what it says of two processes."""
    running = begun(folder, "--beside", "2", *words)
    said = running.communicate(timeout=120)[0]
    return running.returncode, said


def written(folder: Path, **files: str) -> Path:
    for name, text in files.items():
        (folder / f"{name}.py").write_text(HEAD + text)
    return folder


PLACE = """
print("collected", os.getpid(), file=open("collected", "a"))
@pytest.fixture(scope="module")
def place(tmp_path_factory):
    yield tmp_path_factory.mktemp("place")
    print("left", file=open("left", "a"))
@pytest.mark.parametrize("number", range(6))
def test_it(place, number, capfd):
    os.write(1, b"word %d" % number)
    time.sleep(0.05)
    assert capfd.readouterr().out == f"word {number}"
    assert len(list(place.iterdir())) == number  # of this file's tests alone
    (place / str(number)).write_text(str(os.getpid()))
    assert len({file.read_text() for file in place.iterdir()}) == 1
    print(os.getpid(), file=open("ran", "a"))
"""


def test_files_are_collected_once_and_each_is_run_by_one_of_two(tmp_path: Path) -> None:
    status, said = told(written(tmp_path, test_a=PLACE, test_b=PLACE))
    assert status == 0, said
    assert "12 passed" in said
    collected, ran = ((tmp_path / name).read_text().splitlines() for name in ("collected", "ran"))
    assert len(collected) == 2 and len(set(collected)) == 1
    assert len(ran) == 12 and len(set(ran)) == 2
    assert (tmp_path / "left").read_text() == "left\nleft\n"


def test_what_fails_warns_or_is_skipped_is_told_as_ever(tmp_path: Path) -> None:
    tests = (
        "def test_wrong():\n    print('seen before')\n    x = 3\n    assert x == 4\n"
        "def test_skipped():\n    pytest.skip('for a reason')\n"
        "def test_warns():\n    warnings.warn('mind this', DeprecationWarning)\n"
        "@pytest.fixture\ndef broken():\n    raise OSError('no disk')\n"
        "def test_unprepared(broken):\n    pass\n"
    )
    status, said = told(written(tmp_path, test_a=tests), "-rs")
    assert status == 1, said
    assert "1 failed, 1 passed, 1 skipped, 1 warning, 1 error" in said
    for words in ("assert 3 == 4", "seen before", "for a reason", "DeprecationWarning: mind this", "no disk"):
        assert words in said


def test_a_file_that_cannot_be_read_ends_it(tmp_path: Path) -> None:
    status, said = told(written(tmp_path, test_a="def test_well(): pass\n", test_b="import nowhere\n"))
    assert status == 2, said
    assert "No module named 'nowhere'" in said and "passed" not in said


@pytest.mark.parametrize("deadly", [0, 1, 2])
def test_a_test_that_ends_its_process_has_failed_and_the_others_are_run(tmp_path: Path, deadly: int) -> None:
    test = "def test_{}(): {}\n"
    ends = "os.kill(os.getpid(), 9)"
    tests = "".join(test.format(number, ends if number == deadly else "pass") for number in range(3))
    status, said = told(written(tmp_path, test_a=tests, test_b=test.format("other", "time.sleep(0.3)")))
    assert status == 1, said
    assert "1 failed, 3 passed" in said
    assert f"FAILED test_a.py::test_{deadly} - the process that ran it ended, exit status -9" in said


def test_what_the_session_s_fixtures_leave_badly_is_a_failure(tmp_path: Path) -> None:
    fixture = "@pytest.fixture(scope='session')\ndef bad():\n    yield\n    raise OSError('no disk')\n"
    test = "def test_well(bad): pass\n"
    status, said = told(written(tmp_path, conftest=fixture, test_a=test, test_b=test))
    assert status == 1, said
    assert "2 passed" in said and "exit status" in said and "no disk" in said


def test_the_first_failure_may_end_it(tmp_path: Path) -> None:
    slow = "@pytest.mark.parametrize('n', range(9))\ndef test_slow(n): time.sleep(0.5)\n"
    status, said = told(written(tmp_path, test_a="def test_no(): assert False\n", test_b=slow), "-x")
    assert status == 1, said
    assert "stopping after 1 failures" in said
    assert int((re.findall(r"(\d+) passed", said) or ["0"])[0]) < 9


def test_who_breaks_it_off_leaves_no_process(tmp_path: Path) -> None:
    waits = "def test_waits():\n    open(f'pid-{os.getpid()}', 'w')\n    time.sleep(100)\n"
    running = begun(written(tmp_path, test_a=waits, test_b=waits), "--beside", "2")
    deadline = time.monotonic() + 60
    while len(pids := [file.name[4:] for file in tmp_path.glob("pid-*")]) < 2:
        assert time.monotonic() < deadline
        time.sleep(0.02)
    running.send_signal(signal.SIGINT)
    said = running.communicate(timeout=60)[0]
    assert running.returncode == 2, said
    assert "KeyboardInterrupt" in said
    assert not any(Path(f"/proc/{pid}").exists() for pid in pids)


def test_without_the_option_one_process_does_it(tmp_path: Path) -> None:
    running = begun(written(tmp_path, test_a=PLACE, test_b=PLACE))
    said = running.communicate(timeout=60)[0]
    assert running.returncode == 0, said
    assert {*(tmp_path / "ran").read_text().split()} == {str(running.pid)}
