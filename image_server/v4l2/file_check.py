"""What a camera file says against what the camera has; and what is set where the file says nothing."""

from collections.abc import Mapping

import msgspec

from bridge.errors import BadInput
from image_server.v4l2.camera_file import Axis, CameraFile
from image_server.v4l2.controls import EXPOSURE_MANUAL, EXPOSURE_UNIT_S, Control
from image_server.v4l2.node import Node
from stack.exposure import SHUTTERS_S

SAME_STEP = 0.05  # a shutter that the control can only approach by more than this is left out
MANUAL = {
    "exposure_auto": EXPOSURE_MANUAL,
    "exposure_auto_priority": 0,  # else a dark scene halves the frame rate
    "autogain": 0,
    "auto_white_balance": 0,
    "focus_auto": 0,
    "backlight_compensation": 0,
}
"""Controls, and the value with which nothing moves by itself."""
AMPLIFIERS = ("gain", "analogue_gain")


def check_card(file: CameraFile, node: Node) -> None:
    """Refuse another camera than the one that the file was made for."""
    if file.card is not None and file.card != node.card:
        raise BadInput(
            f"The camera {file.device} is {node.card!r}, but its file was made for {file.card!r}.",
            "Connect that camera, or calibrate this one: python -m image_server calibrate",
        )


def named_control(known: Mapping[str, Control], name: str, node: Node) -> Control:
    """A control by its name.

    Raises
    ------
    BadInput : the camera has none; the message lists those it has.
    """
    if name not in known:
        raise BadInput(
            f"The camera {node.path} ({node.card}) has no control {name}.",
            f"It has {', '.join(known) or 'none'}.",
        )
    return known[name]


def check_controls(file: CameraFile, known: Mapping[str, Control], node: Node) -> None:
    """Refuse a control that is not there or cannot be set, and a value that it does not offer."""
    wanted = list(file.controls.items())
    for axis in file.axes().values():
        assert axis.control is not None
        wanted += [(axis.control, value) for _, value in axis.steps]
    for name, value in wanted:
        control = named_control(known, name, node)
        if not control.settable:
            raise BadInput(
                f"{node.path}: the control {name} cannot be set.", "Leave it out of the camera file."
            )
        control.check(value, node.path)


def completed(file: CameraFile, known: Mapping[str, Control]) -> CameraFile:
    """The file; one that says nothing of controls gets automatic modes off, least gain and usual shutters."""
    if file.controls or file.axes():
        return file
    fixed = {
        name: value
        for name, value in MANUAL.items()
        if name in known and not known[name].read_only and _offers(known[name], value)
    }
    fixed |= {name: known[name].minimum for name in AMPLIFIERS if name in known and not known[name].read_only}
    return msgspec.structs.replace(file, controls=fixed, shutter=_shutters(known.get("exposure_absolute")))


def _shutters(control: Control | None) -> Axis[float] | None:
    if control is None or control.read_only:
        return None
    steps = {}
    for seconds in SHUTTERS_S:
        step = max(1, control.step)
        value = control.minimum + step * round((seconds / EXPOSURE_UNIT_S - control.minimum) / step)
        held = value * EXPOSURE_UNIT_S
        if control.minimum <= value <= control.maximum and abs(held / seconds - 1) < SAME_STEP:
            steps[value] = round(held, 9)
    if not steps:
        return None
    return Axis(control=control.name, steps=tuple((seconds, value) for value, seconds in steps.items()))


def _offers(control: Control, value: int) -> bool:
    return value in control.menu if control.menu else control.minimum <= value <= control.maximum
