"""What poses make of a constant's value: each is halved and doubled in turn, on the same scenes.

    .venv/bin/python -m benchmarks.constants --stacks DIR [--every 1] [--starts 1] MODULE ...

MODULE is one such as vision_server.trust.ranking, or a constant, as vision_server.trust.ranking.MOST_BESIDE.
Of tuples all numbers are halved or doubled; a share between a half and one goes half of the way to 1 instead.
Constants of compiled kernels are named and left out: a kernel keeps the value that it was compiled with. One
JSON object for each, beside the default: estimates that are right and tight, wrong ones that are trusted, and
what was gained and lost, as `benchmarks.ablation` has them. --stacks may be given again; --every takes each
so many-th stack.
"""

from __future__ import annotations

import ast
import inspect
import json
import sys
from collections.abc import Iterator
from functools import partial
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Annotated, Any

import typer

from benchmarks.ablation import ROWS, Patch, Scene, run_scene, stack_scenes, summary

UNITS = ("_PX", "_RAD", "_DEG", "_M")  # a constant with one is no share


def scaled(name: str, value: Any, factor: float) -> Any:
    """A constant that is halved or doubled; None for what is no number."""
    if isinstance(value, tuple):
        parts = tuple(scaled(name, part, factor) for part in value)
        return None if any(part is None for part in parts) else parts
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    if isinstance(value, int):
        return max(1, round(value * factor)) if value > 0 else None
    share = 0.5 < value < 1.0 and not name.endswith(UNITS)
    return 0.5 * (1.0 + value) if share and factor > 1.0 else value * factor


def rooms() -> list[ModuleType]:
    """Modules of ours that are loaded."""
    ours = ("vision_server.", "geometry.", "numerics.")
    return [module for name, module in list(sys.modules.items()) if name.startswith(ours)]


def holders(name: str, value: object) -> list[ModuleType]:
    """Modules that have a constant by its name."""
    return [module for module in rooms() if getattr(module, name, None) is value]


def in_kernels(name: str, value: object) -> bool:
    """Whether a compiled kernel has the constant."""
    kernels = (one.py_func for module in rooms() for one in vars(module).values() if hasattr(one, "py_func"))
    return any(name in one.__code__.co_names and one.__globals__.get(name) is value for one in kernels)


def named(place: str) -> tuple[str, list[str]]:
    """A module, and the constants in it that are meant."""
    module, _, name = place.rpartition(".")
    if name.isupper():
        return module, [name]
    tree = ast.parse(inspect.getsource(import_module(place)))
    told = [node for line in tree.body if isinstance(line, ast.Assign) for node in ast.walk(line)]
    return place, [
        node.id
        for node in told
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store) and node.id.isupper()
    ]


def seeded_scenes(folder: Path) -> Iterator[Scene]:
    """Scenes of a stack whose seed pose is near the true one."""
    return (scene for scene in stack_scenes("stacks", folder) if scene.turned is None)


def main(
    places: Annotated[list[str], typer.Argument(metavar="MODULE")],
    stacks: Annotated[list[Path], typer.Option(help="Folder of stacks; may be given again.")],
    every: Annotated[int, typer.Option(min=1)] = 1,
    starts: Annotated[int, typer.Option(min=1)] = 1,
) -> None:
    """Halve and double constants."""
    rows: dict[str, tuple[Patch, ...]] = {}
    for place in places:
        module, names = named(place)
        for name in names:
            value = getattr(import_module(module), name)
            if scaled(name, value, 2.0) is None:
                continue
            if in_kernels(name, value):
                print(f"{module}.{name}: of a kernel", file=sys.stderr)
                continue
            for factor in (0.5, 2.0):
                patches = tuple(
                    (holder, name, scaled(name, value, factor)) for holder in holders(name, value)
                )
                rows[f"{module}.{name} = {patches[0][2]}, not {value}"] = patches
    ROWS.update(rows)
    scenes = [
        list(seeded_scenes(file.parent))
        for folder in stacks
        for file in sorted(folder.glob("*/stack.toml"))[::every]
    ]

    def found(row: str) -> list[dict[str, Any]]:
        return [one for some in scenes for one in run_scene(partial(iter, some), [row], starts)]

    base = found("default")
    for row in ("default", *rows):  # each is told when it is known
        print(json.dumps(summary(row, "all", found(row), base)), flush=True)


if __name__ == "__main__":
    typer.run(main)
