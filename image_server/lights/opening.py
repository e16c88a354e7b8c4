"""Opening lights: those of a lights file, or a serial device that is asked what it speaks."""

from pathlib import Path

import msgspec

from bridge.errors import DeviceBusy, DeviceError
from image_server.lights.dmx_usb_pro import DmxUsbPro
from image_server.lights.driver import LightDriver
from image_server.lights.lights_file import LightChannels, LightsFile, is_device, load_lights_file
from image_server.lights.line_protocol import LineDriver
from image_server.lights.port import PortGoneError
from image_server.lights.rig import LightRig


def open_rig(given: str, dark_after_s: float | None = None) -> LightRig:
    """The lights of a lights file, or of a serial device that is asked what it speaks.

    Raises
    ------
    BadInput : a file or device that cannot be used.
    DeviceError : a device that does not answer.
    """
    if is_device(given) or not Path(given).exists():
        file, driver = _found(given)
    else:
        file = load_lights_file(Path(given))
        driver = (
            DmxUsbPro(file.device)
            if file.protocol == "dmx_usb_pro"
            else LineDriver(file.device, file.hold_off_s)
        )
    if dark_after_s is not None:
        file = msgspec.structs.replace(file, dark_after_s=dark_after_s)
    return LightRig(file, driver)


def _found(device: str) -> tuple[LightsFile, LightDriver]:
    """A device with no file: one light a channel in the line protocol, the paper's testbed on DMX."""
    try:
        widget = DmxUsbPro(device)
    except DeviceError as error:
        if isinstance(error, PortGoneError | DeviceBusy):
            raise
    else:
        lights = tuple(
            LightChannels(name=name, channels=(i,)) for i, name in enumerate(("left", "right", "top"), 1)
        )
        return LightsFile(device=device, protocol="dmx_usb_pro", lights=lights), widget
    driver = LineDriver(device)
    lights = tuple(LightChannels(name=f"light{i}", channels=(i,)) for i in range(1, driver.channels + 1))
    return LightsFile(device=device, protocol="line", lights=lights), driver
