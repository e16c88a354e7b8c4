"""USB/IP (Documentation/usb/usbip_protocol.rst of the kernel): a USB device that a process of ours plays.

The kernel's virtual host controller vhci-hcd gets one end of a socket and sends what its drivers ask of the
device (URBs); answers go back with the numbers they came under. Numbers are big-endian.
"""

import os
import select
import socket
import struct
import threading
import time
from abc import ABC, abstractmethod
from collections import OrderedDict
from contextlib import suppress
from pathlib import Path

from bridge.errors import BadInput, DeviceError

CONTROLLER = Path("/sys/devices/platform/vhci_hcd.0")
HIGH_SPEED = 3
DEVICE_NUMBER = 0x00010002  # bus 1, device 2: vhci-hcd only repeats it
CMD_SUBMIT, CMD_UNLINK, RET_SUBMIT, RET_UNLINK = 1, 2, 3, 4
HEADER = struct.Struct(">IIIIIIiiii8s")
STALLED, UNLINKED = -32, -104  # -EPIPE, -ECONNRESET
NO_DEVICE_S = 10.0
TICK_S = 0.5


class Stall(Exception):  # noqa: N818  # USB's own word
    """The device refuses a request."""


class UsbDevice(ABC):
    """What a device does with what the host asks."""

    @abstractmethod
    def control(self, setup: bytes, data: bytes) -> bytes:
        """Answer a request on endpoint 0: `setup` (8 bytes) and what the host sent; raises `Stall`."""

    @abstractmethod
    def bulk_in(self, now: float) -> bytes | None:
        """Next transfer of the bulk endpoint at a time (time.monotonic()); None while there is none."""

    @abstractmethod
    def next_s(self) -> float:
        """When there may be a transfer (time.monotonic())."""


class Connection:
    """A device on the virtual host controller, served by a thread until it is unplugged.

    Raises
    ------
    BadInput : no such controller, or no permission.
    DeviceError : no port is free.
    """

    def __init__(self, device: UsbDevice) -> None:
        self._device = device
        self._waiting: OrderedDict[int, int] = OrderedDict()
        self._ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_STREAM)
        with theirs:
            self.port = _attach(theirs.fileno())
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="usb device", daemon=True)
        self._thread.start()

    @property
    def present(self) -> bool:
        """Whether the device is still plugged in."""
        return self._thread.is_alive()

    def unplug(self) -> None:
        """Vanish from the bus; may be called twice."""
        self._stop.set()
        with suppress(OSError):
            self._ours.shutdown(socket.SHUT_RDWR)
        if threading.current_thread() is not self._thread:
            self._thread.join()
        self._ours.close()

    def _run(self) -> None:
        with suppress(ConnectionError, OSError):
            while not self._stop.is_set():
                until = self._device.next_s() if self._waiting else time.monotonic() + TICK_S
                wait = min(max(0.0, until - time.monotonic()), TICK_S)
                ready, _, _ = select.select([self._ours], [], [], wait)
                if ready:
                    self._one()
                self._stream()

    def _one(self) -> None:
        command, number, _, inwards, endpoint, flags, length, _, _, _, setup = HEADER.unpack(
            self._received(HEADER.size)
        )
        if command == CMD_UNLINK:
            known = self._waiting.pop(flags, None)  # there the number of the transfer to forget stands
            self._answer(RET_UNLINK, number, UNLINKED if known is not None else 0)
            return
        data = b"" if inwards else self._received(length)
        if endpoint:
            self._waiting[number] = length
            return
        try:
            answer = self._device.control(setup, data)
        except Stall:
            self._answer(RET_SUBMIT, number, STALLED)
        else:
            answer = answer[:length] if inwards else b""
            self._answer(RET_SUBMIT, number, 0, len(answer) if inwards else length, answer)

    def _stream(self) -> None:
        while self._waiting:
            data = self._device.bulk_in(time.monotonic())
            if data is None:
                return
            number, length = self._waiting.popitem(last=False)
            data = data[:length]
            self._answer(RET_SUBMIT, number, 0, len(data), data)

    def _answer(self, command: int, number: int, status: int, length: int = 0, data: bytes = b"") -> None:
        header = HEADER.pack(command, number, 0, 0, 0, status & 0xFFFFFFFF, length, 0, 0, 0, bytes(8))
        self._ours.sendall(header + data)

    def _received(self, size: int) -> bytes:
        data = bytearray()
        while len(data) < size:
            more = self._ours.recv(size - len(data))
            if not more:
                raise ConnectionError
            data += more
        return bytes(data)


def _attach(descriptor: int) -> int:
    try:
        lines = (CONTROLLER / "status").read_text().splitlines()[1:]
    except FileNotFoundError:
        raise BadInput(
            "This machine has no virtual USB controller.", "Load it: modprobe vhci-hcd (Debian has it)."
        ) from None
    # hub port state ...: state 4 is free
    free = [int(line.split()[1]) for line in lines if line.split()[0] == "hs" and int(line.split()[2]) == 4]
    if not free:
        raise DeviceError("The virtual USB controller has no free port.", "Stop another emulated camera.")
    try:
        (CONTROLLER / "attach").write_text(f"{free[0]} {descriptor} {DEVICE_NUMBER} {HIGH_SPEED}")
    except PermissionError:
        raise BadInput("Plugging in a virtual USB device needs root.", "Use sudo.") from None
    return free[0]


def video_node(connection: Connection, serial: str) -> str:
    """Device node of the camera with a serial number, once its driver has made it.

    Raises
    ------
    DeviceError : no driver takes it.
    """
    deadline = time.monotonic() + NO_DEVICE_S
    while time.monotonic() < deadline and connection.present:
        for file in CONTROLLER.glob("usb*/*/serial"):
            if file.read_text().strip() == serial:
                nodes = sorted(file.parent.glob("*/video4linux/video*"))
                for node in nodes:
                    if (node / "index").read_text().strip() == "0" and os.path.exists(f"/dev/{node.name}"):
                        return f"/dev/{node.name}"
        time.sleep(0.05)
    raise DeviceError(
        "The kernel made no camera of the emulated one.", "Load its driver: modprobe uvcvideo; see dmesg."
    )
