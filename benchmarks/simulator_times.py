"""What a simulated frame costs: the first of a geometry, further settings, the whole sensor, 12 Mpx."""

import time
from collections.abc import Callable
from pathlib import Path

import msgspec
import numpy as np

from benchmarks.lines import Show
from bridge.messages import Describe, Settings
from image_server.simulator.rays import Caster, pixel_rays
from image_server.simulator.scenario import load_scenario
from image_server.simulator.scenario_tables import Scenario, ScenarioCamera
from image_server.simulator.simulator import Simulator

MIDDLE = Settings(lights=(4, 4, 4), shutter_s=1 / 60, aperture=4.0)
LARGE = ScenarioCamera(width=4096, height=3072, fx=5120.0, fy=5120.0, cx=2047.5, cy=1535.5)
FIRST_SEEDS = (1, 2, 3)
SCENARIOS = Path(__file__).parents[1] / "scenarios"
TARGETS = ("cube", "fixture", "satellite")
REPEATS = 9


def milliseconds(run: Callable[[], object], repeats: int = REPEATS) -> tuple[float, float]:
    """Median time of a call: on the clock, and of all processors together."""
    times = []
    for _ in range(repeats):
        began = time.perf_counter(), time.process_time()
        run()
        times.append((time.perf_counter() - began[0], time.process_time() - began[1]))
    clock, processor = 1000.0 * np.median(times, axis=0)
    return float(clock), float(processor)


def cast_ms() -> tuple[float, float]:
    """One ray through each of 640×480 pixels at a wall: the peer of a first frame."""
    camera = Simulator("cube", "nominal", 1).camera
    rays = pixel_rays(camera, np.arange(camera.height), np.arange(camera.width))
    caster = Caster(np.array([[[-9.0, -9.0, 1.0], [9.0, -9.0, 1.0], [0.0, 9.0, 1.0]]]))
    return milliseconds(lambda: caster.first_hits(rays))


def noise_ms() -> tuple[float, float]:
    """640×480 normal draws: the peer of a further frame, which needs them."""
    draws = np.random.Generator(np.random.SFC64(1))
    return milliseconds(lambda: draws.standard_normal((480, 640), np.float32))


def first_ms(
    scenario: Scenario | str, target: str, seeds: tuple[int, ...] = FIRST_SEEDS
) -> tuple[float, float]:
    """Median time of the first frame, tracing included."""
    waiting = [Simulator(target, scenario, seed) for seed in seeds]
    simulators = iter([(simulator, middle_of(simulator.describe())) for simulator in waiting])

    def capture() -> None:
        simulator, settings = next(simulators)
        simulator.capture(settings)

    return milliseconds(capture, len(seeds))


def middle_of(described: Describe) -> Settings:
    """Lights half up, and the middle shutter and aperture."""
    return Settings(
        lights=tuple(light.levels // 2 for light in described.lights),
        shutter_s=described.shutters_s[len(described.shutters_s) // 2],
        aperture=described.apertures[len(described.apertures) // 2],
    )


def further_ms(scenario: Scenario | str, settings: Settings = MIDDLE) -> tuple[float, float]:
    """Median time of a frame of a geometry that has been traced."""
    simulator = Simulator("cube", scenario, 1)
    simulator.capture(settings)
    return milliseconds(lambda: simulator.capture(settings))


def simulator(show: Show) -> None:
    """Print the simulator's lines of `make bench`."""
    Simulator("cube", "nominal", 0).capture(MIDDLE)  # compiles, if need be
    for name, target in (("nominal", "cube"), ("nominal", "fixture"), ("textured", "satellite")):
        first, cast = first_ms(name, target), cast_ms()
        line(show, f"first_frame({name},{target})", first, cast_ms=cast[0], ratio=first[1] / cast[1])
    slowest = max(
        (first_ms(scenario, target, (1,)), f"{scenario},{target}")
        for scenario in sorted(file.stem for file in SCENARIOS.glob("*.toml"))
        for target in TARGETS
    )
    line(show, "first_frame(slowest scenario and target)", slowest[0], which=slowest[1])
    moving = load_scenario("camera")
    moving = msgspec.structs.replace(
        moving, camera=msgspec.structs.replace(moving.camera, motion_px_per_s=(240.0, 160.0))
    )
    wide = Settings(lights=(4, 4, 4), shutter_s=1 / 30, aperture=2.8)
    for name, scenario, settings in (
        ("nominal", load_scenario("nominal"), MIDDLE),
        ("whole sensor and lens", moving, wide),
    ):
        further, noise = further_ms(scenario, settings), noise_ms()
        line(show, f"further_frame({name})", further, noise_ms=noise[0], ratio=further[1] / noise[1])
    line(show, "first_frame(12 megapixels)", first_ms(Scenario(camera=LARGE), "cube", (1,)))


def line(show: Show, name: str, measured: tuple[float, float], **more: float | str) -> None:
    """Print a time; ratios are of processor time, which other work on the machine changes less."""
    show(f"simulator/{name}", measured[0], "ms", processor_ms=measured[1], **more)
