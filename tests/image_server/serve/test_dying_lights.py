"""Lights that go out on cue."""

import pytest

from bridge.errors import BadInput
from bridge.messages import Settings
from image_server.serve.device import Change
from image_server.serve.dying_lights import DyingLights
from image_server.simulator.scenario import load_scenario
from image_server.simulator.simulator import Simulator

FULL = Settings(lights=(7, 7, 7), shutter_s=1 / 60, aperture=4.0)


def lights(**deaths: int) -> DyingLights:
    return DyingLights(Simulator("cube", load_scenario("eclipse"), 1), deaths)


def test_a_light_shines_until_its_cue_and_is_told_then() -> None:
    device = lights(left=2)
    told: list[Change] = []
    device.listen(told.append)
    device.capture(FULL)
    assert told == []
    last = device.capture(FULL)
    assert [(change.event, change.args["light"]) for change in told] == [("light_fault", "left")]
    assert last.applied.lights == (7, 7, 7)
    dark = device.capture(FULL)
    assert (dark.requested.lights, dark.applied.lights) == ((7, 7, 7), (0, 7, 7))
    assert not dark.verified
    assert dark.pixels.mean() < 0.9 * last.pixels.mean()
    assert device.health()["dead_lights"] == ["left"]


def test_who_does_not_ask_for_a_dead_light_gets_what_was_asked() -> None:
    device = lights(left=0)
    told: list[Change] = []
    device.listen(told.append)
    frame = device.capture(Settings(lights=(0, 7, 7), shutter_s=1 / 60, aperture=4.0))
    assert frame.verified
    assert told == []
    device.capture(FULL)
    assert len(told) == 1


def test_a_session_that_goes_on_finds_it_dead() -> None:
    device = lights(left=2)
    assert [change.args["light"] for change in device.restart(1, 2)] == ["left"]
    assert device.capture(FULL).applied.lights == (0, 7, 7)
    device.come_to(1)
    assert device.capture(FULL).applied.lights == (7, 7, 7)


def test_a_light_that_is_not_there_is_refused() -> None:
    with pytest.raises(BadInput, match=r"no light 'bottom'\. There are left, right, top"):
        lights(bottom=1)
