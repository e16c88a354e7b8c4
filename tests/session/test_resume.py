"""A session that was interrupted goes on from its run folder, and comes to what it would have come to."""

import hashlib
import json
import shutil
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
import tomli_w

from bridge.serve import Server
from image_server.serve.server import ImageServer
from image_server.simulator.simulator import Simulator
from tests.session.command import (
    DEADLINE_S,
    ROOT,
    captured,
    cut,
    end_after,
    gone,
    outcome,
    running_session,
    start_controller,
)
from tests.session.scenes import SIZE, small
from tests.session.serving import KEEPING, served

pytestmark = pytest.mark.slow

NEVER = ("--seed", "3", "--threshold", "0.000001", "--no-report", "--max-iterations")


def test_cut_after_every_line_it_comes_to_the_same_outcome(tmp_path: Path) -> None:
    whole = tmp_path / "whole"
    harsh = ("--scenario", small("harsh"), *NEVER, "2")
    assert served(*harsh, "--out", whole, "--quiet").returncode in {0, 3}
    lines = (whole / "history.pl").read_text().splitlines(keepends=True)
    assert all(any(f"{action}(" in line for line in lines) for action in ("keep", "avoid", "discard"))
    for kept in range(1, len(lines)):
        out = tmp_path / f"cut{kept}"
        shutil.copytree(whole, out)
        (out / "result.json").unlink()
        (out / "history.pl").write_text("".join(lines[:kept]))
        resumed = served("--resume", out, "--no-report", "--quiet")
        assert resumed.returncode in {0, 3}, (lines[kept - 1], resumed.stderr)
        assert outcome(out) == outcome(whole), lines[kept - 1]
        shutil.rmtree(out)


def test_after_the_controller_was_killed(tmp_path: Path) -> None:
    session, servers = running_session(tmp_path)
    session.send_signal(signal.SIGKILL)
    session.communicate(timeout=DEADLINE_S)
    assert gone(servers)
    end_after(tmp_path / "history.pl", 6)
    resumed = served("--resume", tmp_path, "--no-report", "--json")
    assert resumed.returncode == 3, resumed.stderr
    result = json.loads(resumed.stdout)
    assert result["iterations"] == 6
    assert len({step["image"] for step in result["steps"]}) == 6
    assert all((tmp_path / "images" / f"{image}.png").exists() for image in result["kept"])


def test_a_finished_session_is_left_alone(tmp_path: Path) -> None:
    assert served("--out", tmp_path, "--scenario", small(), "--no-report", "--quiet").returncode == 0
    before = (tmp_path / "history.pl").read_text()
    again = served("--resume", tmp_path)
    assert again.returncode == 2
    assert "finished" in again.stderr
    assert (tmp_path / "history.pl").read_text() == before


def test_a_folder_with_the_target_s_name_is_not_the_target(tmp_path: Path) -> None:
    (tmp_path / "fixture").mkdir()
    out = tmp_path / "run"
    two = ("--controller", "simple", "--scenario", small(), *NEVER, "2")
    whole = served(*two, "--target", "fixture", "--out", out, "--quiet", cwd=tmp_path)
    assert whole.returncode == 3, whole.stderr
    cut(out / "history.pl", "capture(i1")
    resumed = served("--resume", out, "--no-report", "--json", cwd=tmp_path)
    assert resumed.returncode == 3, resumed.stderr
    assert json.loads(resumed.stdout)["target"] == "fixture"


def two_images() -> tuple[str | Path, ...]:
    """Options of a short session."""
    return ("--controller", "simple", "--scenario", small(), *NEVER, "2", "--quiet")


@pytest.fixture(scope="module")
def interrupted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A session of two images that was killed when its program had ended."""
    out = tmp_path_factory.mktemp("run")
    done = served(*two_images(), "--out", out)
    assert done.returncode == 3, done.stderr
    (out / "result.json").rename(out / "expected.json")
    return out


def refused(out: Path, *options: str | Path) -> str:
    """The one plain message with which a session is not resumed."""
    done = served("--resume", out, *options, "--no-report", "--quiet")
    assert done.returncode == 2, done.stderr
    assert len(done.stderr.strip().splitlines()) <= 2, done.stderr
    assert not (out / "result.json").exists()
    return done.stderr


def test_killed_before_the_result_was_written(interrupted: Path, tmp_path: Path) -> None:
    out = shutil.copytree(interrupted, tmp_path / "run")
    assert (out / "history.pl").read_text().endswith("ended(final).\n")
    assert served("--resume", out, "--no-report", "--quiet").returncode == 3
    (tmp_path / "whole").mkdir()
    (out / "expected.json").rename(tmp_path / "whole" / "result.json")
    assert outcome(out) == outcome(tmp_path / "whole")
    assert served("--resume", out).returncode == 2


def test_a_lost_last_frame_is_taken_again(interrupted: Path, tmp_path: Path) -> None:
    out = shutil.copytree(interrupted, tmp_path / "run")
    frame = (out / "images" / "i2.png").read_bytes()
    (out / "images" / "i2.png").unlink()
    assert served("--resume", out, "--no-report", "--quiet").returncode == 3
    assert (out / "images" / "i2.png").read_bytes() == frame
    (out / "expected.json").rename(tmp_path / "result.json")
    assert outcome(out) == outcome(tmp_path)


def test_frames_that_are_not_those_taken_are_refused(interrupted: Path, tmp_path: Path) -> None:
    out = shutil.copytree(interrupted, tmp_path / "run")
    shutil.copy(out / "images" / "i2.png", out / "images" / "i1.png")
    cut(out / "history.pl", "keep(i1")
    assert "not the frame that was taken" in refused(out)


@pytest.mark.parametrize("change", ["empty", "cut", "seed", "version", "code"])
def test_a_session_file_that_is_not_whole_is_refused(interrupted: Path, tmp_path: Path, change: str) -> None:
    out = shutil.copytree(interrupted, tmp_path / "run")
    file, mark = out / "session.pl", tmp_path / "mark"
    text = file.read_text()
    file.write_text(
        {
            "empty": "",
            "cut": text[: len(text) // 2],
            "seed": text.replace("seed(3)", "seed(4)"),
            "version": text.replace("version(1)", "version(9)"),
            "code": f":- shell('touch {mark}').\n{text}",
        }[change]
    )
    assert "empty, cut or changed" in refused(out)
    assert not mark.exists()


def test_what_a_controller_includes_is_a_part_of_it(tmp_path: Path) -> None:
    out, strategy, included = tmp_path / "run", tmp_path / "mine.pl", tmp_path / "theirs.pl"
    source = (ROOT / "domain" / "controllers" / "simple.pl").read_text()
    included.write_text(source)
    strategy.write_text(":- include(theirs).\n")
    options = ("--scenario", small(), *NEVER, "2")
    assert served("--controller", strategy, *options, "--out", out, "--quiet").returncode == 3
    (out / "result.json").unlink()
    included.write_text(f"{source}\nproc(more, []).\n")
    message = refused(out)
    assert "not the file any more" in message and f"--again {out} --controller {strategy}" in message
    anew = ("--again", out, "--controller", strategy, "--out", tmp_path / "again", "--no-report", "--quiet")
    assert served(*anew).returncode == 3
    strategy.rename(tmp_path / "elsewhere.pl")
    assert f"{strategy} is not there any more: put back the file" in refused(out)
    (tmp_path / "elsewhere.pl").rename(strategy)
    included.write_text(source)
    assert served("--resume", out, "--quiet").returncode == 3


def test_a_controller_that_came_with_the_folder_runs_only_when_the_user_says_so(tmp_path: Path) -> None:
    out, strategy, mark = tmp_path / "run", tmp_path / "mine.pl", tmp_path / "mark"
    source = (ROOT / "domain" / "controllers" / "simple.pl").read_text()
    strategy.write_text(source)
    done = served("--controller", strategy, "--scenario", small(), *NEVER, "2", "--out", out, "--quiet")
    assert done.returncode == 3, done.stderr
    (out / "result.json").unlink()
    strategy.write_text(f"{source}\n:- shell('touch {mark}').\n")
    assert "not the file any more" in refused(out)
    assert "not the file any more" in refused(out, "--controller", strategy)
    assert not mark.exists()
    strategy.write_text(source)
    assert "leave --seed out" in refused(out, "--seed", "4")
    inside = out / "mine.pl"
    inside.write_text(source)
    rewritten(out / "session.pl", f"'{strategy}'", f"'{inside}'")
    assert "if you trust it, add --controller" in refused(out)
    assert served("--resume", out, "--controller", inside, "--no-report", "--quiet").returncode == 3


def rewritten(file: Path, old: str, new: str) -> None:
    """Change a session file as who wants to be believed does."""
    body, found, _ = file.read_text().replace(old, new).rpartition("sha256(")
    assert found
    assert new in body
    file.write_text(f"{body}sha256('{hashlib.sha256(body.encode()).hexdigest()}').\n")


def test_a_folder_is_one_session_s_at_a_time(tmp_path: Path) -> None:
    session = start_controller("--out", tmp_path / "run", "--scenario", small(), *NEVER, "1000", *KEEPING)
    try:
        captured(session, tmp_path / "run", "i1")
        for option in ("--resume", "--out"):
            second = served(option, tmp_path / "run")
            assert second.returncode == 2
            assert f"another session is running in {tmp_path / 'run'}" in second.stderr
        assert session.poll() is None
    finally:
        session.terminate()
        session.communicate(timeout=DEADLINE_S)


def test_a_folder_in_use_is_not_mixed(interrupted: Path, tmp_path: Path) -> None:
    assert "interrupted session" in served("--out", interrupted).stderr
    (tmp_path / "thesis.tex").touch()
    other = served("--out", tmp_path)
    assert other.returncode == 2
    assert "thesis.tex" in other.stderr
    nothing = served("--out", "", cwd=tmp_path)
    assert nothing.returncode == 2
    assert "--out" in nothing.stderr
    assert {file.name for file in tmp_path.iterdir()} == {"thesis.tex"}


@pytest.mark.parametrize("session_bytes", [0, 20, None])
def test_a_session_that_was_killed_before_it_began_is_begun_by_its_command(
    interrupted: Path, tmp_path: Path, session_bytes: int | None
) -> None:
    out = tmp_path / "run"
    out.mkdir()
    (out / "session.pl").write_bytes((interrupted / "session.pl").read_bytes()[:session_bytes])
    (out / "history.pl").write_text("begun(sess")
    (out / ".write-test").touch()
    assert "begun anew by its command" in refused(out)
    anew = served(*two_images(), "--out", out)
    assert anew.returncode == 3, anew.stderr
    assert (out / "session.pl").read_text() == (interrupted / "session.pl").read_text()
    assert (out / "history.pl").read_text().count("begun(") == 1


@contextmanager
def scene(folder: Path, target: str, seed: int, scenario: Path) -> Iterator[str]:
    """An image server of the user's, at an endpoint that is always the same."""
    endpoint = f"ipc://{folder}/images"
    server = Server(ImageServer(Simulator(target, str(scenario), seed)), endpoint, f"{endpoint}-events")
    thread = threading.Thread(target=server.run)
    thread.start()
    try:
        yield endpoint
    finally:
        server.stop()
        thread.join(DEADLINE_S)


def test_the_images_go_on_coming_from_where_they_came(interrupted: Path, tmp_path: Path) -> None:
    out = tmp_path / "run"
    with TemporaryDirectory(prefix="s") as folder:
        with scene(Path(folder), "satellite", 9, small()) as endpoint:
            done = served("--image-server", endpoint, *NEVER, "2", "--out", out)
            assert done.returncode == 3, done.stderr
            (out / "result.json").unlink()
            cut(out / "history.pl", "keep(i1)")
        for target, seed in [("satellite", 8), ("cube", 9)]:
            with scene(Path(folder), target, seed, small()):
                assert "another target or scene" in refused(out)
        with scene(Path(folder), "satellite", 9, small()) as endpoint:
            assert "not from --image-server" in refused(interrupted, "--image-server", endpoint)
            resumed = served("--resume", out, "--no-report")
            assert resumed.returncode in {0, 3}, resumed.stderr
    assert not (out / "image_server.log").exists()


LAMP = '[[lights]]\nname = "{}"\nposition = [{}, 0.0, 0.0]\n'


def test_images_under_other_lights_are_refused(tmp_path: Path) -> None:
    left, right = LAMP.format("left", -0.35), LAMP.format("right", 0.35)
    camera, lamps, out = tomli_w.dumps({"camera": SIZE}), tmp_path / "lamps.toml", tmp_path / "run"
    with TemporaryDirectory(prefix="s") as folder:
        lamps.write_text(camera + left + right)
        with scene(Path(folder), "cube", 9, lamps) as endpoint:
            done = served("--image-server", endpoint, *NEVER, "2", "--out", out)
            assert done.returncode == 3, done.stderr
        (out / "result.json").unlink()
        cut(out / "history.pl", "keep(i1)")
        for other, said in [
            (right + left, "lights: right, left; at its beginning left, right"),
            (left + right + "levels = 2\n", "levels of the light right (2): 2; at its beginning 8"),
        ]:
            lamps.write_text(camera + other)
            with scene(Path(folder), "cube", 9, lamps):
                assert said in refused(out)
        lamps.write_text(camera + left + right)
        with scene(Path(folder), "cube", 9, lamps):
            resumed = served("--resume", out, "--no-report")
            assert resumed.returncode in {0, 3}, resumed.stderr


def test_what_cannot_be_resumed_is_said(tmp_path: Path) -> None:
    nothing = served("--resume", tmp_path)
    assert nothing.returncode == 2
    assert "holds no session" in nothing.stderr
    other = served("--resume", tmp_path, "--target", "cube")
    assert other.returncode == 2
    assert "leave --target out" in other.stderr
