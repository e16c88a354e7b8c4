"""Command lines from the signatures of functions: their annotations say what each option takes.

A parameter is annotated `Annotated[type, Option(...)]` or `Annotated[type, Argument(...)]`; one whose type is
a dataclass stands for all of its fields, so that commands share groups of options. Types are str, int, float,
Path and enumerations of strings, any of them or None, lists of them (an option that is given several times)
and tuples (so many words). What is refused is said with exit status 2.
"""

from __future__ import annotations

import math
import types
from argparse import Action, ArgumentParser, ArgumentTypeError, Namespace
from collections.abc import Callable
from dataclasses import dataclass, is_dataclass
from enum import StrEnum
from inspect import Parameter, signature
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints


@dataclass(frozen=True, kw_only=True)
class Option:
    """How an option is described and what a number may be; NaN and infinity are refused."""

    help: str = ""
    metavar: str | None = None
    min: float = -math.inf
    max: float = math.inf


@dataclass(frozen=True, kw_only=True)
class Argument(Option):
    """The same of a word that is told by its place."""


def add_options(parser: ArgumentParser, command: Callable[..., Any]) -> None:
    """What a command takes, for a parser."""
    for name, (annotation, default) in _parameters(command).items():
        if _is_group(annotation):
            add_options(parser, annotation)
        else:
            _add(parser, name, annotation, default)


def call(command: Callable[..., Any], given: Namespace) -> Any:
    """Run a command with what was given to the parser."""
    values = {}
    for name, (annotation, _) in _parameters(command).items():
        values[name] = call(annotation, given) if _is_group(annotation) else getattr(given, name)
    return command(**values)


def _is_group(annotation: Any) -> bool:
    return is_dataclass(annotation)


def _parameters(command: Callable[..., Any]) -> dict[str, tuple[Any, Any]]:
    hints = get_type_hints(command, include_extras=True)
    return {
        name: (hints[name], parameter.default) for name, parameter in signature(command).parameters.items()
    }


def _add(parser: ArgumentParser, name: str, annotation: Any, default: Any) -> None:
    base, *described = get_args(annotation) if get_origin(annotation) is Annotated else (annotation,)
    option = described[0] if described else Option()
    if get_origin(base) in (types.UnionType, Union):
        base = next(kind for kind in get_args(base) if kind is not type(None))
    many: dict[str, Any] = {}
    if get_origin(base) is list:
        many, base = {"action": "append"}, get_args(base)[0]
    elif get_origin(base) is tuple:
        many, base = {"nargs": len(get_args(base)), "action": _Tuple}, get_args(base)[0]
    help_text = option.help.replace("%", "%%")
    if default not in (Parameter.empty, None):
        help_text += f" [default: {default}]"
    metavar: Any = option.metavar or name.upper()
    if option.metavar is None and issubclass(base, StrEnum):
        metavar = "|".join(base)
    if "nargs" in many:
        metavar = tuple(metavar.split())
    if isinstance(option, Argument):
        parser.add_argument(name, metavar=metavar, type=_reader(base, option), help=help_text, **many)
        return
    required = default is Parameter.empty
    parser.add_argument(
        f"--{name.replace('_', '-')}", metavar=metavar, type=_reader(base, option), required=required,
        default=None if required else default, help=help_text, **many,
    )  # fmt: skip


class _Tuple(Action):
    """Keep the words of an option as a tuple."""

    def __call__(
        self, parser: ArgumentParser, namespace: Namespace, values: Any, option_string: str | None = None
    ) -> None:
        setattr(namespace, self.dest, tuple(values))


def _reader(kind: Any, option: Option) -> Callable[[str], Any]:
    """What makes a value of a word, or says what is wrong with it."""
    limits = [f"at least {option.min:g}"] * (option.min > -math.inf)
    limits += [f"at most {option.max:g}"] * (option.max < math.inf)
    wanted = {int: "a whole number", float: "a number"}.get(kind, "")
    if issubclass(kind, StrEnum):
        wanted = f"one of {', '.join(kind)}"

    def read(word: str) -> Any:
        try:
            value = kind(word)
        except ValueError:
            raise ArgumentTypeError(f"{word!r} is not {wanted}") from None
        if isinstance(value, int | float) and not (
            math.isfinite(value) and option.min <= value <= option.max
        ):
            raise ArgumentTypeError(f"{word} is not {' and '.join(limits) or 'a finite number'}")
        return value

    return read
