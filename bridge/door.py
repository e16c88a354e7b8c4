"""A door into Prolog for tests and notebooks: load files, ask goals, read answers as Python values.

Built on pyswip, whose pitfalls stay inside: every goal runs to its end, so there are no open queries to nest,
and answers come back as text, so strings are `str` and integers have any size. It is no transport: servers
are reached by `bridge/prolog/client.pl`.
"""

import base64
import json
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

from pyswip import Prolog as _Pyswip

from bridge.errors import BadInput, LightsAndCameraError

__all__ = ["Atom", "Prolog", "PrologGoalError", "Term", "Variable", "quoted"]

DOOR = Path(__file__).with_name("prolog") / "door.pl"


class PrologGoalError(LightsAndCameraError):
    """A goal threw; ``term`` is the error term as text."""

    code = "prolog_error"

    def __init__(self, message: str, term: str) -> None:
        super().__init__(message)
        self.term = term


class Atom(str):
    """A Prolog atom; equal to the `str` of the same text."""

    __slots__ = ()

    def __repr__(self) -> str:
        return f"Atom({str(self)!r})"


@dataclass(frozen=True)
class Term:
    """A compound term, ``name(args...)``."""

    name: str
    args: tuple[Any, ...]


@dataclass(frozen=True)
class Variable:
    """A variable that an answer leaves open; equal where it is the same one within an answer."""

    name: str


class Prolog:
    """The Prolog of this process. There is one, however many doors lead to it; use it from one thread.

    Examples
    --------
    >>> Prolog().first("atom_length(Word, 5), Word = apple")  # doctest: +SKIP
    {'Word': Atom('apple')}
    """

    def __init__(self) -> None:
        self._pyswip = _Pyswip()
        self._run(f"use_module({quoted(DOOR)})")

    def use_module(self, file: Path | str) -> None:
        """Load a module file into `user`.

        Raises
        ------
        BadInput
            When there is no such file.
        PrologGoalError
            When it cannot be loaded.
        """
        path = Path(file).resolve()
        if not path.is_file() and not path.with_suffix(".pl").is_file():
            raise BadInput(f"There is no Prolog file {path}.", "Give the path of a .pl file.")
        self.first(f"use_module({quoted(path)})")

    def ask(self, goal: str, most: int = 1000) -> list[dict[str, Any]]:
        """All answers of a goal, at most ``most``: a dict of variable names each.

        Lists become lists, strings `str`, atoms `Atom`, integers `int`, rationals `Fraction`, dicts `dict`,
        other compound terms `Term`.

        Raises
        ------
        PrologGoalError
            When the goal throws or cannot be read.
        """
        sent = base64.b64encode(goal.encode()).decode("ascii")
        found = self._run(f"bridge_door:door_answers('{sent}', {int(most)}, Answers)")
        reply = json.loads(base64.b64decode(found["Answers"]))
        if "error" in reply:
            raise PrologGoalError(reply["error"], reply["term"])
        return [{name: _value(term) for name, term in answer.items()} for answer in reply["answers"]]

    def first(self, goal: str) -> dict[str, Any] | None:
        """The first answer of a goal, ``None`` when it fails; raises as `ask`."""
        answers = self.ask(goal, most=1)
        return answers[0] if answers else None

    def holds(self, goal: str) -> bool:
        """Whether a goal succeeds; raises as `ask`."""
        return self.first(goal) is not None

    def _run(self, query: str) -> Mapping[str, Any]:
        answers = list(self._pyswip.query(query, maxresult=1))
        if not answers:
            raise PrologGoalError("Prolog could not load its side of the door.", query)
        return dict(answers[0])


def quoted(text: object) -> str:
    """A quoted atom for use in a goal, e.g. for a path."""
    escaped = str(text).replace("\\", "\\\\").replace("'", "\\'").replace("\n", "\\n")
    return f"'{escaped}'"


def _value(json_value: Any) -> Any:
    if isinstance(json_value, list):
        return [_value(item) for item in json_value]
    if not isinstance(json_value, dict):
        return json_value
    match json_value:
        case {"$atom": text}:
            return Atom(text)
        case {"$term": name, "args": args}:
            return Term(name, tuple(_value(arg) for arg in args))
        case {"$variable": name}:
            return Variable(name)
        case {"$rational": [n, d]}:
            return Fraction(n, d)
        case {"$float": text}:
            return float(text.lower().replace("1.5nan", "nan").replace("1.0inf", "inf"))
        case {"$dict": pairs}:
            return {key: _value(item) for key, item in pairs}
        case {"$blob": text}:
            return text
    raise ValueError(f"an answer holds {json_value!r}, which the door does not know")
