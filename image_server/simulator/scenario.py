"""Scenarios: small TOML files of light, camera and background, and what becomes of them for a target."""

from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import msgspec

from bridge.errors import BadInput
from geometry.model import size_meant
from image_server.simulator.scenario_tables import Light, Scenario, ScenarioCamera
from stack.format import check_light_names
from stack.tables import as_table, check_direction, read_toml

SCENARIOS = Path(__file__).resolve().parent.parent.parent / "scenarios"
# Chosen by hand: the project's targets and the drawn ones are 0.15 to 0.76 m across, and lamps and ranges are
# laid out for these.
USUAL_M = (0.15, 0.8)
RANGE_M = (0.5, 1.0)
LENGTHS = {"pose": {"range_m"}, "camera": {"focuses_m", "pixel_um"}, "background": {"distance_m"}}


def load_scenario(name_or_file: str) -> Scenario:
    """Read a scenario of `scenarios/`, or a TOML file.

    Raises
    ------
    BadInput : unknown name (the message lists the known ones), or a key or value that cannot be used.
    """
    file = _find(name_or_file)
    told = read_toml(file, "scenario")
    if _states_lengths(told):
        told = {"in_proportion": False} | told
    scenario = as_table(told, Scenario, file)
    scenario = msgspec.structs.replace(scenario, camera=_of_frame(scenario.camera, told.get("camera", {})))
    pairs = {
        "[sun] angle_deg": scenario.sun.angle_deg,
        "[sun] azimuth_deg": scenario.sun.azimuth_deg,
        "[pose] range_m": scenario.pose.range_m or RANGE_M,
        "[pose] tilt_deg": scenario.pose.tilt_deg,
        "[move] sun_factor": scenario.move.sun_factor,
    }
    for key, (low, high) in pairs.items():
        if low > high:
            raise BadInput(
                f"{file}: {key} runs from {low:g} down to {high:g}.", "Write the smaller number first."
            )
    if scenario.camera.bayer or scenario.camera.bits != ScenarioCamera().bits:
        raise BadInput(
            f"{file}: [camera] bits and bayer are of recorded frames.",
            "Leave them out: the simulator's frames are grey and have 8 bits.",
        )
    for light in scenario.lights:
        _check_beam(light, file)
    directions = {"[sun] direction": scenario.sun.direction}
    if scenario.earth is not None:
        directions["[earth] direction"] = scenario.earth.direction
    directions |= {f"[[lights]] {light.name!r} aim": light.aim for light in scenario.lights}
    for key, vector in directions.items():
        if vector is not None:
            check_direction(vector, key, file, "Give a vector in the camera frame.")
    check_light_names([light.name for light in scenario.lights], file)
    return scenario


def with_conditions(
    scenario: Scenario,
    ambient_scale: float | None = None,
    light_power: float | None = None,
    defocus_sigma_px: float | None = None,
    motion_px_per_s: tuple[float, float] | None = None,
) -> Scenario:
    """The same scenario under another sun, other lamps or another blur; None keeps what it says.

    `light_power` multiplies the scenario's own.
    """
    return msgspec.structs.replace(
        scenario,
        camera=scenario.camera.blurred_by(defocus_sigma_px, motion_px_per_s),
        ambient_scale=scenario.ambient_scale if ambient_scale is None else ambient_scale,
        light_power=scenario.light_power * (1.0 if light_power is None else light_power),
    )


def of_size(scenario: Scenario, diameter_m: float) -> Scenario:
    """The scenario for a target of this size, with a range.

    For one that is much larger or smaller than USUAL_M, a range that is not told is as much larger or
    smaller, and where the scenario is `in_proportion` all is: the range, where lamps and wall are, and what
    is focused on. So the target is lit and seen as a usual one is. One of which `size_meant` says that its
    unit is wrong stands where others do.
    """
    if scenario.pose.range_m is not None and not scenario.in_proportion:
        return scenario
    meant = diameter_m if size_meant(diameter_m) else USUAL_M[0]
    scale = meant / min(max(meant, USUAL_M[0]), USUAL_M[1])
    near, far = scenario.pose.range_m or RANGE_M
    pose = msgspec.structs.replace(scenario.pose, range_m=(scale * near, scale * far))
    if scale == 1.0 or not scenario.in_proportion:
        return msgspec.structs.replace(scenario, pose=pose)
    camera, behind = scenario.camera, scenario.background
    focuses = None if camera.focuses_m is None else tuple(scale * one for one in camera.focuses_m)
    return msgspec.structs.replace(
        scenario,
        pose=pose,
        camera=msgspec.structs.replace(camera, focuses_m=focuses, pixel_um=scale * camera.pixel_um),
        background=msgspec.structs.replace(behind, distance_m=scale * behind.distance_m),
        lights=tuple(
            msgspec.structs.replace(
                light,
                position=tuple(scale * place for place in light.position),
                power=scale**2 * light.power,
            )
            for light in scenario.lights
        ),
    )


def _of_frame(camera: ScenarioCamera, told: Mapping[str, Any]) -> ScenarioCamera:
    """The camera with what is not told by its frame: the usual field of view, square pixels, the middle."""
    wide = ScenarioCamera().fx * camera.width / ScenarioCamera().width
    fx = camera.fx if "fx" in told else camera.fy if "fy" in told else wide
    untold = {"fx": fx, "fy": fx, "cx": (camera.width - 1) / 2, "cy": (camera.height - 1) / 2}
    return msgspec.structs.replace(camera, **{key: untold[key] for key in untold.keys() - told.keys()})


def _states_lengths(told: Mapping[str, Any]) -> bool:
    """Whether a scenario's file says itself where target, lamps or wall are, or what is focused on."""
    return "lights" in told or any(
        isinstance(table := told.get(name), Mapping) and not keys.isdisjoint(table)
        for name, keys in LENGTHS.items()
    )


def _find(name_or_file: str) -> Path:
    file = Path(name_or_file)
    if file.suffix == ".toml":
        return file
    named = SCENARIOS / f"{name_or_file}.toml"
    if file.name == name_or_file and named.is_file():
        return named
    known = ", ".join(sorted(path.stem for path in SCENARIOS.glob("*.toml")))
    raise BadInput(f"There is no scenario {name_or_file!r}.", f"Known: {known}, or a file ending in .toml.")


def _check_beam(light: Light, file: Path) -> None:
    """Raise BadInput for a beam that is said twice or whose angles do not grow."""
    where = f"{file}: [[lights]] {light.name!r}"
    if light.beam is None:
        return
    if light.half_intensity_deg is not None:
        raise BadInput(f"{where} has half_intensity_deg and beam.", "Keep the one that was measured.")
    angles = [angle for angle, _ in light.beam]
    if any(later <= earlier for earlier, later in pairwise(angles)):
        raise BadInput(f"{where}: the angles of its beam do not grow.", "Write them from small to large.")
