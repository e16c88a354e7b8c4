"""One open V4L2 device node: requests to its driver, and what each refusal means in plain words."""

import errno
import fcntl
import mmap
import os
import select
import stat
import time
from pathlib import Path
from typing import Any

import v4l2

from bridge.errors import BadInput, DeviceBusy, DeviceError
from image_server.v4l2.kernel import REQUESTS

CAPTURE = int(v4l2.V4L2_CAP_VIDEO_CAPTURE)
STREAMING = int(v4l2.V4L2_CAP_STREAMING)
DEVICE_CAPS = int(v4l2.V4L2_CAP_DEVICE_CAPS)
GONE = (errno.ENODEV, errno.ENXIO, errno.EPIPE, errno.ESHUTDOWN)
UNPLUGGED_HINT = "Was it unplugged? Connect it and start again."


class Node:
    """A capture node, open for this process alone to stream from.

    Parameters
    ----------
    path : device node, e.g. /dev/video0.

    Raises
    ------
    BadInput : no such node, no permission, or not a V4L2 camera that streams.
    DeviceError : the node is there but cannot be opened.
    """

    def __init__(self, path: str) -> None:
        self.path = path
        self._fd = _open(path)
        try:
            self.capability = self._checked_capability()
        except BaseException:
            self.close()
            raise

    @property
    def card(self) -> str:
        """The camera's own name."""
        return _text(self.capability.card)

    @property
    def driver(self) -> str:
        """Name of the kernel driver."""
        return _text(self.capability.driver)

    @property
    def bus(self) -> str:
        """Where it is connected, e.g. usb-0000:00:14.0-3."""
        return _text(self.capability.bus_info)

    def request(self, name: str, argument: Any) -> Any:
        """Make one request; the argument, which the driver has filled in.

        Raises
        ------
        OSError : the driver's refusal, for the caller to put into words.
        """
        fcntl.ioctl(self._fd, REQUESTS[name][0], argument)
        return argument

    def map(self, offset: int, length: int) -> mmap.mmap:
        """Map a buffer of the driver into memory."""
        return mmap.mmap(self._fd, length, mmap.MAP_SHARED, mmap.PROT_READ | mmap.PROT_WRITE, offset=offset)

    def wait(self, deadline: float) -> bool:
        """Wait for a frame until this time (time.monotonic()); False if none came."""
        poll = select.poll()
        poll.register(self._fd, select.POLLIN | select.POLLPRI)
        return bool(poll.poll(max(0.0, 1000.0 * (deadline - time.monotonic()))))

    def close(self) -> None:
        """Give the device back; may be called twice."""
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1

    def failure(self, doing: str, error: OSError) -> DeviceError:
        """What a refused request means."""
        if error.errno in GONE:
            return DeviceError(f"The camera {self.path} is gone ({doing}).", UNPLUGGED_HINT)
        if error.errno == errno.EBUSY:
            return DeviceBusy(
                f"The camera {self.path} is busy ({doing}).",
                f"Another program uses it; find it with: fuser {self.path}",
            )
        return DeviceError(f"The camera {self.path} failed in {doing}: {error.strerror or error}.")

    def _checked_capability(self) -> Any:
        argument = REQUESTS["QUERYCAP"][1]()
        try:
            capability = self.request("QUERYCAP", argument)
        except OSError as error:
            if error.errno in (errno.ENOTTY, errno.EINVAL):
                raise BadInput(
                    f"{self.path} is not a V4L2 device.", "List cameras: python -m image_server cameras"
                ) from None
            raise self.failure("asking what it is", error) from error
        offered = capability.capabilities
        if offered & DEVICE_CAPS:
            offered = capability.reserved[0]  # device_caps, since Linux 3.4
        if not offered & CAPTURE or not offered & STREAMING:
            raise BadInput(
                f"{self.path} ({_text(capability.card)}) is not a camera that streams frames.",
                "A camera may have several nodes; list them: python -m image_server cameras",
            )
        return capability


def _open(path: str) -> int:
    try:
        if not stat.S_ISCHR(os.stat(path).st_mode):
            raise BadInput(f"{path} is not a device.", "A camera is a node such as /dev/video0.")
        return os.open(path, os.O_RDWR | os.O_NONBLOCK | os.O_CLOEXEC)
    except FileNotFoundError:
        found = ", ".join(sorted(map(str, Path("/dev").glob("video*")))) or "none"
        raise BadInput(
            f"There is no camera {path}.", f"Is it connected? Nodes on this machine: {found}."
        ) from None
    except PermissionError:
        raise BadInput(
            f"No permission to use the camera {path}.",
            "Join the group of the node (usermod -aG video USER), then log in again.",
        ) from None
    except OSError as error:
        if error.errno in GONE:
            raise DeviceError(f"The camera {path} is gone.", UNPLUGGED_HINT) from None
        if error.errno == errno.EBUSY:
            raise DeviceBusy(
                f"The camera {path} is busy.", f"Another program uses it: fuser {path}"
            ) from None
        raise DeviceError(f"Cannot open the camera {path}: {error.strerror}.") from error


def _text(field: bytes) -> str:
    return field.decode("utf-8", "replace")
