"""Descriptors of a USB camera (USB 2.0 chapter 9; UVC 1.0 and its payload formats), as it sends them."""

import struct
from dataclasses import dataclass

from tests.equipment.uvc_model import (
    CAMERA_TERMINAL,
    OUTPUT_TERMINAL,
    PROCESSING_UNIT,
    SELECTORS,
    CameraModel,
)

ENDPOINT = 0x81  # bulk, in
PACKET_BYTES = 512
PAYLOAD_BYTES = 32 * PACKET_BYTES
"""Largest payload, header included: as much as uvcvideo asks for at a time."""
GUID_TAIL = bytes.fromhex("000010008000 00aa00389b71")
UNCOMPRESSED = {"YUYV": b"YUY2", "GREY": b"Y800", "Y16": b"Y16 "}
BITS = {"YUYV": 16, "GREY": 8, "Y16": 16, "MJPG": 16}
CS_INTERFACE = 0x24
VIDEO, CONTROL, STREAMING, COLLECTION = 0x0E, 1, 2, 3


@dataclass(frozen=True)
class Format:
    """A pixel format with its one size and its frame intervals, in units of 100 ns, the default first."""

    name: str
    width: int
    height: int
    intervals: tuple[int, ...]

    @property
    def frame_bytes(self) -> int:
        """Largest frame."""
        return self.width * self.height * BITS[self.name] // 8


def device_descriptor(model: CameraModel) -> bytes:
    """Of a device with functions, whose strings 1 and 2 name maker and product."""
    return struct.pack(
        "<BBHBBBBHHHBBBB", 18, 1, 0x0200, 0xEF, 2, 1, 64, model.vendor, model.product, 0x0100, 1, 2, 3, 1
    )


def string_descriptor(text: str) -> bytes:
    """A string."""
    encoded = text.encode("utf-16-le")
    return struct.pack("<BB", 2 + len(encoded), 3) + encoded


LANGUAGES = struct.pack("<BBH", 4, 3, 0x0409)


def configuration_descriptor(model: CameraModel, formats: tuple[Format, ...]) -> bytes:
    """The configuration with all its interfaces."""
    association = struct.pack("<BBBBBBBB", 8, 11, 0, 2, VIDEO, COLLECTION, 0, 2)
    body = association + _control_interface(model) + _streaming_interface(formats)
    return struct.pack("<BBHBBBBB", 9, 2, 9 + len(body), 2, 1, 0, 0x80, 250) + body


def _control_interface(model: CameraModel) -> bytes:
    masks = {
        unit: sum(1 << SELECTORS[name].bit for name in model.controls if SELECTORS[name].unit == unit)
        for unit in (CAMERA_TERMINAL, PROCESSING_UNIT)
    }
    units = (
        _class_specific("<BBHBBHHHB", 2, CAMERA_TERMINAL, 0x0201, 0, 0, 0, 0, 0, 3,
                        tail=masks[CAMERA_TERMINAL].to_bytes(3, "little"))
        + _class_specific("<BBBHB", 5, PROCESSING_UNIT, CAMERA_TERMINAL, 0, 2,
                          tail=masks[PROCESSING_UNIT].to_bytes(2, "little") + b"\0")
        + _class_specific("<BBHBBB", 3, OUTPUT_TERMINAL, 0x0101, 0, PROCESSING_UNIT, 0)
    )  # fmt: skip
    header_size = 13
    header = _class_specific("<BHHIBB", 1, 0x0100, header_size + len(units), 48_000_000, 1, 1)
    assert len(header) == header_size
    return _interface(0, 0, CONTROL) + header + units


def _streaming_interface(formats: tuple[Format, ...]) -> bytes:
    described = b"".join(_format(number, one) for number, one in enumerate(formats, 1))
    header_size = 13 + len(formats)
    total = header_size + len(described)
    header = _class_specific(
        "<BBHBBBBBBB", 1, len(formats), total, ENDPOINT, 0, OUTPUT_TERMINAL, 0, 0, 0, 1,
        tail=bytes(len(formats)),
    )  # fmt: skip
    endpoint = struct.pack("<BBBBHB", 7, 5, ENDPOINT, 2, PACKET_BYTES, 0)
    return _interface(1, 1, STREAMING) + header + described + endpoint


def _format(number: int, one: Format) -> bytes:
    if one.name in UNCOMPRESSED:
        kind = 4
        head = _class_specific(
            "<BBB16sBBBBBB",
            kind,
            number,
            1,
            UNCOMPRESSED[one.name] + GUID_TAIL,
            BITS[one.name],
            1,
            0,
            0,
            0,
            0,
        )
    else:
        kind = 6
        head = _class_specific("<BBBBBBBBB", kind, number, 1, 1, 1, 0, 0, 0, 0)
    count = len(one.intervals)
    rates = [8 * one.frame_bytes * 10**7 // interval for interval in one.intervals]
    frame = _class_specific(
        "<BBBHHIIIIB", kind + 1, 1, 0, one.width, one.height, min(rates), max(rates), one.frame_bytes,
        one.intervals[0], count, tail=struct.pack(f"<{count}I", *sorted(one.intervals)),
    )  # fmt: skip
    return head + frame + _class_specific("<BBBB", 13, 1, 1, 4)  # sRGB, BT.601


def _interface(number: int, endpoints: int, subclass: int) -> bytes:
    return struct.pack("<BBBBBBBBB", 9, 4, number, 0, endpoints, VIDEO, subclass, 0, 0)


def _class_specific(layout: str, *values: int | bytes, tail: bytes = b"") -> bytes:
    body = struct.pack(layout, *values) + tail
    return struct.pack("<BB", 2 + len(body), CS_INTERFACE) + body
