"""Estimates of drawn scenes, right and wrong, that `benchmarks.trust_fit` fits the trust to: one row each."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any
from zlib import crc32

import msgspec
import numpy as np
from scipy.spatial import cKDTree

from benchmarks.drawn_parts import PARTS, part_file
from benchmarks.hard_scenes import KINDS
from benchmarks.photographs import Photograph, Studio, image_set, stack_studio
from experiments.kinds.estimate import normalised_error_squared
from geometry.camera import Camera
from geometry.deformed import deformed
from geometry.model import Model, load_model
from geometry.pose import disturbed
from geometry.rotation import matrix_of
from geometry.visibility import visible_samples
from image_server.simulator.scenario import load_scenario
from image_server.simulator.scenario_tables import Scenario
from image_server.simulator.simulator import Simulator
from vision_server.matching import SearchRange
from vision_server.pipeline import PipelineSettings, estimate_pose
from vision_server.trust.judgement import Estimate, stated
from vision_server.trust.stretch import stretched

Row = dict[str, Any]

SETS = (("any", 3), ("exposed", 2), ("exposed", 6))
EXPOSED_GREY = (60, 250)  # the brightest twentieth of the image lies between
DARK_GREY = 40  # that of a dark set's brightest image lies below
TRIES = 12
STRETCHES = (0.02, 0.03, 0.05, 0.08, 0.1, 0.12, 0.15, 0.2)
SHEARS = (0.03, 0.05, 0.1, 0.15)
OTHERS = ("cube", "fixture", "satellite", *PARTS)
SIZE = (0.8, 1.2)  # of another model, over the target's
WRONG = ("mirrored", "sheared", "turned", "other")  # models besides a stretched one
TARGETS = (
    "part", "bus", "wheel", "plate", "tee", "cube", "tower", "fixture", "bus", "wheel", "satellite", "tee",
    "plate",
)  # fmt: skip
# Of the simulator; a second name is the scenario that light and camera are of, or an arm before the target.
SCENARIOS = (
    "nominal", "textured+blur", "textured+arm", "eclipse+blur", "eclipse", "textured+focus", "grazing+arm",
    "textured", "earth-limb+blur", "harsh+arm", "harsh", "foil", "eclipse+blur+arm", "textured+far", "far",
    "textured+blur+arm", "back-lit",
)  # fmt: skip
ARM = (0.1, 0.25)  # width, of the target's diameter
BLURRED = ("blur", "focus")
SPACING_PX = 3.0  # of samples of visible lines
MOST_OF_THEM = 98.0  # per cent: corners that hide each other otherwise are the rest


def drawn_set(studio: Studio, kind: str, count: int, rng: np.random.Generator) -> list[Photograph]:
    """Images under settings drawn at random; `exposed` ones are drawn again when too dark or too bright."""
    described, shots = studio.device.describe(), []
    for _ in range(count):
        for _ in range(TRIES if kind == "exposed" else 1):
            shot = studio.photograph(
                tuple(int(rng.integers(0, light.levels)) for light in described.lights),
                float(rng.choice(described.shutters_s)),
                float(rng.choice(described.apertures)),
            )
            if EXPOSED_GREY[0] <= np.percentile(shot.pixels, 95) <= EXPOSED_GREY[1]:
                break
        shots.append(shot)
    return shots


def models(model: Model, rng: np.random.Generator) -> Iterator[tuple[str, Model]]:
    """The true model, one stretched along an axis, and one that is wrong in another way."""
    yield "true", model
    by = float(rng.choice(STRETCHES) * rng.choice([-1.0, 1.0]))
    axis, beside = (int(k) for k in rng.permutation(3)[:2])
    yield f"{'xyz'[axis]}{by:+.2f}", stretched(model, math.log(1.0 + by) * np.eye(3)[axis])
    kind = str(rng.choice(WRONG))
    if kind in ("mirrored", "turned") and model.name == "wheel":
        kind = "other"  # a wheel is still one where its block is out of sight
    if kind == "other":
        yield kind, _other(model, rng)
        return
    change = np.eye(3)
    if kind == "mirrored":
        change[axis, axis] = -1.0
    elif kind == "turned":
        change = matrix_of(math.pi * np.eye(3)[axis])
    else:
        change[axis, beside] = float(rng.choice(SHEARS))
    yield kind, deformed(model, change)


def _other(model: Model, rng: np.random.Generator) -> Model:
    """Another target, or a drawn part, of about the model's size."""
    name = str(rng.choice([name for name in OTHERS if name != model.name or name in PARTS]))
    other = model_named(name, rng)
    size = math.log(model.diameter / other.diameter * rng.uniform(*SIZE))
    return stretched(other, np.full(3, size))


def model_named(name: str, rng: np.random.Generator) -> Model:
    """A target of the project, or a part of `drawn_parts`."""
    with tempfile.TemporaryDirectory() as scratch:
        return load_model(part_file(name, Path(scratch), rng))


def simulated(number: int, seed: int) -> tuple[str, Studio, bool]:
    """A scene of the simulator, as `stack_scene`; with its number, scenarios and targets go round."""
    scenario_name, target = SCENARIOS[number % len(SCENARIOS)], TARGETS[number % len(TARGETS)]
    first, *others = scenario_name.split("+")
    scenario = load_scenario(first)
    if "arm" in others:
        wide = float(np.random.default_rng([seed, number]).uniform(*ARM))
        behind = msgspec.structs.replace(scenario.background, arm=wide)
        scenario = msgspec.structs.replace(scenario, background=behind)
    for other in (one for one in others if one != "arm"):
        light = load_scenario(other)
        scenario = msgspec.structs.replace(
            scenario, camera=light.camera, light_power=light.light_power, pose=light.pose
        )
    with tempfile.TemporaryDirectory() as scratch:
        file = part_file(target, Path(scratch), np.random.default_rng([seed, number]))
        name = f"simulated {scenario_name} {target}-{number} {seed}"
        return name, studio_of(name, file, scenario, 1000 * seed + number), False


def studio_of(name: str, file: Path, scenario: Scenario, seed: int) -> Studio:
    """The simulator with a target's file in a scenario, drawn by a seed."""
    simulator = Simulator(file, scenario, seed)
    described = simulator.describe()
    assert described.camera is not None
    camera = Camera.from_dict(msgspec.to_builtins(described.camera))
    return Studio(name, simulator, camera, simulator.model, simulator.true_pose)


def strata_of(name: str, shots: Sequence[Photograph], model: Model) -> list[str]:
    """What is hard about a set of images: dark, blurred, hidden, few lines, nearly symmetric; or mild."""
    if name.startswith("simulated"):
        scenario, part = name.split()[1:3]
        blurred, hidden = any(one in scenario for one in BLURRED), "arm" in scenario
        of_light = scenario in ("nominal", "textured", "earth-limb")
        part = part.rpartition("-")[0]
    else:
        part, _, number = Path(name).name.rpartition("-")
        kind = KINDS[(int(number) - 1) % len(KINDS)]
        blurred, hidden, of_light = kind in "ACE", kind in "CE", False
    told = {
        "dark": max(float(np.percentile(shot.pixels, 95)) for shot in shots) < DARK_GREY,
        "blurred": blurred,
        "hidden": hidden,
        "few lines": len(model.lines) <= 21,
        "symmetric": part in ("wheel", "cube", "gear", "dial"),
        "mild": of_light,
    }
    return [stratum for stratum, so in told.items() if so]


def apart_px(studio: Studio, model: Model, found: Estimate) -> float | None:
    """How far visible lines of a model, where it was found, are from those of the true one, and back.

    Most of them are nearer. Where that is next to nothing, no image of the scene tells the models apart.
    """
    if found.pose is None:
        return None
    placed = (model, found.pose), (studio.model, studio.true)
    one, other = (visible_samples(each, studio.camera, pose, SPACING_PX).image for each, pose in placed)
    if not len(one) or not len(other):
        return None
    away = cKDTree(other).query(one)[0], cKDTree(one).query(other)[0]
    return float(max(np.percentile(side, MOST_OF_THEM) for side in away))


def row_of(studio: Studio, found: Estimate) -> Row:
    """What the fit needs of one estimate."""
    if found.pose is None or found.support is None or found.agreement is None:
        return {"pose": False}
    error, doubt, settled = found.pose.error_to(studio.true), found.misfit, found.agreement
    return {
        "pose": True, "rotation_deg": error.rotation_deg, "translation": error.translation_fraction_of_range,
        "within": error.within(1.0, 0.01), "confirmed": found.support.confirmed,
        "missing": found.support.missing, "uncertainty": found.uncertainty, "ambiguity": found.ambiguity,
        "otherwise": doubt.otherwise if doubt else 0.0,
        "gain": doubt.gain if doubt else 0.0, "borne_out": doubt.borne_out if doubt else 1.0,
        "significance": doubt.significance if doubt else 0.0,
        "surely_wrong": bool(doubt and doubt.suspected), "score": found.score,
        "agreeing": settled.share, "scatter": settled.scatter, "astray": settled.astray,
        "contested": settled.contested,
        "normalised": normalised_error_squared(found.pose, stated(found).covariance, studio.true),
    }  # fmt: skip


def rows_of(name: str, studio: Studio, empty: bool, seed: int) -> list[Row]:
    """Estimates of one scene, from SETS and `models`."""
    rng = np.random.default_rng([seed, crc32(name.encode())])
    reach, rows = SearchRange(), []
    for kind, count in SETS:
        shots = drawn_set(studio, kind, count, rng)
        images = image_set(shots)
        start = disturbed(
            studio.true, rng, reach.rotation_deg, reach.translation_px, studio.camera.fx, studio.model.middle
        )
        for wrong, model in models(studio.model, rng):
            settings = PipelineSettings(seed=seed, tone_sd_px=shots[0].tone_sd_px)
            found = estimate_pose(images, list(images.images), model, studio.camera, start, settings)
            told = {"scene": name, "empty": empty, "set": f"{kind} {count}", "model": wrong}
            told["apart_px"] = apart_px(studio, model, found)
            rows.append(told | {"strata": strata_of(name, shots, model)} | row_of(studio, found))
    return rows


def stack_scene(folder: Path) -> tuple[str, Studio, bool]:
    """A drawn stack by its name, and whether there is nothing on it."""
    number = int(folder.name.rpartition("-")[2])
    return folder.name, stack_studio(folder), KINDS[(number - 1) % len(KINDS)] == "N"
