"""The live view in a browser, of a real session and of folders that are not as they should be."""

import json
import re
import subprocess
import sys
import time
from pathlib import Path
from urllib.parse import urlsplit

import pytest

from bridge.errors import BadInput
from geometry.drawn_wireframes import WIREFRAMES
from report.following import Follower
from report.holding import hold
from tests.report.browser import Browser, chromium
from tests.report.run_folders import RunMaker
from tests.report.viewers import ADDRESS, asked, listening, next_part, told, view_of
from tests.session.command import ROOT, gone, start_controller
from tests.session.scenes import small
from tests.session.serving import KEEPING

pytestmark = pytest.mark.slow

ENDLESS = ("--controller", "greedy", "--threshold", "0.000001", "--max-iterations", "1000")


def test_a_real_session_is_followed_paused_stepped_and_seen_to_its_end(tmp_path: Path) -> None:
    chromium()
    session = start_controller("--view", "--out", tmp_path, "--scenario", small(), *ENDLESS, "--no-report")
    assert session.stderr is not None
    try:
        address = next(found[1] for line in session.stderr if (found := ADDRESS.match(line)))
        hold_soon(tmp_path)
        with Browser() as page:
            badge = 'document.querySelector("#status .badge")?.innerText'

            def press(word: str) -> None:
                page.value(f'document.querySelector("[data-word={word}]").click()')

            page.open(address)
            page.until(f'{badge} == "paused"')
            done = 'document.querySelectorAll("#events li").length'
            before = page.value(done)
            press("step")
            page.until(f"{done} == {before + 1}")
            time.sleep(1.0)
            assert page.value(done) == before + 1  # and waits again
            press("go")
            page.until('document.querySelectorAll("#set .step").length >= 3')
            press("pause")
            page.until(f'{badge} == "paused"')
            assert page.value('document.querySelectorAll("#choice tbody tr").length') == 5 + 2
            times = page.value('document.getElementById("time").innerText')
            assert "matching" in times and "until the last image" in times.lower()
            assert page.value('document.querySelector("#program mark") != null')
            assert page.value('document.querySelector("#now .supported") != null')
            pictures = page.value('[...document.querySelectorAll("#now image")].map(one => one.href.baseVal)')
            assert [re.sub(r"\d+|\?.*", "", one) for one in pictures] == [
                "images/i.png",
                "images/i-edges.png",
            ]
            for one in pictures:
                assert page.value(f'fetch("{one}").then(answer => answer.status)') == 200
            press("stop")
            page.until('document.getElementById("link").innerText.includes("has ended")')
            assert page.value(badge) == "stopped"
            assert "matching" in page.value('document.getElementById("time").innerText')
        assert session.wait(120) == 143
    finally:
        session.kill()
        session.communicate()
    assert not {"hold", "held", "seconds.json"} & {file.name for file in tmp_path.iterdir()}


def hold_soon(folder: Path) -> None:
    """Tell a session to pause as soon as there is one."""
    deadline = time.monotonic() + 120
    while True:
        try:
            return hold(folder, "pause")
        except BadInput:
            assert time.monotonic() < deadline
            time.sleep(0.02)


def test_a_session_that_is_told_to_stop_ends_as_by_sigterm_and_its_view_with_it(tmp_path: Path) -> None:
    options = ("--scenario", small(), *ENDLESS, "--no-report", *KEEPING)
    session = start_controller("--view", "--out", tmp_path, *options)
    assert session.stderr is not None
    address = next(found[1] for line in session.stderr if (found := ADDRESS.match(line)))
    viewers = [int(view.name) for view in views_of(tmp_path)]
    while not (tmp_path / "history.pl").exists():
        time.sleep(0.05)
    assert told(address, "stop") == (200, "")
    session.communicate(timeout=120)
    assert session.returncode == 143
    assert json.loads((tmp_path / "result.json").read_text())["status"] == "stopped"
    assert len(viewers) == 1 and gone({"view": viewers[0]})


def views_of(folder: Path) -> list[Path]:
    """The processes that serve a folder's page, under /proc."""
    return [name for name in Path("/proc").iterdir() if name.name.isdigit() and is_view(name, folder)]


def test_a_view_that_nobody_opens_loads_nothing_and_one_that_is_looked_at_no_kernels(
    make_run: RunMaker,
) -> None:
    folder = make_run()
    (folder / "images" / WIREFRAMES).write_text("")

    def loaded(package: str) -> bool:
        (view,) = views_of(folder)
        return f"/{package}/" in (view / "maps").read_text()

    with view_of(folder) as address:
        time.sleep(1.0)
        assert not any(loaded(package) for package in ("numpy", "cv2", "llvmlite", "zmq", "msgspec"))
        listening(address)[0].close()
        assert loaded("numpy") and not loaded("llvmlite") and not loaded("cv2")


def test_one_of_two_browsers_goes_away_in_the_middle_and_the_other_sees_the_end(tmp_path: Path) -> None:
    chromium()
    session = start_controller(
        "--view", "--out", tmp_path, "--controller", "greedy", "--threshold", "0.000001",
        "--max-iterations", "4", "--no-report", "--scenario", small(),
    )  # fmt: skip
    assert session.stderr is not None
    try:
        address = next(found[1] for line in session.stderr if (found := ADDRESS.match(line)))
        hold_soon(tmp_path)
        with Browser() as stays:
            stays.open(address)
            with Browser(alone=True) as leaves:
                leaves.open(address)
                for page in (stays, leaves):
                    page.until('document.querySelector("#status .badge")?.innerText == "paused"')
                stays.value('document.querySelector("[data-word=go]").click()')
                leaves.until('document.querySelectorAll("#set .step").length >= 1')
            stays.until('document.getElementById("link").innerText.includes("has ended")')
            assert stays.value('document.querySelectorAll("#set .step").length') == 4
            assert stays.value('document.querySelector("#status .badge").innerText') == "exhausted"
        session.communicate()
        assert session.returncode == 3
    finally:
        session.kill()
        session.communicate()
    assert gone({view.name: int(view.name) for view in views_of(tmp_path)})


def is_view(process: Path, folder: Path) -> bool:
    try:
        words = (process / "cmdline").read_bytes().split(b"\0")
    except OSError:
        return False
    return b"live" in words and str(folder).encode() in words


def test_who_has_not_the_token_sees_and_does_nothing(make_run: RunMaker) -> None:
    with view_of(make_run()) as address:
        for path in ("/", "/events", "/images/i1.png"):
            for token in ("", "wrong", "%C3%A4"):
                status, text = asked(address, path, token)
                assert status == 403 and "token is missing or wrong" in text and text.count("\n") == 1
        assert asked(address, Host="elsewhere.example:80")[0] == 403  # a name that leads here
        parts = urlsplit(address)
        assert told(f"http://127.0.0.1:{parts.port}/?token=wrong", "stop")[0] == 403
        assert asked(address)[0] == 200
        assert asked(address, "/images/i1.png")[0] == 200
        for path in ("/images/i9.png", "/images/stack.toml", "/images/..%2fresult.json"):
            assert asked(address, path)[0] == 404
        assert told(address, "stop") == (409, "the session has ended: it cannot be told anything any more\n")


def test_viewers_come_and_go(make_run: RunMaker) -> None:
    folder = make_run()
    with view_of(folder) as address:
        first, second = listening(address), listening(address)
        first[0].close()
        (folder / "images" / "i3.png").unlink()
        time.sleep(0.5)
        changed = next_part(second[1])
        assert "i2.png" in changed["now"] and "pose" not in changed  # only what is new
        second[0].close()
        assert asked(address)[0] == 200


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("session.pl", "version(99).\n", "empty, cut or changed"),
        ("session.pl", "", "empty, cut or changed"),
        ("history.pl", "begun(session,1).\nexecuted(0,connect,", "session.pl"),
    ],
)
def test_what_cannot_be_followed_is_told_on_the_page(
    make_run: RunMaker, name: str, content: str, words: str
) -> None:
    folder = make_run()
    (folder / "history.pl").write_text("begun(session,1).\n")
    (folder / name).write_text(content)
    follower = Follower(folder)
    try:
        state = follower.look()
        assert state is not None and state.status == "converged"  # its result is there
        assert words in state.told.problem and "\n" not in state.told.problem
        assert follower.look() is None
    finally:
        follower.close()


LOCKED = """
import fcntl, sys
file = open(sys.argv[1], "r+")
fcntl.lockf(file, fcntl.LOCK_EX)
print(flush=True)
input()
"""


def test_a_session_is_paused_when_its_action_has_ended(make_run: RunMaker) -> None:
    folder = make_run()
    (folder / "result.json").unlink()
    (folder / "session.pl").touch()
    works = [sys.executable, "-c", LOCKED, str(folder / "session.pl")]
    with subprocess.Popen(works, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as session:
        assert session.stdout is not None and session.stdout.readline()
        hold(folder, "pause")
        follower = Follower(folder)
        busy = follower.look()
        (folder / "held").touch()
        waits = follower.look()
        session.kill()
    assert busy is not None and busy.status == "running"
    assert waits is not None and waits.status == "paused"


def test_a_broken_result_is_told_on_the_page(make_run: RunMaker) -> None:
    folder = make_run()
    (folder / "result.json").write_text('{"status": ')
    follower = Follower(folder)
    state = follower.look()
    assert state is not None and state.status == "broken"
    assert "not valid JSON" in str(state.result.message)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["nowhere"], "no such folder"),
        (["."], "no session was begun here"),
        ([".", "--port", "99999"], "must be 0 to 65535"),
        ([], "RUN_FOLDER"),
    ],
)
def test_bad_input_is_one_plain_line(tmp_path: Path, words: list[str], said: str) -> None:
    here = [str(tmp_path / word) if word in (".", "nowhere") else word for word in words]
    done = subprocess.run(
        [sys.executable, "-m", "report", "live", *here], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert said in done.stderr.splitlines()[-1]
    assert "Traceback" not in done.stderr
