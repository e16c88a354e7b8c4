"""`python -m bridge results`: the types of all results as Prolog terms, for `bridge/prolog/results.pl`."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Mapping
from typing import Any

from msgspec import Struct, inspect

from bridge.image_messages import IMAGE_OPERATIONS
from bridge.messages import Operation
from bridge.vision_messages import VISION_OPERATIONS

HEAD = """\
:- module(bridge_results,
          [ result/3,                   % ?Server, ?Op, ?Type
            message/2                   % ?Name, ?Fields
          ]).

/** <module> The types of the servers' results

Written by `python -m bridge results` from what bridge/image_messages.py and bridge/vision_messages.py state.
What the types mean is said by check_type/3 of bridge/prolog/types.pl.
*/
"""


def add_options(parser: ArgumentParser) -> None:
    """It has none."""


def run(options: Namespace) -> None:
    """Print the Prolog file."""
    print(prolog_results(), end="")


def prolog_results() -> str:
    """Text of `bridge/prolog/results.pl`."""
    servers = {"image_server": IMAGE_OPERATIONS, "vision_server": VISION_OPERATIONS}
    messages: dict[str, str] = {}
    results = [
        f"result({server}, {op}, {_term(inspect.type_info(operation.result), messages)})."
        for server, operations in servers.items()
        for op, operation in _sorted(operations)
    ]
    return "\n".join([HEAD, *results, "", *(messages[name] for name in sorted(messages)), ""])


def _sorted(operations: Mapping[str, Operation]) -> list[tuple[str, Operation]]:
    return sorted(operations.items())


def _term(kind: Any, messages: dict[str, str]) -> str:
    """A type as a Prolog term; the structs that it names are added to the messages."""
    match kind:
        case inspect.StructType():
            return f"message({_message(kind.cls, kind, messages)})"
        case inspect.UnionType():
            (one,) = (one for one in kind.types if not isinstance(one, inspect.NoneType))
            return f"nullable({_term(one, messages)})"
        case inspect.VarTupleType():
            most = "inf" if kind.max_length is None else kind.max_length
            return f"list({_term(kind.item_type, messages)}, {kind.min_length or 0}, {most})"
        case inspect.TupleType():
            return f"tuple([{', '.join(_term(one, messages) for one in kind.item_types)}])"
        case inspect.DictType():
            return f"map({_term(kind.value_type, messages)})"
        case inspect.LiteralType():
            return f"one_of([{', '.join(_quoted(value) for value in kind.values)}])"
        case inspect.IntType() | inspect.FloatType():
            name = "integer" if isinstance(kind, inspect.IntType) else "number"
            bounds = [f"{sign}({getattr(kind, sign)})" for sign in ("ge", "gt", "le", "lt")
                      if getattr(kind, sign) is not None]  # fmt: skip
            return f"{name}([{', '.join(bounds)}])"
        case inspect.StrType():
            return "string"
        case inspect.BoolType():
            return "boolean"
        case inspect.AnyType():
            return "any"
    raise TypeError(f"no Prolog term for {kind}")


def _message(cls: type[Struct], kind: inspect.StructType, messages: dict[str, str]) -> str:
    """The name of a struct; what has a default need not be there, since servers of others may not know it."""
    name = _quoted(cls.__name__, "'")
    if cls.__name__ not in messages:
        messages[cls.__name__] = ""  # a type may hold itself
        terms = [(field, _term(field.type, messages)) for field in kind.fields]
        fields = [
            f"{field.encode_name}-{term if field.required else f'optional({term})'}" for field, term in terms
        ]
        body = ",\n          ".join(fields)
        messages[cls.__name__] = f"message({name},\n        [ {body}\n        ])."
    return name


def _quoted(text: object, mark: str = '"') -> str:
    return f"{mark}{text}{mark}"
