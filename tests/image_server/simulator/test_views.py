"""What was traced comes again where the scene does, and only there."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from bridge.messages import Settings
from image_server.simulator import simulator
from image_server.simulator.scenario import load_scenario
from image_server.simulator.scenario_tables import Scenario, ScenarioCamera
from image_server.simulator.simulator import Simulator

MIDDLE = Settings(lights=(4, 4, 4), shutter_s=1 / 60, aperture=4.0)
SMALL = ScenarioCamera(width=160, height=120, fx=200.0, fy=200.0, cx=79.5, cy=59.5)


@pytest.mark.parametrize("scenario", ["nominal", "drifting", "turning-sun"])
def test_frames_come_again_after_a_restart_without_being_traced_again(
    scenario: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def frames(sim: Simulator) -> list[bytes]:
        return [sim.capture(MIDDLE).pixels.tobytes() for _ in range(3)]

    whole = msgspec.structs.replace(load_scenario(scenario), camera=SMALL)
    fresh = {seed: frames(Simulator("cube", whole, seed)) for seed in (4, 5)}
    assert not set(fresh[4]) & set(fresh[5])
    sim = Simulator("cube", whole, 4)
    assert frames(sim) == fresh[4]
    sim.restart(5, 0)
    assert frames(sim) == fresh[5]
    monkeypatch.setattr(simulator, "rendered", lambda *_: pytest.fail("it is traced again"))
    for seed in (4, 5):
        sim.restart(seed, 0)
        assert frames(sim) == fresh[seed]
    sim.restart(4, 2)
    assert sim.capture(MIDDLE).pixels.tobytes() == fresh[4][2]


def test_another_seed_pose_sun_or_lens_is_another_view() -> None:
    zoom = msgspec.structs.replace(SMALL, focal_lengths_mm=(8.0, 12.0))
    sim = Simulator("cube", Scenario(camera=zoom, background=load_scenario("textured").background), 1)
    pose, sun = sim.true_pose, sim._sun
    views = [sim._view()]
    sim._focal_mm = 12.0
    views.append(sim._view())
    sim._focal_mm, sim._sun = 8.0, -sun
    views.append(sim._view())
    for other in (replace(pose, translation=1.1 * pose.translation),
                  replace(pose, rotation_vector=pose.rotation_vector + 0.1)):  # fmt: skip
        sim.true_pose, sim._sun = other, sun
        views.append(sim._view())
    sim.restart(2, 0)
    sim.true_pose, sim._sun = pose, sun
    views.append(sim._view())  # with other clutter
    assert len({np.stack(view.images).tobytes() for view in views}) == len(views)


def test_views_that_take_much_memory_are_not_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    sim = Simulator("cube", Scenario(camera=SMALL), 0)
    sim.radiance((4, 4, 4))
    size = next(iter(sim._traced.values())).size_bytes
    for kept in (simulator.FEWEST_KEPT, simulator.FEWEST_KEPT + 2):
        monkeypatch.setattr(simulator, "KEPT_BYTES", kept * size)
        for seed in range(kept + 2):
            sim.restart(seed, 0)
            sim.radiance((4, 4, 4))
        assert len(sim._traced) == kept
    monkeypatch.setattr(simulator, "KEPT_BYTES", 0)
    sim.restart(99, 0)
    sim.radiance((4, 4, 4))
    assert len(sim._traced) == simulator.FEWEST_KEPT
