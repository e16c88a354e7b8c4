"""The operations of a server: requests checked, handed to their handlers, and answered, whatever happens."""

from __future__ import annotations

import logging
import os
import traceback
from collections.abc import Mapping
from contextlib import nullcontext
from typing import Any

import msgspec
import zmq

from bridge.arrays import pack, unpack
from bridge.envelope import MAX_HEADER_BYTES, Request, decode_request, encode_error, encode_reply
from bridge.errors import LightsAndCameraError, ProtocolError
from bridge.lanes import Turns
from bridge.service import ARRAYS, CALLER, Handler, Reply, Service

log = logging.getLogger("bridge.serve")


class Operations:
    """What a service does, by name; its own operations and those that the loop adds."""

    def __init__(self, service: Service, operations: Mapping[str, tuple[Any, Handler]]) -> None:
        self._service = service
        self._one_at_a_time = Turns() if service.exclusive else nullcontext()
        self._operations: dict[str, tuple[msgspec.json.Decoder[Any], Any, Handler]] = {
            op: (msgspec.json.Decoder(args), args, handler) for op, (args, handler) in operations.items()
        }

    @property
    def names(self) -> list[str]:
        """Names of all operations."""
        return list(self._operations)

    def checked(self, body: list[zmq.Frame]) -> Request:
        """The request that a message is.

        Raises
        ------
        ProtocolError
            It is none.
        """
        if not body:
            raise ProtocolError("bad_message", "The request is empty.")
        if len(body[0]) > MAX_HEADER_BYTES:
            raise ProtocolError(
                "too_large",
                f"The request's header has {len(body[0])} bytes; at most {MAX_HEADER_BYTES} are taken.",
            )
        request = decode_request(body[0].bytes)
        if len(body) > 1 and request.op not in self._service.with_arrays:
            raise ProtocolError(
                "bad_frames",
                f"The request has {len(body) - 1} array frames; {request.op!r} takes none.",
                request_id=request.id,
            )
        return request

    def answer(self, request: Request, body: list[zmq.Frame]) -> list[Any]:
        """Frames of the reply to a request, an error reply where its handler fails."""
        try:
            CALLER.set(request.id.rpartition("/")[0])
            ARRAYS.set(unpack(request.arrays, body[1:]))
            reply = self._handle(request)
            described, arrays = pack(reply.arrays)
            header = encode_reply(request.id, reply.result, described)
            if len(header) > MAX_HEADER_BYTES:
                raise ValueError(f"the result has {len(header)} bytes, more than {MAX_HEADER_BYTES}")
            return [header, *arrays]
        except LightsAndCameraError as error:
            return [encode_error(request.id, error)]
        except Exception as error:
            log.exception("%s: %s failed", self._service.name, request.op)
            where = traceback.extract_tb(error.__traceback__)[-1]
            internal = ProtocolError(
                "internal",
                f"The {self._service.name} failed in {request.op!r}: {type(error).__name__}: {error} "
                f"({os.path.basename(where.filename)}, line {where.lineno}).",
                "This is a defect of the server; its log has the details.",
            )
            return [encode_error(request.id, internal)]

    def _handle(self, request: Request) -> Reply:
        try:
            decoder, args_type, handler = self._operations[request.op]
        except KeyError:
            raise ProtocolError(
                "unknown_operation",
                f"The {self._service.name} has no operation {request.op!r}.",
                f"It has {', '.join(sorted(self._operations))}.",
            ) from None
        try:
            args = decoder.decode(request.args)
        except (msgspec.MsgspecError, ValueError, RecursionError) as error:
            from bridge.remedy import remedy  # late: few clients need it

            raise ProtocolError(
                "bad_arguments",
                f"Operation {request.op!r} of the {self._service.name} cannot take these arguments: {error}.",
                remedy(str(error), args_type) or _fields_of(args_type),
            ) from None
        alone = request.op in self._service.operations and request.op not in self._service.prompt
        with self._one_at_a_time if alone else nullcontext():
            return handler(args)


def _fields_of(args_type: Any) -> str:
    fields = getattr(args_type, "__struct_fields__", None)
    if fields is None:
        return ""
    return f"Its arguments are {', '.join(fields)}." if fields else "It takes no arguments."
