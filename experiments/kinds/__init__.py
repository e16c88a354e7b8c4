"""Kinds of cells: each is a function from a cell and a warm worker to a row.

A kind that is added here can be named by a plan (`kind = "..."`). Its function returns a dict with `status`
and whatever columns it knows; the engine adds which cell it was, and how long it took.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import TYPE_CHECKING, Any

from vision_server.baselines import MERGE_RULES

if TYPE_CHECKING:
    from experiments.plan import Cell
    from experiments.worker import Worker

Row = dict[str, Any]
Run = Callable[["Cell", "Worker"], Row]

COLUMNS: Mapping[str, type] = {
    "controller": str,
    "stack": str,
    "target": str,
    "scenario": str,
    "condition": str,
    "pose": int,
    "seed": int,
    "status": str,
    "images": int,
    "kept": int,
    "rotation_deg": float,
    "translation_fraction": float,
    "merit": float,
    "seconds": float,
    "rms_px": float,
    "uncertainty": float,
    "cell_seconds": float,
    "message": str,
    "key": int,
}
"""Columns of every table; the names of a cell first."""
TIMES = ("capture", "edges", "linking", "matching", "refinement", "controller", "bridge")
"""Where the time of a session goes; each a column ``<name>_s``."""


@dataclass(frozen=True)
class Kind:
    """A kind of cell.

    Attributes
    ----------
    file : of `experiments.kinds`, whose function `run` computes a row.
    strategies : in words, what stands for the controllers of a plan; None for controllers.
    knows : whether a word is such a strategy.
    simulated : it needs the simulator.
    columns : its own, beside those of every table.
    """

    file: str
    strategies: str | None = None
    knows: Callable[[str], bool] = lambda word: True
    simulated: bool = False
    columns: Mapping[str, type] = field(default_factory=dict)

    @property
    def run(self) -> Run:
        """The function; loaded when it is needed."""
        function: Run = import_module(f"experiments.kinds.{self.file}").run
        return function


def _random_or_middle(word: str) -> bool:
    lights, _, count = word.partition("-")
    return lights in ("random", "middle") and count.isdecimal() and int(count) > 0


RULES = ("em", "em-unweighted", *MERGE_RULES)
_session_times = {f"{part}_s": float for part in TIMES}

KINDS: Mapping[str, Kind] = {
    "session": Kind("session", columns=_session_times),
    "approach": Kind("approach", simulated=True, columns=_session_times | {"holds": int, "fixed": int}),
    "estimate": Kind(
        "estimate",
        "random-N and middle-N, N images under random or middle settings",
        _random_or_middle,
        columns={
            "score": float,
            "ambiguity": float,
            "supported_fraction": float,
            "normalised_error_squared": float,
        },
    ),
    "edges": Kind(
        "edges",
        ", ".join(RULES),
        RULES.__contains__,
        simulated=True,
        columns={"best_f": float, "false_at_best": float, "false_at_recall_80": float},
    ),
    "empty": Kind("empty", "anything: an empty cell costs what the engine costs"),
}
