"""Arrays on the wire: a description in the header, the bytes in a frame of their own."""

import hashlib
from collections.abc import Sequence
from typing import Any

import msgspec
import numpy as np
import zmq
from numpy.typing import NDArray

from bridge.errors import ProtocolError

DTYPES = frozenset({"bool", "uint8", "uint16", "int32", "int64", "float32", "float64"})
"""Element types that may be sent; bytes are little-endian, in C order."""
FramePixels = NDArray[Any]
"""A frame, (H, W) grey, uint8 or uint16."""
MAX_DIMENSIONS = 4  # chosen by hand: images need two


class ArrayDescription(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Element type and shape of one array frame."""

    dtype: str
    shape: tuple[int, ...]


def pack(arrays: Sequence[NDArray[Any]]) -> tuple[list[ArrayDescription], list[NDArray[Any]]]:
    """Describe arrays and make them contiguous, without a copy where they already are.

    Raises
    ------
    TypeError
        For an element type that the protocol does not carry.
    """
    described: list[ArrayDescription] = []
    frames: list[NDArray[Any]] = []
    for array in arrays:
        if array.dtype.name not in DTYPES:
            raise TypeError(f"arrays of {array.dtype} cannot be sent; use one of {', '.join(sorted(DTYPES))}")
        contiguous = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<"))
        described.append(ArrayDescription(array.dtype.name, array.shape))
        frames.append(contiguous)
    return described, frames


def unpack(described: Sequence[ArrayDescription], frames: Sequence[zmq.Frame]) -> list[NDArray[Any]]:
    """Arrays over the memory of the received frames, without a copy.

    Raises
    ------
    ProtocolError
        When frames and descriptions do not fit together.
    """
    if len(described) != len(frames):
        raise ProtocolError(
            "bad_frames", f"The header describes {len(described)} arrays but {len(frames)} array frames came."
        )
    arrays: list[NDArray[Any]] = []
    for index, (description, frame) in enumerate(zip(described, frames, strict=True)):
        shape = description.shape
        if description.dtype not in DTYPES or len(shape) > MAX_DIMENSIONS or any(n < 0 for n in shape):
            raise ProtocolError(
                "bad_frames", f"Array {index} is described as {description.dtype} of shape {shape}."
            )
        dtype = np.dtype(description.dtype).newbyteorder("<")
        wanted = dtype.itemsize
        for n in shape:
            wanted *= n
        if wanted != len(frame):
            raise ProtocolError(
                "bad_frames",
                f"Array {index} should have {wanted} bytes ({description.dtype}, shape {shape}) "
                f"but its frame has {len(frame)}.",
            )
        arrays.append(np.frombuffer(frame.buffer, dtype=dtype).reshape(shape))
    return arrays


def is_frame(arrays: Sequence[NDArray[Any]]) -> bool:
    """Whether these are one grey frame, (H, W) uint8 or uint16."""
    return len(arrays) == 1 and arrays[0].ndim == 2 and arrays[0].dtype in (np.uint8, np.uint16)


def array_sha256(array: NDArray[Any]) -> str:
    """SHA-256 of an array's bytes in C order, as 64 hexadecimal digits."""
    return hashlib.sha256(np.ascontiguousarray(array).data).hexdigest()
