"""Headers of requests and replies, and how they become bytes."""

from typing import Annotated, Any

import msgspec
import numpy as np
from msgspec import Meta

from bridge.arrays import ArrayDescription
from bridge.errors import LightsAndCameraError, ProtocolError
from bridge.messages import PROTOCOL, check_finite

MAX_HEADER_BYTES = 1024 * 1024
"""Largest header of a request or a reply."""
MAX_FRAME_BYTES = 64 * 1024 * 1024
"""Largest frame at all; a connection that sends more is closed."""
MAX_MESSAGE_BYTES = MAX_FRAME_BYTES + MAX_HEADER_BYTES
"""Largest message, all its frames together."""
MAX_FRAMES = 16
"""Most frames of one message; chosen by hand."""

RequestId = Annotated[str, Meta(pattern=r"^[^/\s]{1,64}/[0-9]{1,15}\Z")]


class Request(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Header of a request; ``args`` stay undecoded until the operation is known."""

    v: int
    id: RequestId
    op: str
    args: msgspec.Raw = msgspec.Raw(b"{}")
    arrays: tuple[ArrayDescription, ...] = ()


class _Version(msgspec.Struct):
    """What can be said of a header of another version."""

    v: int = 0
    id: str = ""


class ErrorBody(msgspec.Struct, frozen=True):
    """The three parts of an error reply."""

    code: str
    message: str
    hint: str = ""


class ReplyHeader(msgspec.Struct, frozen=True, omit_defaults=True):
    """Header of a reply, as a client decodes it; keys that it does not know are let be."""

    v: int
    id: str | None
    ok: bool
    result: dict[str, Any] | None = None
    error: ErrorBody | None = None
    arrays: tuple[ArrayDescription, ...] = ()


_REQUEST = msgspec.json.Decoder(Request)
_VERSION = msgspec.json.Decoder(_Version)
_REPLY = msgspec.json.Decoder(ReplyHeader)
_DECODING_FAILED = (msgspec.MsgspecError, ValueError, RecursionError)


def _plain(value: object) -> object:
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    raise TypeError(f"a {type(value).__name__} cannot be sent")


_ENCODER = msgspec.json.Encoder(enc_hook=_plain)


def decode_request(header: bytes) -> Request:
    """Decode a request's header.

    Raises
    ------
    ProtocolError
        ``bad_version`` or ``bad_message``.
    """
    try:
        request = _REQUEST.decode(header)
    except _DECODING_FAILED as error:
        try:
            seen = _VERSION.decode(header)
        except _DECODING_FAILED:
            seen = _Version()
        if seen.v not in (0, PROTOCOL):
            raise _bad_version(seen.v, seen.id or None) from error
        raise ProtocolError(
            "bad_message",
            f"The header cannot be read: {error}.",
            'A request is {"v":1,"id":"<client>/<n>","op":...,"args":{...}}.',
            seen.id or None,
        ) from error
    if request.v != PROTOCOL:
        raise _bad_version(request.v, request.id)
    return request


def _bad_version(version: int, request_id: str | None) -> ProtocolError:
    return ProtocolError(
        "bad_version",
        f"The request speaks protocol version {version}; this server speaks {PROTOCOL}.",
        "Use a client and a server of the same release.",
        request_id,
    )


def encode_request(request_id: str, op: str, args: object, arrays: list[ArrayDescription]) -> bytes:
    """Bytes of a request's header.

    Raises
    ------
    ValueError, TypeError
        For arguments that JSON cannot carry, numbers that are not finite among them.
    """
    header: dict[str, Any] = {"v": PROTOCOL, "id": request_id, "op": op, "args": args}
    if arrays:
        header["arrays"] = arrays
    return _encoded(header)


def encode_reply(request_id: str, result: object, arrays: list[ArrayDescription]) -> bytes:
    """Bytes of a reply's header; raises as `encode_request`."""
    header: dict[str, Any] = {"v": PROTOCOL, "id": request_id, "ok": True, "result": result}
    if arrays:
        header["arrays"] = arrays
    return _encoded(header)


def encode_error(request_id: str | None, error: LightsAndCameraError) -> bytes:
    """Bytes of an error reply's header."""
    body = ErrorBody(error.code, error.message, error.hint)
    return _ENCODER.encode({"v": PROTOCOL, "id": request_id, "ok": False, "error": body})


def decode_reply(header: bytes) -> ReplyHeader:
    """Decode a reply's header.

    Raises
    ------
    ProtocolError
        When it is not a reply of this protocol version.
    """
    try:
        reply = _REPLY.decode(header)
    except _DECODING_FAILED as error:
        raise ProtocolError("bad_reply", f"The server's reply cannot be read: {error}.") from error
    if reply.v != PROTOCOL:
        raise ProtocolError(
            "bad_version", f"The server speaks protocol version {reply.v}; this client speaks {PROTOCOL}."
        )
    return reply


def _encoded(header: dict[str, Any]) -> bytes:
    encoded = _ENCODER.encode(header)
    # msgspec writes NaN and infinities as null, so only then need the numbers be looked at one by one.
    if b"null" in encoded:
        for name, value in msgspec.to_builtins(header, enc_hook=_plain).items():
            check_finite(value, name)
    return encoded
