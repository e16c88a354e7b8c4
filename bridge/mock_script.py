"""Scripts of mock servers in JSON, for clients in other processes (docs/protocol.md)."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import msgspec
from msgspec import Meta

from bridge.envelope import ErrorBody
from bridge.errors import BadInput, ServerError
from bridge.mock_server import MockServer


class ScriptedError(ErrorBody, frozen=True, forbid_unknown_fields=True):
    """An answer that is an error reply."""


class Orders(msgspec.Struct, forbid_unknown_fields=True):
    """What a script says of one operation; its words are methods of `MockServer`."""

    answers: tuple[dict[str, Any], ...] = ()
    amend: dict[str, Any] = {}
    delay_s: Annotated[float, Meta(ge=0)] = 0.0
    drop: Annotated[int, Meta(ge=0)] = 0
    garble: Annotated[int, Meta(ge=0)] = 0
    die: bool = False


def apply_script(mock: MockServer, script: Mapping[str, Any]) -> None:
    """Script a mock: by operation, what `Orders` has.

    An answer with the single key ``error`` becomes an error reply (code, message, hint).

    Raises
    ------
    BadInput
        There is no such operation, order or field of a result, or a value is none of its kind.
    """
    for op, told in script.items():
        try:
            orders = msgspec.convert(told, Orders)
            answers = [_answer(answer) for answer in orders.answers]
        except msgspec.ValidationError as error:
            known = ", ".join(Orders.__struct_fields__)
            raise BadInput(f"The script of {op!r}: {error}.", f"There are {known}.") from None
        mock.answer(op, *answers)
        mock.amend(op, **orders.amend)
        mock.delay(op, orders.delay_s)
        mock.drop(op, orders.drop)
        mock.garble(op, orders.garble)
        if orders.die:
            mock.die(op)


def _answer(value: dict[str, Any]) -> dict[str, Any] | Exception:
    if value.keys() != {"error"} or value["error"] is None:
        return value
    error = msgspec.convert(value["error"], ScriptedError)
    return ServerError(error.code, error.message, error.hint)


def read_script(file: Path) -> dict[str, Any]:
    """The script in a JSON file, by operation.

    Raises
    ------
    BadInput
        It cannot be read, or is no JSON object.
    """
    try:
        return msgspec.json.decode(file.read_bytes(), type=dict[str, Any])
    except OSError as error:
        raise BadInput(f"Cannot read the script {file}: {error.strerror}.") from None
    except msgspec.DecodeError as error:
        raise BadInput(f"The script {file} is no JSON object: {error}.") from None
