"""A session's `result.json` as those read it who did not write it: its format is asked for first."""

from pathlib import Path
from typing import Any, TypeVar

import msgspec
from msgspec import Struct

from bridge.errors import BadInput

FORMAT = 1  # its `version`, by session/result.pl
Read = TypeVar("Read")


class _Versioned(Struct, frozen=True):
    version: Any = None


def decoded_result(file: Path, data: bytes, kind: type[Read]) -> Read:
    """What a reader looks for in the bytes of the file.

    Raises
    ------
    BadInput
        It is of another format.
    msgspec.MsgspecError
        It is broken, or a field is of the wrong type.
    """
    version = msgspec.json.decode(data, type=_Versioned).version
    if version not in (None, FORMAT):
        raise BadInput(
            f"{file}: of format {version}, and this version reads format {FORMAT};",
            "use the version that wrote it.",
        )
    return msgspec.json.decode(data, type=kind)
