"""What every driver of lights is to the rig: channel values out, and what it says of itself."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Status:
    """What a driver says of itself.

    Attributes
    ----------
    faults : channels (from 1) whose lamp or output has failed, with the reason.
    temperature_c : of the driver, where it has a sensor.
    """

    faults: dict[int, str] = field(default_factory=dict)
    temperature_c: float | None = None


class LightDriver(ABC):
    """One device on a serial line. Channels count from 1; values go from 0 to `full`.

    Attributes
    ----------
    identity : kind, serial number and place.
    channels : how many there are.
    full : value of full output.
    dark : bytes that turn every channel off, for a watchdog to write.
    """

    identity: str
    channels: int
    full: int
    dark: bytes

    @abstractmethod
    def set(self, values: Sequence[int]) -> list[int] | None:
        """Set all channels; the values read back, None where the device cannot be read.

        Raises
        ------
        DeviceError : no answer, or one that makes no sense.
        """

    @abstractmethod
    def check(self) -> Status:
        """Ask whether the device lives, and how it is.

        Raises
        ------
        DeviceError : no answer, or one that makes no sense.
        """

    @abstractmethod
    def fileno(self) -> int:
        """Descriptor of the line, for a watchdog to inherit."""

    @abstractmethod
    def close(self) -> None:
        """Give the line back, as dark or as lit as it is; may be called twice."""
