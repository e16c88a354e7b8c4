"""Lights of a simulated or replayed device that go out on cue, to see what a strategy makes of it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import msgspec

from bridge.errors import BadInput
from bridge.image_messages import MoveDone, PoseErrorMessage
from bridge.messages import Describe, PoseMessage, Settings
from image_server.serve.device import Change, Device, Frame, checked_settings


class DyingLights(Device):
    """A device some of whose lights die after so many captures: they are told, and stay off.

    Parameters
    ----------
    device : whose frames are shown.
    deaths : by name of the light, the number of frames that it still shines in.
    captures_taken : frames that were taken before.

    Raises
    ------
    BadInput
        There is no such light, or it cannot be off.
    """

    def __init__(self, device: Device, deaths: Mapping[str, int], captures_taken: int = 0) -> None:
        self.name = device.name
        self._device = device
        self._deaths = deaths
        self._taken = captures_taken
        self._notify: Callable[[Change], None] = lambda change: None
        self._describe = device.describe()
        lights = {light.name: light.levels for light in self._describe.lights}
        for name in deaths:
            if name not in lights:
                raise BadInput(
                    f"--light-dies: there is no light {name!r}.", f"There are {', '.join(lights)}."
                )
            if lights[name] < 2:
                raise BadInput(f"--light-dies: the light {name!r} has one level and cannot be off.")

    def listen(self, notify: Callable[[Change], None]) -> None:
        """Tell of lights that die, and of what the device notices."""
        self._notify = notify
        self._device.listen(notify)

    def describe(self) -> Describe:
        """What the device offers; that a light is dead is told, not described."""
        return self._describe

    def capture(self, settings: Settings) -> Frame:
        """Take one frame without the light of those that are dead."""
        asked = checked_settings(self._describe, settings)
        levels = tuple(
            0 if light.name in self._dead() else level
            for light, level in zip(self._describe.lights, asked.lights, strict=True)
        )
        frame = self._device.capture(msgspec.structs.replace(asked, lights=levels))
        self._taken += 1
        for light, level in zip(self._describe.lights, asked.lights, strict=True):
            if light.name in self._dead() and (level or self._deaths[light.name] == self._taken):
                self._notify(_fault(light.name))
        return replace(frame, requested=settings, verified=frame.verified and levels == asked.lights)

    def health(self) -> dict[str, Any]:
        """State of the device, and which lights are dead."""
        return {**self._device.health(), "dead_lights": sorted(self._dead())}

    def restart(self, seed: int, captures_taken: int, moves: Sequence[MoveDone] = ()) -> list[Change]:
        """As the device; what died with the last capture is told once more."""
        changes = self._device.restart(seed, captures_taken, moves)
        self._taken = captures_taken
        return changes + [_fault(name) for name, after in self._deaths.items() if 0 < after == captures_taken]

    def come_to(self, number: int) -> None:
        """Be as before the capture of this number."""
        self._device.come_to(number)
        self._taken = number - 1

    def move(self, range_m: float) -> list[Change]:
        """As the device."""
        return self._device.move(range_m)

    def score(self, pose: PoseMessage, moves: int | None = None) -> PoseErrorMessage | None:
        """As the device."""
        return self._device.score(pose, moves)

    def close(self) -> None:
        """As the device."""
        self._device.close()

    def _dead(self) -> set[str]:
        return {name for name, after in self._deaths.items() if after <= self._taken}


def _fault(name: str) -> Change:
    return Change("light_fault", {"light": name, "reason": "it was to die now (--light-dies)"})
