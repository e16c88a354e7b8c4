"""What became of cells: right, tight, trusted, false; as matrices of scenes by seeds for each strategy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from experiments.kinds import KINDS
from geometry.pose import RIGHT, TIGHT
from numerics.arrays import Flags, Floats, Ints

SCENE = ("stack", "target", "scenario", "condition", "pose")
TRUSTED = "converged"


@dataclass(frozen=True)
class Outcomes:
    """A table's rows, looked at by strategy, scene and seed.

    Attributes
    ----------
    kind : of the cells.
    strategies : in the order of the plan.
    scenes : names, one for each row of a matrix.
    groups : the same without poses.
    strategy_of, scene_of, seed_of : for each row of the table, numbers of those; a seed that draws the scene
        has no column of its own.
    stack_of : the same of stacks; the simulator counts as one.
    """

    kind: str
    strategies: list[str]
    scenes: list[str]
    groups: list[str]
    strategy_of: Ints
    scene_of: Ints
    seed_of: Ints
    stack_of: Ints
    columns: dict[str, Floats]
    status: NDArray[np.str_]

    @cached_property
    def right(self) -> Flags:
        """Within 1 degree and 1 % of the range, for each row."""
        return self._within(RIGHT)

    @cached_property
    def tight(self) -> Flags:
        """Within 0.2 degrees and 0.2 % of the range, for each row."""
        return self._within(TIGHT)

    @cached_property
    def trusted(self) -> Flags:
        """The session says that its pose can be trusted."""
        return np.asarray(self.status == TRUSTED)

    @cached_property
    def false(self) -> Flags:
        """Trusted and not right."""
        return self.trusted & ~self.right

    @cached_property
    def told(self) -> Flags:
        """The stack has a true pose, for each row: none of its poses is without an error."""
        untold = np.isfinite(self.columns["rms_px"]) & np.isnan(self.columns["rotation_deg"])
        return ~np.isin(self.stack_of, self.stack_of[untold])

    def _within(self, limits: tuple[float, float]) -> Flags:
        with np.errstate(invalid="ignore"):
            return np.asarray(
                (self.columns["rotation_deg"] < limits[0])
                & (self.columns["translation_fraction"] < limits[1])
            )

    def matrix(self, strategy: int, values: NDArray[np.generic], among: Flags | None = None) -> Floats:
        """Values of a strategy's rows, (scenes, seeds); NaN where there is none, or it is not `among`."""
        chosen = self.strategy_of == strategy
        if among is not None:
            chosen &= among
        out = np.full((len(self.scenes), 1 + int(self.seed_of.max(initial=0))), np.nan)
        out[self.scene_of[chosen], self.seed_of[chosen]] = values[chosen].astype(np.float64)
        return out


NUMBERS = (
    "images", "kept", "rotation_deg", "translation_fraction", "merit", "seconds", "uncertainty", "rms_px",
)  # fmt: skip


def outcomes_of(table: pa.Table, kind: str, order: Sequence[str]) -> Outcomes:
    """Look at the rows of a table of a kind of cells; `order` is that of the strategies."""
    strategy_of, strategies = _numbered(table, ["controller"])
    scene_of, scenes = _numbered(table, list(SCENE))
    seed_of, seeds = _numbered(table, ["seed"])
    ranks = {name: rank for rank, name in enumerate(order)}
    names = [str(name) for (name,) in strategies]
    places = sorted(range(len(names)), key=lambda place: (ranks.get(names[place], len(ranks)), names[place]))
    pairs = np.unique(scene_of * max(1, len(seeds)) + seed_of)
    alone = np.bincount(pairs // max(1, len(seeds)), minlength=len(scenes)) == 1
    seed_of = np.where(alone[scene_of], len(seeds), seed_of)  # a seed of its own: scenes alone are resampled
    used = np.unique(seed_of)
    return Outcomes(
        kind,
        [names[place] for place in places],
        [_words(scene) for scene in scenes],
        [_words((*scene[:4], None)) for scene in scenes],
        np.argsort(places)[strategy_of] if places else strategy_of,
        scene_of,
        np.searchsorted(used, seed_of),
        _numbered(table, ["stack"])[0],
        {name: _floats(table[name]) for name in (*NUMBERS, *KINDS[kind].columns)},
        np.asarray(table["status"].to_numpy(zero_copy_only=False), dtype=np.str_),
    )


def _numbered(table: pa.Table, columns: list[str]) -> tuple[Ints, list[tuple[Any, ...]]]:
    """For each row the number of what is in some columns, and what the numbers stand for."""
    rows = np.zeros(table.num_rows, np.int64)
    for column in columns:
        encoded = table[column].combine_chunks().dictionary_encode(null_encoding="encode")
        rows = rows * (len(encoded.dictionary) + 1) + encoded.indices.to_numpy(zero_copy_only=False)
        rows = np.unique(rows, return_inverse=True)[1].astype(np.int64)  # small numbers stay small
    _, first, rows = np.unique(rows, return_index=True, return_inverse=True)
    found = table.select(columns).take(pa.array(first))
    return rows.astype(np.int64), list(zip(*(found[column].to_pylist() for column in columns), strict=True))


def _floats(column: pa.ChunkedArray) -> Floats:
    return np.asarray(column.cast(pa.float64()).to_numpy(zero_copy_only=False), dtype=np.float64)


def _words(scene: tuple[str | int | None, ...]) -> str:
    stack, target, scenario, condition, pose = scene
    words = [str(part) for part in (stack, target, scenario, condition) if part is not None]
    return ", ".join(words + ([] if pose is None else [f"pose {pose}"]))
