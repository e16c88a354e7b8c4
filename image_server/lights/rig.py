"""The lights of a laboratory: levels out, faults noticed, dark when nobody asks any more."""

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import msgspec

from bridge.errors import DeviceError
from bridge.messages import LightDescription
from image_server.lights.driver import LightDriver, Status
from image_server.lights.lights_file import LightChannels, LightsFile, check_channels
from image_server.lights.port import PortGoneError
from image_server.lights.watchdog import Watchdog

ATTEMPTS = 3
"""Times that a driver is asked before its lights count as dead."""
CHECK_PERIOD_S = 0.5
"""How often a driver is asked whether it lives."""

Notify = Callable[[str, str], None]
"""Told of a light that died: its name, and why."""


@dataclass(frozen=True)
class Lit:
    """What the lights were told.

    Attributes
    ----------
    levels : per light; a dead one counts as 0.
    verified : whether every level was read back from the driver.
    steady_at : monotonic time from which the light is steady.
    """

    levels: tuple[int, ...]
    verified: bool
    steady_at: float


class LightRig:
    """Lights on one driver.

    A thread asks the driver twice a second whether it lives (which also keeps its hold-off time from running
    out), and turns everything off when no request has come for `dark_after_s`. A watchdog process does so
    when this process dies, or is silent for `hold_off_s`.

    Parameters
    ----------
    file : the lights file.
    driver : its driver, opened.
    """

    def __init__(self, file: LightsFile, driver: LightDriver) -> None:
        self.file = file
        self._driver = driver
        self._notify: Notify = lambda _name, _why: None
        self._lock = threading.Lock()
        self._dead: dict[str, str] = {}
        self._levels = (0,) * len(file.lights)
        self._values: list[int] | None = None
        self._verified = self._lit_as_asked = False
        self._steady_at = 0.0
        self._status = Status()
        self._retries = 0
        self._heard = time.monotonic()
        self._closing = threading.Event()
        self._period_s = min(CHECK_PERIOD_S, file.hold_off_s / 4 or CHECK_PERIOD_S)
        try:
            check_channels(file, driver)
            self._watchdog = Watchdog(driver.fileno(), driver.dark, file.hold_off_s)
            self.light(self._levels)
        except BaseException:
            driver.close()
            raise
        self._keeper = threading.Thread(target=self._keep, name="lights", daemon=True)
        self._keeper.start()

    @property
    def lights(self) -> tuple[LightDescription, ...]:
        """What `describe` says of them."""
        return tuple(
            msgspec.convert(light, LightDescription, from_attributes=True) for light in self.file.lights
        )

    @property
    def identity(self) -> str:
        """The driver's."""
        return self._driver.identity

    @property
    def dead(self) -> dict[str, str]:
        """Lights that have died, with the reason."""
        with self._lock:
            return dict(self._dead)

    def listen(self, notify: Notify) -> None:
        """Tell once of every light that dies, from any thread, those that are dead already included."""
        with self._lock:
            self._notify = notify
            dead = dict(self._dead)
        for name, why in dead.items():
            notify(name, why)

    def heard(self) -> None:
        """A request has come: the controller lives."""
        self._heard = time.monotonic()

    def light(self, levels: Sequence[int]) -> Lit:
        """Set every light; a dead one stays off. Never raises for a light that dies."""
        with self._lock:
            self._levels = self._without_dead(levels)
            self._set(self._levels)
            self._lit_as_asked = self._verified and self._levels == tuple(levels)
            return Lit(self._levels, self._lit_as_asked, self._steady_at)

    def present(self) -> Lit:
        """What the lights are doing now: the driver is asked whether it is still well."""
        with self._lock:
            self._ask_status()
            return Lit(self._levels, self._lit_as_asked, self._steady_at)

    def health(self) -> dict[str, Any]:
        """State of the driver and of every light."""
        with self._lock:
            return {
                "device": self.identity,
                "dead_lights": dict(self._dead),
                "temperature_c": self._status.temperature_c,
                "retries": self._retries,
                "levels": list(self._levels),
            }

    def close(self) -> None:
        """Turn everything off and give the driver back; may be called twice."""
        if self._closing.is_set():
            return
        self._closing.set()
        self._keeper.join()
        with self._lock:
            self._set((0,) * len(self.file.lights))
            put_out = self._values is not None and not any(self._values)
            if put_out or self._dead:
                self._watchdog.leave()
            self._driver.close()

    # --- with the lock held ---

    def _set(self, levels: Sequence[int]) -> None:
        self._notice_darkness()
        values = [0] * self._driver.channels
        for light, level in zip(self.file.lights, levels, strict=True):
            for channel in light.channels:
                values[channel - 1] = light.value(level, self._driver.full)
        if values == self._values and self._verified:
            return
        if self._all_dead():
            self._verified = False
            return
        changed = values != self._values
        self._values = None
        read = self._tried(lambda: self._driver.set(values))
        if read is None and self._all_dead():
            self._verified = False
            return
        self._values = values
        self._verified = read is not None and read[: len(values)] == values
        if read is not None and not self._verified:
            self._blame(read, values)
        if changed:
            self._steady_at = time.monotonic() + self.file.settle_s

    def _blame(self, read: Sequence[int], values: Sequence[int]) -> None:
        """The outputs are not what was set: ask the driver why."""
        self._ask_status()
        dead = {
            channel for light in self.file.lights if light.name in self._dead for channel in light.channels
        }
        self._verified = all(
            output == value or (channel in dead and output == 0)
            for channel, (output, value) in enumerate(zip(read, values, strict=True), 1)
        )

    def _tried(self, ask: Callable[[], Any]) -> Any:
        """What the driver answers; after several failures all its lights are dead, and the answer is None."""
        for attempt in range(1, ATTEMPTS + 1):
            self._watchdog.alive()
            try:
                return ask()
            except DeviceError as error:
                if attempt == ATTEMPTS or isinstance(error, PortGoneError):
                    for light in self.file.lights:
                        self._dies(light, error.message)
                    return None
                self._retries += 1
        return None

    def _ask_status(self) -> None:
        """Ask the driver how it is, and learn which of its channels have failed."""
        self._notice_darkness()
        status = None if self._all_dead() else self._tried(self._driver.check)
        if status is None:
            return
        self._status = status
        for light in self.file.lights:
            failed = [channel for channel in light.channels if channel in status.faults]
            if failed:
                self._dies(
                    light,
                    f"Channel {failed[0]} of the lights at {self.file.device}: {status.faults[failed[0]]}.",
                )

    def _notice_darkness(self) -> None:
        """After this process was stopped for a while the lights are not as they were."""
        if self._watchdog.went_dark():
            self._values = None
            self._levels = (0,) * len(self._levels)
            self._verified = self._lit_as_asked = False

    def _all_dead(self) -> bool:
        return len(self._dead) == len(self.file.lights)

    def _without_dead(self, levels: Sequence[int]) -> tuple[int, ...]:
        lights = zip(self.file.lights, levels, strict=True)
        return tuple(0 if light.name in self._dead else level for light, level in lights)

    def _dies(self, light: LightChannels, why: str) -> None:
        if light.name not in self._dead:
            self._dead[light.name] = why
            self._lit_as_asked = False
            self._levels = self._without_dead(self._levels)
            self._notify(light.name, why)

    # --- the thread ---

    def _keep(self) -> None:
        while not self._closing.wait(self._period_s):
            with self._lock:
                quiet = self.file.dark_after_s
                if quiet and any(self._levels) and time.monotonic() - self._heard > quiet:
                    self._levels = (0,) * len(self._levels)
                    self._lit_as_asked = False
                    self._set(self._levels)
                self._ask_status()
