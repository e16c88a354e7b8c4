"""What a server answers, as its type: strict in what it must tell, lenient in what it tells besides."""

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, TypeVar

import msgspec
from msgspec import inspect
from numpy.typing import NDArray

from bridge.arrays import FramePixels, array_sha256, is_frame
from bridge.errors import DeviceError
from bridge.image_messages import ImageCaptureResult

T = TypeVar("T")

_type_info: Callable[[Any], inspect.Type] = cache(inspect.type_info)


def received(result: object, kind: type[T]) -> T:
    """A result as its type; keys that are not known, anywhere in it, are let be.

    Raises
    ------
    msgspec.ValidationError
        Names the key that is lacking, or does not fit.
    """
    return msgspec.convert(_known(result, _type_info(kind)), kind)


def _known(value: Any, kind: inspect.Type) -> Any:
    match kind:
        case inspect.StructType() if isinstance(value, dict):
            types = {field.encode_name: field.type for field in kind.fields}
            return {key: _known(item, types[key]) for key, item in value.items() if key in types}
        case inspect.VarTupleType() if isinstance(value, list):
            return [_known(item, kind.item_type) for item in value]
        case inspect.UnionType():  # of one type and null
            for one in kind.types:
                value = _known(value, one)
    return value


def received_frame(header: ImageCaptureResult, arrays: Sequence[NDArray[Any]], endpoint: str) -> FramePixels:
    """The frame of a `capture`, which must be the one that its header is of.

    Raises
    ------
    DeviceError
        It is none, or another.
    """
    if not is_frame(arrays):
        raise DeviceError(f"The image server at {endpoint} sent no grey frame of 8 or 16 bits.")
    if array_sha256(arrays[0]) != header.sha256:
        raise DeviceError(
            f"The image server at {endpoint} sent a frame whose sha256 is not that of its header.",
            "Is the hash over the bytes of the array that was sent, and of this frame?",
        )
    return arrays[0]
