"""Strategies that cannot be run are refused in words, with their place."""

import json
from pathlib import Path

import pytest

from tests.session.command import refused
from tests.session.serving import served


def test_controller_with_a_syntax_error(tmp_path: Path) -> None:
    file = tmp_path / "mine.pl"
    file.write_text("proc(control,\n  [choose_random take_image]).\n")
    message = refused("--controller", file, "--out", tmp_path / "run", by=served)
    assert "mine.pl:2" in message


def test_controller_with_an_unknown_action(tmp_path: Path) -> None:
    file = tmp_path / "mine.pl"
    file.write_text("proc(control, [choose_random, take_picture]).\n")
    message = refused("--controller", file, "--out", tmp_path / "run", by=served)
    assert "take_picture" in message
    assert "mine.pl:1" in message


def test_controller_without_control(tmp_path: Path) -> None:
    file = tmp_path / "mine.pl"
    file.write_text("proc(other, []).\n")
    message = refused("--controller", file, "--out", tmp_path / "run", by=served)
    assert "control" in message
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("body", "words"),
    [
        (
            "[choose_random,\n if(working(lft), take_image, [])]",
            [":2: ", "no light lft", "Did you mean left?"],
        ),
        ("[choose(settings([7, 7], 1/60, 4))]", [":1: ", "2 light levels", "3 lights: left, right, top"]),
        ("[choose(settings([7, 9, 7], 1/60, 4))]", [":1: ", "light right has no level 9", "0 to 7"]),
        ("[choose(settings([7, 7, 7], 1/50, 4))]", [":1: ", "shutter of 1/50 s", "1/60 s"]),
        ("[choose(settings([7, 7, 7], 1/60, 8))]", [":1: ", "aperture of 8", "2.8"]),
    ],
)
def test_what_the_device_does_not_have_is_said_before_anything_is_done(
    tmp_path: Path, body: str, words: list[str]
) -> None:
    file = tmp_path / "mine.pl"
    file.write_text(f"proc(control, {body}).\n")
    message = refused("--controller", file, "--dry-run", by=served)
    for word in words:
        assert word in message
    assert "mine.pl" in message


def test_what_only_a_running_strategy_knows_is_no_light_and_no_level(tmp_path: Path) -> None:
    programs = [
        "if(some(l, [left, right], neg(working(l))), [], [])",
        "if(all(light, [left, right], working(light)), [], [])",
        "if(some([l], and(member(l, [left]), working(l))), [], [])",
        "pi(l, [left, right], ?(working(l)))",
        "pi((r(l), [left, right]), ?(working(l)))",
        "for(l, [left, right], ?(working(l)))",
        "prioritized_interrupts([interrupt(l, and(member(l, [left]), neg(working(l))), choose_random)])",
        "if(working(weakest), [], [])",
        "for(k, [0, 7], choose(settings([k, 7, 7], 1/60, 4)))",
        "pi((a, [2.8, 4]), choose(settings([7, 7, 7], 1/60, a)))",
        "choose(settings([weakest_level, 7, 7], 1/60, 4))",
    ]
    procedures = "".join(f"proc(p{number}, {program}).\n" for number, program in enumerate(programs))
    names = ("weakest", "weakest_level")
    fluents = "".join(f"fun_fluent({name}).\ninitially({name}, 0).\n" for name in names)
    file = tmp_path / "mine.pl"
    file.write_text(f"{procedures}{fluents}proc(control, []).\n")
    done = served("--controller", file, "--dry-run")
    assert done.returncode == 0, done.stderr
    file.write_text("proc(control,\n [pi(l, [left], ?(working(l))), ?(working(m))]).\n")
    message = refused("--controller", file, "--dry-run", by=served)
    assert "mine.pl:2: working(m): there is no light m" in message


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("[\n choose(s)]", "2: choose(s): s is no fluent, and nothing around it binds it"),
        ("\n pi(s, choose(s))", "2: choose(s): pi binds it, and nothing before gives it a value"),
        ("pi(s, [?(well_exposed(t)),\n choose(s)])", "2: choose(s): pi binds it, and nothing before"),
        ("pi(S,\n choose(S))", "2: choose(_): pi binds it, and nothing before"),
    ],
)
def test_settings_that_have_no_value_are_said_before_anything_is_done(
    tmp_path: Path, body: str, words: str
) -> None:
    file = tmp_path / "mine.pl"
    file.write_text(f"proc(control, {body}).\n")
    assert f"{file}:{words}" in refused("--controller", file, "--dry-run", by=served)


def test_settings_that_something_gives_a_value_are_none_of_these(tmp_path: Path) -> None:
    file = tmp_path / "mine.pl"
    file.write_text(
        "fun_fluent(mine). initially(mine, settings([7, 7, 7], 1/60, 4.0)). proc(one(S), choose(S)).\n"
        "proc(control, [choose(mine), pi(s, [?(well_exposed(s)), choose(s)]), pi((s, [mine]), choose(s)),\n"
        "  for(k, [mine], choose(k)), pi(s, [?(s = mine), one(s)])]).\n"
    )
    assert served("--controller", file, "--dry-run").returncode == 0


def test_a_parameter_that_the_vision_server_does_not_have_is_said_before_anything_is_done(
    tmp_path: Path,
) -> None:
    file = tmp_path / "mine.pl"
    file.write_text("proc(control, [choose_random,\n set_parameter(macher, genetic), take_image]).\n")
    message = refused("--controller", file, "--dry-run", by=served)
    assert f"{file}:2: there is no vision parameter macher; there are coarse, " in message
    assert "Did you mean matcher?" in message
    file.write_text("proc(control, pi((name, [matcher, fusion]), set_parameter(name, 7))).\n")
    assert served("--controller", file, "--dry-run").returncode == 0


@pytest.mark.parametrize(
    "operators",
    [
        ":- use_module(library(clpfd)).\nbetter(X) :- X #> 2.\n",
        ":- op(700, xfx, ===>).\nleft ===> right.\n",
    ],
)
def test_a_strategy_may_have_operators_of_its_own_and_of_libraries(tmp_path: Path, operators: str) -> None:
    file = tmp_path / "mine.pl"
    file.write_text(f"{operators}proc(control, [choose_random, take_image]).\n")
    done = served("--controller", file, "--dry-run")
    assert done.returncode == 0, done.stderr
    file.write_text(f"{operators}proc(control, choose(settings([7, 9, 7], 1/60, 4))).\n")
    assert "mine.pl:3: light right has no level 9" in refused("--controller", file, "--dry-run", by=served)


def test_a_predicate_with_the_name_of_a_helper_is_said(tmp_path: Path) -> None:
    file = tmp_path / "mine.pl"
    file.write_text("proc(control, [choose_random, take_image]).\nmerit(_, 1).\n")
    said = served("--controller", file, "--dry-run").stderr
    assert "mine.pl:2" in said
    assert "merit/2 is a helper of the theory, whose procedures call this one now" in said


def test_what_a_strategy_includes_is_its_own(tmp_path: Path) -> None:
    (tmp_path / "theirs.pl").write_text("proc(control, [first]).\nproc(first, choose_random).\n")
    file = tmp_path / "mine.pl"
    file.write_text(":- include('theirs.pl').\nproc(more, []).\n")
    assert served("--controller", file, "--dry-run").returncode == 0
    (tmp_path / "theirs.pl").write_text("proc(control,\n if(working(lft), take_image, [])).\n")
    message = refused("--controller", file, "--dry-run", by=served)
    assert "theirs.pl:2: working(lft): there is no light lft" in message
    (tmp_path / "theirs.pl").write_text("proc(control, []).\n:- include('mine.pl').\n")
    message = refused("--controller", file, "--dry-run", by=served)
    assert f"theirs.pl:2: it includes {file}, which is included by it" in message


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("[take_image, measure, keep_image]", ["without settings", "choose_random"]),
        ("[choose_random,\n keep_image]", [":2: ", "no image to keep", "take_image"]),
        ("[choose_random, take_image,\n\n keep_image]", [":3: ", "before it is measured"]),
        ("[choose_random, take_image, take_image]", ["i1 is neither kept nor discarded"]),
        ("pi(s, [if(false, ?(s = 1), []),\n choose(s)])", [":2: ", "choose is given no settings"]),
        ("[if(true, [],\n []), pi((s, [7]), choose(s))]", [":2: ", "choose(7): that is no settings"]),
    ],
)
def test_what_is_not_possible_is_said_with_its_place(tmp_path: Path, body: str, words: list[str]) -> None:
    file = tmp_path / "mine.pl"
    file.write_text(f"proc(control, {body}).\n")
    message = refused("--controller", file, "--out", tmp_path / "run", "--no-report", "--quiet", by=served)
    for word in words:
        assert word in message
    assert "mine.pl" in message


@pytest.mark.slow
@pytest.mark.parametrize(
    ("program", "words"),
    [
        (
            "proc(control, while(true, ?(true))).",
            ["mine.pl:1: ", "100,000 steps without an action", "while(true,?(true))"],
        ),
        ("proc(control, while(true, choose_random)).", ["1000 actions and took no image"]),
        (
            "proc(control, loop(0)).\nproc(loop(N), [?(N >= 0), loop(M)]) :- integer(N), M is N + 1.",
            ["mine.pl:2: ", "100,000 steps without an action", "loop("],
        ),
    ],
)
def test_a_strategy_that_never_ends_is_told_so_in_one_line(
    tmp_path: Path, program: str, words: list[str]
) -> None:
    file = tmp_path / "mine.pl"
    file.write_text(program)
    message = refused("--controller", file, "--out", tmp_path / "run", "--no-report", "--quiet", by=served)
    (line,) = [line for line in message.splitlines() if "ERROR" in line]
    assert all(word in line for word in ["mine", "never end?", *words])
    assert json.loads((tmp_path / "run" / "result.json").read_text())["status"] == "stopped"
