"""Controls of a camera: what there is, with range, step and menu; setting one and reading it back."""

import errno
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Protocol

import v4l2

from bridge.errors import BadInput, DeviceError
from image_server.v4l2.kernel import REQUESTS

USER = int(v4l2.V4L2_CID_BASE)
CAMERA = int(v4l2.V4L2_CID_CAMERA_CLASS_BASE)
IMAGE_SOURCE = 0x009E0900  # V4L2_CID_IMAGE_SOURCE_CLASS_BASE

EXPOSURE_UNIT_S = 1e-4
"""Step of `exposure_absolute`: the kernel defines it as 100 µs."""
EXPOSURE_MANUAL = 1
"""Value of `exposure_auto` with which neither shutter nor iris moves by itself."""

NAMES = {
    USER + 0: "brightness",
    USER + 1: "contrast",
    USER + 12: "auto_white_balance",
    USER + 16: "gamma",
    USER + 17: "exposure",
    USER + 18: "autogain",
    USER + 19: "gain",
    USER + 26: "white_balance_temperature",
    USER + 28: "backlight_compensation",
    CAMERA + 1: "exposure_auto",
    CAMERA + 2: "exposure_absolute",
    CAMERA + 3: "exposure_auto_priority",
    CAMERA + 10: "focus_absolute",
    CAMERA + 12: "focus_auto",
    CAMERA + 13: "zoom_absolute",
    CAMERA + 17: "iris_absolute",
    CAMERA + 18: "iris_relative",
    IMAGE_SOURCE + 3: "analogue_gain",
}
"""Names that hold whatever a driver calls these controls; others are named as the driver does."""

UNITS = {"exposure_absolute": "100 µs", "white_balance_temperature": "K"}

KINDS = {1: "integer", 2: "boolean", 3: "menu", 4: "button", 5: "integer64", 7: "string", 8: "bitmask"}
INTEGER_MENU = 9  # as the kinds above, of enum v4l2_ctrl_type
READ_ONLY = int(v4l2.V4L2_CTRL_FLAG_READ_ONLY)
INACTIVE = int(v4l2.V4L2_CTRL_FLAG_INACTIVE)
DISABLED = int(v4l2.V4L2_CTRL_FLAG_DISABLED)
NEXT = int(v4l2.V4L2_CTRL_FLAG_NEXT_CTRL)
SETTABLE = ("integer", "boolean", "menu", "integer_menu", "bitmask")


class Requests(Protocol):
    """What makes requests: a node, or recorded traffic."""

    path: str

    def request(self, name: str, argument: Any) -> Any: ...

    def failure(self, doing: str, error: OSError) -> DeviceError: ...


@dataclass(frozen=True)
class Control:
    """One control.

    Attributes
    ----------
    number : the kernel's id.
    name : as in `NAMES`, or the driver's name in lower case with underscores.
    kind : integer, boolean, menu, integer_menu, button, integer64, string or bitmask.
    minimum, maximum, step, default : in the control's own unit.
    unit : where the kernel defines one, else empty.
    read_only, inactive : cannot be set at all, or not while an automatic mode is on.
    menu : text or number of each entry that the driver offers, by value.
    """

    number: int
    name: str
    kind: str
    minimum: int
    maximum: int
    step: int
    default: int
    unit: str = ""
    read_only: bool = False
    inactive: bool = False
    menu: dict[int, str] = field(default_factory=dict)

    def check(self, value: int, device: str) -> None:
        """Refuse a value that this control does not offer.

        Raises
        ------
        BadInput : names the device, the control and what it allows.
        """
        if self.menu:
            allowed = ", ".join(f"{number} ({text})" for number, text in self.menu.items())
            fits = value in self.menu
        else:
            allowed = f"{self.minimum} to {self.maximum} in steps of {self.step}"
            fits = self.minimum <= value <= self.maximum
            fits = fits and (value - self.minimum) % max(1, self.step) == 0
        if not fits:
            unit = f" ({self.unit})" if self.unit else ""
            raise BadInput(f"{device}: {self.name} = {value} is out of range.", f"Allowed: {allowed}{unit}.")

    @property
    def settable(self) -> bool:
        """Whether it can be set at all, to a number."""
        return self.kind in SETTABLE and not self.read_only

    def in_words(self) -> str:
        """The control on one line."""
        unit = f" {self.unit}" if self.unit else ""
        text = (
            f"{self.name} ({self.kind}) {self.minimum}..{self.maximum} step {self.step}"
            f" default {self.default}{unit}"
        )
        if self.menu:
            text += ": " + ", ".join(f"{number} = {entry}" for number, entry in self.menu.items())
        flags = [word for word, on in (("read-only", self.read_only), ("inactive", self.inactive)) if on]
        return f"{text} [{', '.join(flags)}]" if flags else text


def controls(node: Requests) -> dict[str, Control]:
    """Every control of a camera that holds one value, by name."""
    found = {}
    for query in _queries(node):
        if query.flags & DISABLED or query.elems > 1:
            continue
        kind = "integer_menu" if query.type == INTEGER_MENU else KINDS.get(query.type)
        if kind is None:
            continue  # classes of controls, and compound ones
        name = NAMES.get(query.id) or plain_name(query.name)
        found[name] = Control(
            number=query.id,
            name=name,
            kind=kind,
            minimum=query.minimum,
            maximum=query.maximum,
            step=query.step,
            default=query.default_value,
            unit=UNITS.get(name, ""),
            read_only=bool(query.flags & READ_ONLY),
            inactive=bool(query.flags & INACTIVE),
            menu=_menu(node, query, kind) if kind in ("menu", "integer_menu") else {},
        )
    return found


def read_control(node: Requests, control: Control) -> int:
    """Present value of a control."""
    argument = REQUESTS["G_CTRL"][1](control.number, 0)
    try:
        return int(node.request("G_CTRL", argument).value)
    except OSError as error:
        raise node.failure(f"reading {control.name}", error) from error


def write_control(node: Requests, control: Control, value: int) -> int:
    """Set a control, and read it back: the value that the camera now has.

    Raises
    ------
    BadInput : the value is out of range.
    DeviceError : the control refuses.
    """
    control.check(value, node.path)
    argument = REQUESTS["S_CTRL"][1](control.number, value)
    try:
        node.request("S_CTRL", argument)
    except OSError as error:
        raise _refusal(node, control, value, error) from error
    return read_control(node, control)


def plain_name(name: bytes) -> str:
    """A driver's name of a control as one word: "White Balance, Automatic" is white_balance_automatic."""
    return re.sub(r"[^a-z0-9]+", "_", name.decode("utf-8", "replace").lower()).strip("_")


def _queries(node: Requests) -> Iterator[Any]:
    number = NEXT
    while True:
        query = REQUESTS["QUERY_EXT_CTRL"][1](id=number)
        try:
            node.request("QUERY_EXT_CTRL", query)
        except OSError as error:
            if error.errno in (errno.EINVAL, errno.ENOTTY):
                return  # no more, or none at all
            raise node.failure("listing its controls", error) from error
        yield query
        number = query.id | NEXT


def _menu(node: Requests, query: Any, kind: str) -> dict[int, str]:
    entries = {}
    for index in range(query.minimum, query.maximum + 1):
        argument = REQUESTS["QUERYMENU"][1](id=query.id, index=index)
        try:
            node.request("QUERYMENU", argument)
        except OSError as error:
            if error.errno == errno.EINVAL:
                continue  # menus may have holes
            raise node.failure(f"listing the menu of {query.name.decode()}", error) from error
        raw = bytes(argument)[8:40]
        if kind == "integer_menu":
            entries[index] = str(int.from_bytes(raw[:8], "little", signed=True))
        else:
            entries[index] = raw.split(b"\0")[0].decode("utf-8", "replace")
    return entries


def _refusal(node: Requests, control: Control, value: int, error: OSError) -> DeviceError:
    what = f"The camera {node.path} refuses {control.name} = {value}"
    if error.errno in (errno.EACCES, errno.EPERM, errno.EROFS):
        return DeviceError(
            f"{what}: it cannot be set now.",
            "An automatic mode may be on; turn it off in the camera file's [controls].",
        )
    if error.errno == errno.EILSEQ:  # uvcvideo's word for "wrong state"
        return DeviceError(
            f"{what}: not in the state it is in.",
            "Another control may have to be set first; else unplug the camera and connect it again.",
        )
    if error.errno == errno.EREMOTE:  # uvcvideo's word for "not enough power"
        return DeviceError(f"{what}: it has not enough power.", "Connect it to another USB port.")
    if error.errno == errno.EBUSY:
        return DeviceError(f"{what}: another program holds it.", f"Find it with: fuser {node.path}")
    if error.errno in (errno.ERANGE, errno.EINVAL):
        return DeviceError(f"{what}.", "Calibrate again: python -m image_server calibrate")
    return node.failure(f"setting {control.name} = {value}", error)
