"""The kernel's V4L2 interface: v4l2-python3, corrected where its structures are not the kernel's.

v4l2-python3 0.3.5 ends `v4l2_pix_format` after 32 of 48 bytes, and lacks `device_caps` and the controls
newer than Linux 2.6.30. Sizes, offsets and request numbers
used here are checked against <linux/videodev2.h> by the tests.
"""

import ctypes

import v4l2

BUFFER_CAPTURE = int(v4l2.V4L2_BUF_TYPE_VIDEO_CAPTURE)
MEMORY_MMAP = int(v4l2.V4L2_MEMORY_MMAP)

BUFFER_ERROR = 0x0040  # V4L2_BUF_FLAG_ERROR: the data may be damaged
BUFFER_CLOCK_MASK = 0xE000  # V4L2_BUF_FLAG_TIMESTAMP_MASK
BUFFER_CLOCK_MONOTONIC = 0x2000  # V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC
BUFFER_STAMPED_AT_START = 0x10000  # V4L2_BUF_FLAG_TSTAMP_SRC_SOE

FULL_RANGE = 1  # V4L2_QUANTIZATION_FULL_RANGE
COLORSPACE_JPEG = 7  # full range unless said otherwise


class PixFormat(ctypes.Structure):
    """`struct v4l2_pix_format`, all 48 bytes."""

    _fields_ = [
        (name, ctypes.c_uint32)
        for name in (
            "width",
            "height",
            "pixelformat",
            "field",
            "bytesperline",
            "sizeimage",
            "colorspace",
            "priv",
            "flags",
            "ycbcr_enc",
            "quantization",
            "xfer_func",
        )
    ]


class _FormatUnion(ctypes.Union):
    _fields_ = [("pix", PixFormat), ("raw", ctypes.c_uint64 * 25)]


class Format(ctypes.Structure):
    """`struct v4l2_format`."""

    _fields_ = [("type", ctypes.c_uint32), ("fmt", _FormatUnion)]


_ARGUMENTS: dict[str, type] = {
    "QUERYCAP": v4l2.v4l2_capability,
    "ENUM_FMT": v4l2.v4l2_fmtdesc,
    "G_FMT": Format,
    "S_FMT": Format,
    "REQBUFS": v4l2.v4l2_requestbuffers,
    "QUERYBUF": v4l2.v4l2_buffer,
    "QBUF": v4l2.v4l2_buffer,
    "DQBUF": v4l2.v4l2_buffer,
    "STREAMON": ctypes.c_int,
    "STREAMOFF": ctypes.c_int,
    "G_PARM": v4l2.v4l2_streamparm,
    "S_PARM": v4l2.v4l2_streamparm,
    "QUERY_EXT_CTRL": v4l2.v4l2_query_ext_ctrl,
    "QUERYMENU": v4l2.v4l2_querymenu,
    "G_CTRL": v4l2.v4l2_control,
    "S_CTRL": v4l2.v4l2_control,
}

REQUESTS = {
    # v4l2-python3 gives the numbers signed
    name: (getattr(v4l2, f"VIDIOC_{name}") & 0xFFFFFFFF, argument)
    for name, argument in _ARGUMENTS.items()
}
"""Number and argument of every request that is made, by its name without VIDIOC_."""


def fourcc(name: str) -> int:
    """The number of a pixel format, e.g. of "GREY"."""
    return int.from_bytes(name.encode("ascii").ljust(4), "little")


def fourcc_name(number: int) -> str:
    """The name of a pixel format."""
    return number.to_bytes(4, "little").decode("ascii", "replace").strip()
