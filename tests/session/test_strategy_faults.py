"""A strategy that goes wrong while it runs: what went wrong and where, and everything is ended."""

import json
import signal
import time
from pathlib import Path

import pytest

from tests.commands import Done
from tests.session.command import gone, servers_of, start_controller
from tests.session.scenes import small
from tests.session.serving import served

pytestmark = pytest.mark.slow

FIRST = "proc(control, [choose_reference, take_image, measure,\n {}, keep_image]).\n{}\n"


def session(tmp_path: Path, step: str, helper: str, *options: str) -> tuple[Done, Path]:
    """A session by a strategy in which this step, in line 2, comes after the first estimate."""
    file = tmp_path / "mine.pl"
    file.write_text(FIRST.format(step, helper))
    words = ("--controller", file, "--scenario", small(), "--out", tmp_path / "run", "--no-report", "--quiet")
    return served(*words, *options), file


@pytest.mark.parametrize(
    ("step", "helper", "line", "words"),
    [
        ("pi(s, [?(p(settings, s)), choose(s)])", "p(S, S) :- _ is 1/0.", 2,
         ["the test p(settings,_)", "zero_divisor"]),
        ("if(p(fix), [], [])", "p(_) :- atom_length(_, _).", 2,
         ["the test p(fix)", "atom_length/2", "instantiated"]),
        ("if(fix > 3, [], [])", "", 2, ["the test fix>3", "Type error"]),
        ("?(p(fix))", "p(F) :- nowhere(F).", 2, ["the test p(fix)", "nowhere/1"]),
        ("?(p)", "p :-\n throw(mine(1)).", 4, ["the strategy threw mine(1)"]),
        ("?(p)", "p :- halt.", 2, ["the test p", "halt was called"]),
        ("?(p)", "p :- call(halt, 0).", 2, ["halt was called"]),
        ("?(taken > 7)", "", 2, ["taken>7 is false"]),
        ("if(taken > 0, abort, [])", "", 2, ["ended by `abort`"]),
        ("estimate([i7])", "", 2, ["estimate/1 is refused: No image i7"]),
        ("predict(device, [], [i7])", "", 2, ["predict/3 is refused: No image i7"]),
        ("set_parameter(matcher, 7)", "", 2,
         ["set_parameter/2 is refused: Parameter matcher must be one of search, genetic, not 7."]),
        ("[keep_image, capture('../evil', settings)]", "", 2, ["capture/2 is refused: ", "$.image"]),
        ("look", "prim_action(look). poss(look, true). fun_fluent(c). senses(look, c).\nexecute(look, _).", 4,
         ["execute(look,_)", "no sensing result was given for look"]),
        ("[]", "exog_action(rang(_)). :- dynamic looks/1. looks(0).\n"
         "exog_occurs(rang(_)) :- retract(looks(N)), M is N + 1, assertz(looks(M)), M > 4.", 4,
         ["exog_occurs(_)", "is not ground"]),
        ("?(p(0))", "p(N) :- M is N + 1, p(M), N < 3.", 3, ["used up its memory", "p/1", "never end?"]),
    ],
)  # fmt: skip
def test_it_is_said_with_its_place(
    tmp_path: Path, step: str, helper: str, line: int, words: list[str]
) -> None:
    done, file = session(tmp_path, step, helper)
    assert done.returncode == 2, done.stderr
    told = [one for one in done.stderr.splitlines() if not one.startswith("Warning: ")]  # of loading
    assert told[0].startswith(f"ERROR: {file}:{line}: ")
    assert len(told) <= 3
    assert all(word in done.stderr for word in words), done.stderr
    assert "indigolog_theory" not in done.stderr and "--resume" not in done.stderr
    result = json.loads((tmp_path / "run" / "result.json").read_text())
    assert result["status"] == "stopped"
    assert result["message"].startswith(f"{file}:{line}: ")


@pytest.mark.parametrize("images", [0, 1])
def test_why_rules_go_no_further_is_said(tmp_path: Path, images: int) -> None:
    file = tmp_path / "mine.pl"
    file.write_text(
        "proc(control, prioritized_interrupts([\n"
        " interrupt(neg(candidate = none), drop_image(no)),\n"
        f" interrupt(true, [?(fewer(taken, {images})), choose_reference, take_image])])).\n"
        "fewer(N, Most) :- N < Most.\n"
    )
    done = served("--controller", file, "--scenario", small(), "--out", tmp_path / "run", "--no-report")
    assert done.returncode == 3, done.stderr
    assert "why the strategy went no further:" in done.stderr
    assert f"fewer(taken,{images}) is false\n  taken = {images}\n" in done.stderr


def test_a_hold_point_has_one_of_three_outcomes(tmp_path: Path) -> None:
    file = tmp_path / "mine.pl"
    file.write_text("proc(control,\n hold_done(why(x))).\n")
    options = ("--approach", "--scenario", small("approach"), "--out", tmp_path / "run", "--no-report")
    done = served("--controller", file, *options, "--quiet")
    assert done.returncode == 2, done.stderr
    assert f"{file}:2: " in done.stderr
    assert "member(why(x),[fixed,reached,aborted]) is false" in done.stderr


def test_words_in_utf_8_stay_what_they_are(tmp_path: Path) -> None:
    file = tmp_path / "mine.pl"
    file.write_text(
        "proc(control, [choose_reference, take_image, measure, drop_image(größer), choose_reference,\n"
        " take_image, measure, drop_image('暗い')]).\n",
        encoding="utf-8",
    )
    run = tmp_path / "run"
    served("--controller", file, "--scenario", small(), "--out", run, "--no-report", "--quiet")
    steps = json.loads((run / "result.json").read_text(encoding="utf-8"))["steps"]
    assert [step["reason"] for step in steps] == ["größer", "暗い"]
    assert "discard(i1,größer)" in (run / "history.pl").read_text(encoding="utf-8")


def test_it_may_not_end_the_process_while_it_is_loaded(tmp_path: Path) -> None:
    file = tmp_path / "mine.pl"
    file.write_text("proc(control, []).\n:- initialization(halt).\n")
    done = served("--controller", file, "--out", tmp_path / "run", "--no-report")
    assert done.returncode == 2
    assert f"{file}:2: " in done.stderr and "halt was called" in done.stderr
    assert not (tmp_path / "run").exists()


def test_its_servers_end_with_it_and_its_folder_can_be_resumed(tmp_path: Path) -> None:
    (tmp_path / "mine.pl").write_text(
        FIRST.format("?(p)", f"p :- exists_file('{tmp_path}/there'), !.\np :- halt.")
    )
    options = ["--controller", tmp_path / "mine.pl", "--out", tmp_path / "run", "--no-report", "--quiet"]
    started = start_controller(*options, "--scenario", small())
    journal = tmp_path / "run" / "history.pl"
    while not journal.exists():
        assert started.poll() is None
        time.sleep(0.02)
    servers = servers_of(started.pid)
    _, messages = started.communicate(timeout=60)
    assert started.returncode == 2, messages
    assert len(servers) == 2 and gone(servers, 10)
    (tmp_path / "there").touch()
    done = served("--resume", tmp_path / "run", "--no-report", "--quiet")
    assert done.returncode == 0, done.stderr
    assert "message" not in json.loads((tmp_path / "run" / "result.json").read_text())


def test_a_helper_that_never_ends_is_named(tmp_path: Path) -> None:
    file = tmp_path / "mine.pl"
    file.write_text(FIRST.format("?(p)", "p :- repeat, fail."))
    options = ("--controller", file, "--scenario", small(), "--out", tmp_path / "run", "--no-report")
    running = start_controller(*options)
    said = ""
    while "the strategy computes" not in said:
        line = running.stderr.readline()  # type: ignore[union-attr]
        assert line, said
        said += line
    assert f"the strategy computes in p/0 ({file}:3) ..." in said
    running.send_signal(signal.SIGINT)
    _, rest = running.communicate(timeout=60)
    assert running.returncode == 130
    assert f"stopped while the strategy computed in p/0 ({file}:3)" in rest


def test_what_it_waits_for_is_said(tmp_path: Path) -> None:
    file = tmp_path / "mine.pl"
    file.write_text("proc(control, wait).\nexog_action(rang).\n")
    options = ("--controller", file, "--scenario", small(), "--out", tmp_path / "run", "--no-report")
    running = start_controller(*options)
    said = ""
    while "the strategy waits for an event" not in said:
        line = running.stderr.readline()  # type: ignore[union-attr]
        assert line, said
        said += line
    running.terminate()
    assert "stopped while the strategy waited for an event" in running.communicate(timeout=60)[1]


SENSES = """fun_fluent(mood).
prim_action(ask).
poss(ask, true).
senses(ask, mood).
{}
proc(control, ask).
"""


@pytest.mark.parametrize(
    ("clause", "line", "words"),
    [
        ("", 4, "nothing tells what ask/0 senses: write a clause of execute/2"),
        ("execute(ask, _) :-\n open('not there', read, _).", 5, "execute(ask,_) came to an error: open/3"),
        ("execute(ask, _) :- fail.", 5, "execute(ask,_) came to an error"),
    ],
)
def test_what_it_senses_by_itself_is_not_asked_of_a_person(
    tmp_path: Path, clause: str, line: int, words: str
) -> None:
    file = tmp_path / "mine.pl"
    file.write_text(SENSES.format(clause))
    options = ("--controller", file, "--scenario", small(), "--out", tmp_path / "run", "--no-report")
    done = served(*options, "--quiet")
    assert done.returncode == 2, done.stderr
    assert f"{file}:{line}: {words}" in done.stderr


def test_ctrl_c_in_a_program_that_it_calls_stops_the_session(tmp_path: Path) -> None:
    done, _ = session(tmp_path, "?(shell('kill -INT $$'))", "")
    assert done.returncode == 130, done.stderr
    assert "ERROR" not in done.stderr
    assert "Ctrl-C" in json.loads((tmp_path / "run" / "result.json").read_text())["message"]


def test_what_it_prints_is_not_in_the_result_that_json_asks_for(tmp_path: Path) -> None:
    helper = 'p :- format("one~n"), format(user_output, "two~n", []).'
    done, _ = session(tmp_path, "?(p)", helper, "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["kept"] == ["i1"]
    assert done.stderr.splitlines()[:2] == ["one", "two"]


@pytest.mark.parametrize(
    ("program", "words"),
    [
        ("[]", "takes an image"),
        ("[choose_reference, take_image, measure, drop_image(no)]", "discarded all that did"),
        ("[choose_reference, take_image, measure]", "left the last one open"),
    ],
)
def test_no_pose_for_its_own_sake_is_not_put_down_to_the_target(
    tmp_path: Path, program: str, words: str
) -> None:
    file = tmp_path / "mine.pl"
    file.write_text(f"proc(control, {program}).\n")
    done = served("--controller", file, "--out", tmp_path / "run", "--no-report")
    assert done.returncode == 3, done.stderr
    assert words in done.stdout
    assert "--unit" not in done.stdout
