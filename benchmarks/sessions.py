"""Many whole sessions on all cores, and what became of them.

    .venv/bin/python -m benchmarks.sessions stacks FOLDER...    every stack, seed and controller
    .venv/bin/python -m benchmarks.sessions simulator           the default target, many poses
    .venv/bin/python -m benchmarks.sessions grid                three targets, five suns, two backgrounds
    .venv/bin/python -m benchmarks.sessions worth FOLDER...     what control is worth, by sun, blur, light
    .venv/bin/python -m benchmarks.sessions scenarios           every scenario, the three targets in turn
    .venv/bin/python -m benchmarks.sessions approach            docking from the first to the contact range

Each prints one JSON object per session and then a table. A pose is right when it is off by less than 1
degree and 1 % of the range, tight when by less than 0.2 degrees and 0.2 %.
"""

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from benchmarks.conditions import simulated_conditions, stack_under_sun, sun_scenarios

ROOT = Path(__file__).resolve().parent.parent
SESSION_DEADLINE_S = 300.0
RIGHT = (1.0, 0.01)
TIGHT = (0.2, 0.002)
TARGETS = ("cube", "fixture", "satellite")

app = typer.Typer(help=__doc__, no_args_is_help=True, rich_markup_mode=None)


@dataclass(frozen=True)
class Case:
    """One session to run: where it comes from, its command line, and the group its row belongs to."""

    group: str
    name: str
    controller: str
    seed: int
    options: tuple[str, ...] = field(default=())


def run_case(case: Case, folder: Path) -> dict[str, Any]:
    """Run one session and return its row; `folder` keeps the session's files."""
    out = folder / f"{case.name}-{case.controller}-{case.seed}".replace("/", "_")
    command = [
        "swipl", str(ROOT / "main.pl"), "--controller", case.controller, "--seed", str(case.seed),
        "--json", "--quiet", "--no-report", "--out", str(out), *case.options,
    ]  # fmt: skip
    row: dict[str, Any] = {
        "group": case.group,
        "case": case.name,
        "controller": case.controller,
        "seed": case.seed,
    }
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=SESSION_DEADLINE_S, check=False
        )
    except subprocess.TimeoutExpired:
        return row | {"exit": None, "status": "deadline"}
    row["exit"] = done.returncode
    try:
        result = json.loads(done.stdout)
    except json.JSONDecodeError:
        return row | {"status": "failed", "message": done.stderr.strip()[-500:]}
    error = result.get("error")
    row |= {
        "status": result["status"],
        "iterations": result["iterations"],
        "kept": len(result["kept"]),
        "rms_px": result["rms_px"],
        "merit_px": result.get("merit_px"),
        "uncertainty": result.get("uncertainty"),
        "seconds": result["seconds"],
        "rotation_deg": error["rotation_deg"] if error else None,
        "fraction": error["translation_fraction_of_range"] if error else None,
    }
    if "holds" in result:
        row["holds"] = result["holds"]
    return row


def run_all(cases: Iterable[Case], keep: Path | None) -> Iterator[dict[str, Any]]:
    """Run all cases, as many at a time as there are cores; yields rows in the order of the cases."""
    with tempfile.TemporaryDirectory() as scratch, ThreadPoolExecutor(os.cpu_count()) as pool:
        yield from pool.map(lambda case: run_case(case, keep or Path(scratch)), cases)


def within(row: dict[str, Any], bounds: tuple[float, float]) -> bool:
    """Is the session's final pose within (degrees, fraction of range) of the truth?"""
    return (
        row.get("rotation_deg") is not None
        and row["rotation_deg"] < bounds[0]
        and row["fraction"] < bounds[1]
    )


def summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Success, certainty, cost and accuracy of a group of sessions."""
    sure = [row for row in rows if row["status"] == "converged"]
    posed = [row for row in rows if row.get("rotation_deg") is not None]
    finished = [row for row in rows if "seconds" in row]

    def quantiles(key: str, scale: float) -> str:
        values = [scale * row[key] for row in posed]
        return f"{np.median(values):.3f} / {np.quantile(values, 0.9):.3f}" if values else "-"

    def median(values: list[float]) -> float:
        return float(np.median(values)) if values else float("nan")

    return {
        "sessions": len(rows),
        "right": sum(within(row, RIGHT) for row in rows),
        "tight": sum(within(row, TIGHT) for row in rows),
        "converged": len(sure),
        "false": sum(not within(row, RIGHT) for row in sure),
        "failed": sum(row["status"] in ("failed", "deadline") for row in rows),
        "deg, median / 90 %": quantiles("rotation_deg", 1.0),
        "% of range, median / 90 %": quantiles("fraction", 100.0),
        "images": median([row["iterations"] for row in finished]),
        "kept": median([row["kept"] for row in finished]),
        **{
            part: round(median([row["seconds"].get(part, 0.0) for row in finished]), 3)
            for part in (
                "total",
                "capture",
                "edges",
                "linking",
                "matching",
                "refinement",
                "controller",
                "bridge",
            )
        },
    }


def report(rows: Iterable[dict[str, Any]]) -> None:
    """Print each row as it comes, then a table of the groups on standard error."""
    groups: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for row in rows:
        print(json.dumps(row), flush=True)
        groups.setdefault((row["group"], row["controller"]), []).append(row)
    table = Table(
        title="right: < 1 deg and < 1 %; tight: < 0.2 deg and < 0.2 %; false: converged but not right"
    )
    first = True
    for (group, controller), members in groups.items():
        cells = summary(members)
        if first:
            for heading in ("group", "controller", *cells):
                table.add_column(heading, no_wrap=True)
            first = False
        table.add_row(
            group,
            controller,
            *(f"{value:g}" if isinstance(value, float) else str(value) for value in cells.values()),
        )
    Console(stderr=True, width=250).print(table)


Controllers = Annotated[str, typer.Option(help="Names or files, separated by commas.")]
Seeds = Annotated[str, typer.Option(help="Seeds: 1-5, or 1,2,7.")]
Keep = Annotated[Path | None, typer.Option(help="Keep every session's run folder here.")]
Folders = Annotated[list[Path], typer.Argument(help="Stack folders.")]
PAPER = "simple,greedy,heuristic"
ALL = "fixed,auto_exposed,simple,greedy,heuristic"


def _seeds(text: str) -> list[int]:
    seeds: list[int] = []
    for part in text.split(","):
        low, _, high = part.partition("-")
        seeds += range(int(low), int(high or low) + 1)
    return seeds


@app.command()
def stacks(
    folders: Folders, controllers: Controllers = PAPER, seeds: Seeds = "1-5", keep: Keep = None
) -> None:
    """Every stack under every controller and seed."""
    report(
        run_all(
            [
                Case("stacks", folder.name, controller, seed, ("--stack", str(folder)))
                for controller in controllers.split(",")
                for folder in folders
                for seed in _seeds(seeds)
            ],
            keep,
        )
    )


@app.command()
def simulator(controllers: Controllers = PAPER, seeds: Seeds = "1-50", keep: Keep = None) -> None:
    """The simulator's default target under its default scenario; each seed is another pose."""
    report(
        run_all(
            [Case("simulator", "default", c, seed) for c in controllers.split(",") for seed in _seeds(seeds)],
            keep,
        )
    )


@app.command()
def scenarios(
    names: Annotated[list[str] | None, typer.Argument(help="Scenarios; all when left out.")] = None,
    controllers: Controllers = "heuristic",
    seeds: Seeds = "1-20",
    keep: Keep = None,
) -> None:
    """Every scenario; each seed is another pose, and the next of the three targets."""
    names = names or sorted(file.stem for file in (ROOT / "scenarios").glob("*.toml"))
    report(
        run_all(
            [
                Case(name, name, c, seed, ("--scenario", name, "--target", TARGETS[seed % len(TARGETS)]))
                for c in controllers.split(",")
                for name in names
                for seed in _seeds(seeds)
            ],
            keep,
        )
    )


@app.command()
def grid(controllers: Controllers = "heuristic", seeds: Seeds = "1-4", keep: Keep = None) -> None:
    """Three targets, five sun directions (back-lit and grazing among them), with and without a background."""
    with tempfile.TemporaryDirectory() as scratch:
        scenarios = sun_scenarios(Path(scratch))
        report(
            run_all(
                [
                    Case(name, f"{target}-{name}", c, seed, ("--target", target, "--scenario", str(file)))
                    for c in controllers.split(",")
                    for name, file in scenarios.items()
                    for target in TARGETS
                    for seed in _seeds(seeds)
                ],
                keep,
            )
        )


@app.command()
def worth(
    folders: Annotated[list[Path] | None, typer.Argument(help="Stack folders, beside the simulator.")] = None,
    controllers: Controllers = ALL,
    seeds: Seeds = "1-3",
    keep: Keep = None,
) -> None:
    """What control is worth: four suns, mild and hard (defocus, motion blur, weak lights)."""
    with tempfile.TemporaryDirectory() as scratch:
        cases = []
        for hard in (False, True):
            for sun in (0.0, 1.0, 8.0, 20.0):
                group = f"{'hard' if hard else 'mild'}, sun {sun:g}"
                sources: list[tuple[str, tuple[str, ...]]] = [
                    (folder.name, ("--stack", str(stack_under_sun(folder, sun, hard, Path(scratch)))))
                    for folder in folders or []
                ]
                scenario = str(simulated_conditions(sun, hard, Path(scratch)))
                sources += [(target, ("--target", target, "--scenario", scenario)) for target in TARGETS]
                cases += [
                    Case(group, f"{name}-{'hard' if hard else 'mild'}-{sun:g}", c, seed, options)
                    for c in controllers.split(",")
                    for name, options in sources
                    for seed in _seeds(seeds)
                ]
        report(run_all(cases, keep))


@app.command()
def approach(controllers: Controllers = "heuristic", seeds: Seeds = "1-10", keep: Keep = None) -> None:
    """A docking approach on the simulator from 1.5 m to 0.3 m."""
    report(
        run_all(
            [
                Case("approach", "default", c, s, ("--approach",))
                for c in controllers.split(",")
                for s in _seeds(seeds)
            ],
            keep,
        )
    )


if __name__ == "__main__":
    sys.exit(app())
