import math
from fractions import Fraction
from pathlib import Path

import pytest

from bridge.door import Atom, Prolog, PrologGoalError, Term, Variable, quoted
from bridge.errors import BadInput


@pytest.fixture(scope="module")
def prolog() -> Prolog:
    """The Prolog of this process."""
    return Prolog()


@pytest.mark.parametrize(
    ("goal", "value"),
    [
        ('X = "é→𝄞"', "é→𝄞"),
        ("X = 'é→𝄞'", Atom("é→𝄞")),
        ("X is 2**200", 2**200),
        ("X is -(7**77)", -(7**77)),
        ("X = 0.1", 0.1),
        ("X is inf", math.inf),
        ("X is rdiv(1, 3)", Fraction(1, 3)),
        ('X = [a, "b", 1, []]', [Atom("a"), "b", 1, []]),
        ("X = f(g(1), h)", Term("f", (Term("g", (1,)), Atom("h")))),
        ("X = a-b", Term("-", (Atom("a"), Atom("b")))),
        ("X = _{a: 1, b: _{c: x}}", {"a": 1, "b": {"c": Atom("x")}}),
        ("X = 'it''s'", Atom("it's")),
        ("X = 'back\\\\slash'", Atom("back\\slash")),
        ("X = 'null'", Atom("null")),
        ("X = []", []),
    ],
)
def test_values_arrive_as_they_are(prolog: Prolog, goal: str, value: object) -> None:
    answer = prolog.first(goal)
    assert answer is not None
    assert answer["X"] == value
    assert type(answer["X"]) is type(value)


def test_not_a_number_arrives(prolog: Prolog) -> None:
    answer = prolog.first("X is nan")
    assert answer is not None
    assert math.isnan(answer["X"])


def test_all_answers_in_order(prolog: Prolog) -> None:
    assert prolog.ask("member(X, [1, 2, 3]), Y is X * X") == [
        {"X": 1, "Y": 1},
        {"X": 2, "Y": 4},
        {"X": 3, "Y": 9},
    ]


def test_endless_answers_are_cut(prolog: Prolog) -> None:
    assert [answer["X"] for answer in prolog.ask("between(1, inf, X)", most=3)] == [1, 2, 3]


def test_failure_and_success(prolog: Prolog) -> None:
    assert prolog.ask("fail") == []
    assert prolog.first("fail") is None
    assert prolog.holds("true")
    assert not prolog.holds("fail")


def test_open_variables_keep_their_identity(prolog: Prolog) -> None:
    answer = prolog.first("X = f(A, B, A)")
    assert answer is not None
    a, b, again = answer["X"].args
    assert isinstance(a, Variable)
    assert a == again
    assert a != b


def test_an_exception_is_a_python_error(prolog: Prolog) -> None:
    with pytest.raises(PrologGoalError, match="not sufficiently instantiated") as caught:
        prolog.ask("atom_length(_, _)")
    assert caught.value.term.startswith("error(instantiation_error")


def test_a_goal_that_cannot_be_read_is_an_error(prolog: Prolog) -> None:
    with pytest.raises(PrologGoalError, match=r"[Ss]yntax"):
        prolog.ask("foo(")


def test_asking_goes_on_after_an_error(prolog: Prolog) -> None:
    for _ in range(3):
        with pytest.raises(PrologGoalError):
            prolog.ask("throw(oops)")
        assert prolog.holds("true")


def test_a_second_door_leads_to_the_same_prolog(prolog: Prolog) -> None:
    prolog.ask("assertz(seen_by_door(1))")
    assert Prolog().holds("seen_by_door(1)")


def test_modules_can_be_loaded(prolog: Prolog, tmp_path: Path) -> None:
    file = tmp_path / "it's.pl"
    file.write_text(":- module(its, [twice/2]).\ntwice(X, Y) :- Y is 2 * X.\n")
    prolog.use_module(file)
    assert prolog.first("twice(21, X)") == {"X": 42}


def test_a_missing_module_is_bad_input(prolog: Prolog) -> None:
    with pytest.raises(BadInput, match="no Prolog file"):
        prolog.use_module("/nowhere/at.pl")


def test_quoting(prolog: Prolog) -> None:
    nasty = "a'b\\c\nd"
    answer = prolog.first(f"X = {quoted(nasty)}")
    assert answer == {"X": nasty}
