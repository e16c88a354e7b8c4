"""Plans: a TOML file that names axes, and the cells of their product by number."""

import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import msgspec

from bridge.errors import BadInput
from bridge.messages import Unit
from bridge.start_messages import Matcher
from experiments.axes import numbers, stack_folders, strategies, unique_names
from experiments.kinds import KINDS
from geometry.errors import GeometryError
from geometry.model import find_target
from image_server.simulator.scenario import load_scenario
from stack.format import STACK_FILE, NotNegative, Strength
from stack.tables import as_table, read_toml

HINTS = {"stacks and targets": "Name some in it, or give stack folders after it."}
KEY_BITS = 63  # a signed column holds them

Words = list[str] | str
Numbers = list[int] | int | str


class Condition(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Light and blur instead of those in a stack or scenario, as the image server's options say them.

    Attributes
    ----------
    ambient_scale : strength of the sun; 0 is eclipse.
    light_power : multiplies the power of every light.
    defocus_sigma_px : blur at the widest aperture, px.
    motion_px_per_s : image motion, px/s.
    """

    name: str
    ambient_scale: Strength | None = None
    light_power: Strength | None = None
    defocus_sigma_px: NotNegative | None = None
    motion_px_per_s: tuple[float, float] | None = None

    def values(self) -> tuple[float | None, float | None, float | None, tuple[float, float] | None]:
        """In the order that `with_conditions` of stacks and scenarios takes them."""
        return self.ambient_scale, self.light_power, self.defocus_sigma_px, self.motion_px_per_s


class PlanSettings(msgspec.Struct, frozen=True, kw_only=True):
    """What is the same for all cells of a plan.

    Attributes
    ----------
    max_iterations : images at most.
    threshold : merit in pixels under which a pose is trusted; None is the default, which is calibrated.
    deadline_s : after which a cell counts as failed, seconds.
    """

    kind: str = "session"
    max_iterations: int = 10
    threshold: float | None = None
    matcher: Matcher = "search"
    deadline_s: float = 300.0


class _File(PlanSettings, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A plan as it is written."""

    controllers: Words = msgspec.field(default_factory=list)
    stacks: Words = msgspec.field(default_factory=list)
    targets: Words = msgspec.field(default_factory=list)
    unit: Unit = "m"
    scenarios: Words = msgspec.field(default_factory=list)
    conditions: list[Condition] = msgspec.field(default_factory=list)
    poses: Numbers | None = None
    seeds: Numbers = 1


@dataclass(frozen=True)
class PlanScene:
    """What is photographed: a stack, or a target of the simulator under a scenario.

    Attributes
    ----------
    stack, target, scenario : names, as rows give them.
    source : what the names stand for: the stack's folder, or target and scenario as the simulator takes them.
    pose : seed of the scene where the plan names poses; else the session's seed draws it.
    unit : of the numbers in a target's file.
    """

    stack: str | None
    target: str | None
    scenario: str | None
    source: tuple[str, ...]
    condition: Condition | None = None
    pose: int | None = None
    unit: Unit = "m"


@dataclass(frozen=True)
class Cell:
    """One thing to be computed, and all that it depends on.

    Attributes
    ----------
    controller : name of the strategy, as rows give it; other kinds of cells compare other things here.
    controller_source : what the name stands for, as the kind takes it.
    """

    scene: PlanScene
    controller: str
    controller_source: str
    seed: int
    settings: PlanSettings

    @property
    def pose(self) -> int | None:
        """Seed that draws the scene; None for a stack, whose scene is fixed."""
        if self.scene.stack is not None:
            return None
        return self.seed if self.scene.pose is None else self.scene.pose

    def names(self) -> dict[str, Any]:
        """The columns that say which cell a row is of."""
        scene = self.scene
        return {
            "controller": self.controller,
            "stack": scene.stack,
            "target": scene.target,
            "scenario": scene.scenario,
            "condition": None if scene.condition is None else scene.condition.name,
            "pose": self.pose,
            "seed": self.seed,
        }

    @property
    def key(self) -> int:
        """The same for the same cell in any plan, and another for another."""
        unit = [] if self.scene.unit == "m" else [self.scene.unit]  # cells of metres are what they were
        told = json.dumps([*self.names().values(), *msgspec.structs.astuple(self.settings)[:-1], *unit])
        digest = hashlib.blake2b(told.encode(), digest_size=8).digest()
        return int.from_bytes(digest) >> (64 - KEY_BITS)


@dataclass(frozen=True)
class Plan:
    """Axes whose product is cells. The controllers of one scene and seed follow each other."""

    name: str
    settings: PlanSettings
    scenes: Sequence[PlanScene]
    controllers: Sequence[tuple[str, str]]
    seeds: Sequence[int]

    def __len__(self) -> int:
        return len(self.seeds) * len(self.scenes) * len(self.controllers)

    def cell(self, number: int) -> Cell:
        """The cell with a number, from 0."""
        number, controller = divmod(number, len(self.controllers))
        number, scene = divmod(number, len(self.scenes))
        name, source = self.controllers[controller]
        return Cell(self.scenes[scene], name, source, self.seeds[number], self.settings)

    def cells(self) -> Iterator[Cell]:
        """All of them."""
        return map(self.cell, range(len(self)))

    @cached_property
    def description(self) -> dict[str, Any]:
        """What a table says of the plan that it is of."""
        return {
            "plan": self.name,
            "controllers": [name for name, _ in self.controllers],
            "scenes": len(self.scenes),
            "seeds": len(self.seeds),
            "cells": len(self),
            "settings": msgspec.structs.asdict(self.settings),
            "sources": {
                "controllers": dict(self.controllers),
                "stacks": {s.stack: s.source[0] for s in self.scenes if s.stack is not None},
                "targets": {s.target: s.source[0] for s in self.scenes if s.target is not None},
                "units": {s.target: s.unit for s in self.scenes if s.target is not None},
                "scenarios": {s.scenario: s.source[1] for s in self.scenes if s.scenario is not None},
                "conditions": {
                    s.condition.name: msgspec.to_builtins(s.condition) for s in self.scenes if s.condition
                },
            },
        }


def read_plan(file: Path, stacks: Sequence[Path] = (), seeds: str | None = None) -> Plan:
    """Read a plan, with more stacks or other seeds than it names.

    Parameters
    ----------
    file : TOML; relative paths in it are relative to its folder.
    stacks : folders that join those of the plan.
    seeds : instead of the plan's.

    Raises
    ------
    BadInput : an unknown key or name, a value that cannot be used, or a plan without a cell.
    """
    given = as_table(read_toml(file, "plan"), _File, file)
    try:
        return _plan(file, given, stacks, seeds)
    except BadInput as error:
        raise BadInput(f"{file}: {error.message}", error.hint) from None


def _plan(file: Path, given: _File, stacks: Sequence[Path], seeds: str | None) -> Plan:
    if given.kind not in KINDS:
        raise BadInput(f"there is no kind {given.kind!r}.", f"Kinds: {', '.join(KINDS)}.")
    if given.max_iterations < 1:
        raise BadInput(f"max_iterations must be at least 1, not {given.max_iterations}.")
    if given.threshold is not None and not given.threshold > 0.0:
        raise BadInput(f"threshold must be a positive number of pixels, not {given.threshold:g}.")
    if not given.deadline_s > 0.0:
        raise BadInput(f"deadline_s must be positive, not {given.deadline_s:g}.")
    kind = KINDS[given.kind]
    here = file.resolve().parent
    if given.scenarios and not given.targets:
        raise BadInput("it has scenarios but no targets.", 'Add targets = ["cube"], or leave them out.')
    drawn_by = numbers("seeds", seeds if seeds is not None else given.seeds)
    settings = msgspec.convert(given, PlanSettings, from_attributes=True)
    scenes = _scenes(given, stack_folders(_words(given.stacks), here) + _checked_folders(stacks), here)
    if kind.simulated and any(scene.stack is not None for scene in scenes):
        raise BadInput(f"cells of kind {given.kind!r} need the simulator, not stacks.", "Give targets.")
    compared = strategies(kind, _words(given.controllers), here)
    for axis, values in (("controllers", compared), ("stacks and targets", scenes), ("seeds", drawn_by)):
        if not values:
            raise BadInput(f"the plan has no cell: {axis} are empty.", HINTS.get(axis, ""))
    return Plan(file.stem, settings, scenes, compared, drawn_by)


def _words(given: Words) -> list[str]:
    return [given] if isinstance(given, str) else given


def _checked_folders(stacks: Sequence[Path]) -> list[Path]:
    for folder in stacks:
        if not (folder / STACK_FILE).is_file():
            raise BadInput(f"{folder} holds no {STACK_FILE}.")
    return [folder.resolve() for folder in stacks]


def _scenes(given: _File, folders: list[Path], here: Path) -> list[PlanScene]:
    places = [(stack, None, None, (str(folder),)) for stack, folder in unique_names("stack", folders)]
    scenarios = _named(_words(given.scenarios) or ["nominal"], here, "scenario", load_scenario)
    targets = _named(_words(given.targets), here, "target", find_target)
    units: dict[str, Unit] = {name: given.unit if Path(source).is_file() else "m" for name, source in targets}
    if given.unit not in ("m", *units.values()):
        raise BadInput("it has a unit, but no target of a file.", "The project's targets are in metres.")
    conditions: list[Condition | None] = list(given.conditions) or [None]
    if len({condition.name for condition in given.conditions}) < len(given.conditions):
        raise BadInput("two conditions have the same name.")
    poses = [None] if given.poses is None else numbers("poses", given.poses)
    scenes = [PlanScene(*place, condition) for place in places for condition in conditions]
    return scenes + [
        PlanScene(None, target, scenario, (target_source, scenario_source), condition, pose, units[target])
        for pose in poses
        for condition in conditions
        for scenario, scenario_source in scenarios
        for target, target_source in targets
    ]


def _named(words: list[str], here: Path, what: str, load: Any) -> list[tuple[str, str]]:
    """Names with what they stand for: files beside the plan, or names that the simulator knows."""
    sources = [str(here / word) if (here / word).is_file() else word for word in words]
    for word, source in zip(words, sources, strict=True):
        try:
            load(source)
        except GeometryError as error:
            raise BadInput(f"{error}.") from None
        except BadInput as error:
            raise BadInput(f"{what} {word!r}: {error.message}", error.hint) from None
    return [(name, str(path)) for name, path in unique_names(what, [Path(s) for s in sources])]
