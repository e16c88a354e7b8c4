"""`experiments compare`: tables of strategies with intervals, and their paired differences."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from experiments.outcomes import Outcomes
from experiments.statistics import IntervalEstimate, cells_needed, exact_interval, mcnemar, paired, resampled
from numerics.arrays import Floats

SHARES = ("right", "tight", "trusted", "false")
JUDGED = ("right", "tight", "false")  # by the true pose
SESSION = (*SHARES, "images", "images to trust", "seconds to trust")
MEASURES: dict[str, tuple[str, ...]] = {
    "session": SESSION,
    "approach": (*SESSION, "fixed"),
    "estimate": ("right", "tight", "score", "uncertainty", "seconds"),
    "edges": ("best_f", "false_at_best", "false_at_recall_80", "seconds"),
    "empty": ("seconds",),
}
"""What is compared of each kind of cells."""
POSES = ("session", "approach", "estimate")
"""Kinds of cells that end in a pose."""
WHAT_IS_SHOWN = (
    "right: off by less than 1° and 1 % of the range; tight: 0.2° and 0.2 %; trusted: the session says so;"
    " false: trusted and not right. Shares with an interval that resamples scenes and seeds [·] and the exact"
    " one of independent cells (·); means with the first."
)
SCORES = (0.5, 0.8, 0.9, 0.95)  # thresholds that are shown, chosen by hand


@dataclass(frozen=True)
class Grid:
    """A table: headings and cells of text, with a title and a note that says what its numbers are."""

    title: str
    headings: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""

    def table(self) -> str:
        """Headings and rows as Markdown."""
        lines = ["| " + " | ".join(self.headings) + " |", "|" + " --- |" * len(self.headings)]
        cells = ((cell.replace("|", "\\|") for cell in row) for row in self.rows)
        return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in cells)])

    def markdown(self) -> str:
        """Title, table and note as Markdown."""
        return "\n".join([f"## {self.title}", "", self.table(), "", *([self.note, ""] if self.note else [])])


def measure(outcomes: Outcomes, strategy: int, name: str) -> Floats:
    """Outcomes of a strategy as a matrix of scenes by seeds."""
    if name in SHARES:
        among = outcomes.told if name in JUDGED else None
        return outcomes.matrix(strategy, getattr(outcomes, name), among)
    column, _, only_trusted = name.partition(" to ")
    return outcomes.matrix(
        strategy, outcomes.columns[column], among=outcomes.trusted if only_trusted else None
    )


def strategies_grid(outcomes: Outcomes) -> Grid:
    """Success, certainty, images and time of each strategy."""
    rows = []
    for number, strategy in enumerate(outcomes.strategies):
        cells = [strategy, str(int((outcomes.strategy_of == number).sum()))]
        for name in MEASURES[outcomes.kind]:
            matrix = measure(outcomes, number, name)
            estimate = resampled(matrix)
            cells.append(share_words(matrix, estimate) if name in SHARES else mean_words(estimate))
        rows.append(cells)
    return Grid(
        "Strategies",
        ["strategy", "n", *(f"{name}, %" if name in SHARES else name for name in MEASURES[outcomes.kind])],
        rows,
        _what_is_shown(outcomes),
    )


def _what_is_shown(outcomes: Outcomes) -> str:
    if outcomes.kind not in POSES:
        return "Means, with intervals that resample scenes and seeds."
    untold = int((~outcomes.told).sum())
    left_out = f" Of {untold} rows no true pose is known: they are not among right, tight and false."
    return WHAT_IS_SHOWN + (left_out if untold else "")


def differences_grid(outcomes: Outcomes) -> Grid:
    """Paired differences of all pairs of strategies."""
    rows = []
    for ours, theirs in pairs(outcomes):
        for name in MEASURES[outcomes.kind]:
            a, b = measure(outcomes, ours, name), measure(outcomes, theirs, name)
            found = paired(a, b)
            if found.n == 0:
                continue
            won, lost, chance = mcnemar(a, b) if name in SHARES else (0, 0, math.nan)
            rows.append(
                [
                    f"{outcomes.strategies[ours]} − {outcomes.strategies[theirs]}",
                    name,
                    f"{found.n} in {found.scenes}",
                    difference_words(found, name in SHARES),
                    f"{won} : {lost}, p = {chance:.2g}" if name in SHARES else "",
                    verdict(found),
                ]
            )
    return Grid(
        "Paired differences",
        ["strategies", "measure", "pairs, scenes", "difference", "only one has it, McNemar", "verdict"],
        rows,
        "Shares in percentage points. A difference is called one only when its interval excludes zero; of"
        " several, one in twenty is expected to by chance.",
    )


def scenes_grid(outcomes: Outcomes) -> Grid:
    """Share of right poses by scene of a stack, or by target and scenario."""
    groups = list(dict.fromkeys(outcomes.groups))
    place = np.array([groups.index(group) for group in outcomes.groups])[outcomes.scene_of]
    rows = []
    for number, group in enumerate(groups):
        cells = [group]
        for strategy in range(len(outcomes.strategies)):
            chosen = (place == number) & (outcomes.strategy_of == strategy)
            flags = (outcomes.right, outcomes.trusted, outcomes.false)
            counts = " / ".join(str(int((chosen & flag).sum())) for flag in flags)
            if not outcomes.told[chosen].all():  # of all seeds of a scene or of none
                counts = f"- / {int((chosen & outcomes.trusted).sum())} / -"
            cells.append(f"{counts} of {int(chosen.sum())}" if chosen.any() else "")
        rows.append(cells)
    return Grid("Scenes", ["scene", *outcomes.strategies], rows, "right / trusted / false of n cells.")


def power_grid(outcomes: Outcomes) -> Grid:
    """How many cells a plan like this one would need to see a difference of 5 points."""
    rows = []
    for ours, theirs in pairs(outcomes):
        for name in ("right", "trusted"):
            found = paired(measure(outcomes, ours, name), measure(outcomes, theirs, name))
            needed = cells_needed(found)
            if found.n:
                rows.append(
                    [
                        f"{outcomes.strategies[ours]} − {outcomes.strategies[theirs]}",
                        name,
                        str(found.n),
                        "-" if needed is None else f"{100 * found.standard_error:.1f}",
                        "not known" if needed is None else str(needed),
                        "-" if needed is None else str(math.ceil(needed * found.scenes / found.n)),
                    ]
                )
    return Grid(
        "Power",
        ["strategies", "measure", "pairs here", "standard error, points", "pairs needed", "scenes needed"],
        rows,
        "To see a difference of 5 points in four of five experiments, at the 5 % level; new scenes with as"
        " many seeds each as here.",
    )


def scores_grid(outcomes: Outcomes) -> Grid:
    """How far scores can be trusted: wrong estimates that pass a threshold, and right ones that do not."""
    rows = []
    found = outcomes.status == "estimated"
    for number, strategy in enumerate(outcomes.strategies):
        mine = found & outcomes.told & (outcomes.strategy_of == number)
        right, wrong = mine & outcomes.right, mine & ~outcomes.right
        for least in SCORES:
            passing = outcomes.columns["score"] >= least
            false, n = int((wrong & passing).sum()), int((mine & passing).sum())
            low, high = exact_interval(false, n)
            rows.append(
                [
                    strategy,
                    f"{least:g}",
                    f"{int((right & passing).sum())} of {int(right.sum())}",
                    f"{false} of {int(wrong.sum())}",
                    f"{100 * false / max(1, n):.2f} ({100 * low:.2f}–{100 * high:.2f})" if n else "-",
                ]
            )
        squares = outcomes.columns["normalised_error_squared"][right]
        if np.isfinite(squares).any():
            middle, most = np.nanmedian(squares), np.nanquantile(squares, 0.9)
            rows.append([strategy, "error² by covariance", f"median {middle:.2f}, 90 % {most:.2f}", "", ""])
    return Grid(
        "Scores",
        ["strategy", "score at least", "right that pass", "wrong that pass", "wrong among these, %"],
        rows,
        "With exact intervals. The squared error in units of the covariance, of right estimates: median 5.35"
        " and 90 % 10.6 where it is honest.",
    )


def pairs(outcomes: Outcomes) -> Iterable[tuple[int, int]]:
    """All pairs of strategies, the plan's first one first."""
    return combinations(range(len(outcomes.strategies)), 2)


def share_words(matrix: Floats, estimate: IntervalEstimate) -> str:
    """A share in percent with both intervals."""
    if estimate.n == 0:
        return "-"
    successes = int(np.nansum(matrix))
    low, high = exact_interval(successes, estimate.n)
    both = "" if math.isnan(estimate.low) else f" [{100 * estimate.low:.0f}–{100 * estimate.high:.0f}]"
    return f"{100 * estimate.value:.1f}{both} ({100 * low:.0f}–{100 * high:.0f})"


def mean_words(estimate: IntervalEstimate) -> str:
    """A mean with its interval."""
    if estimate.n == 0:
        return "-"
    if math.isnan(estimate.low):
        return number_words(estimate.value)
    return f"{number_words(estimate.value)} [{number_words(estimate.low)}–{number_words(estimate.high)}]"


def number_words(value: float) -> str:
    """Two decimals, and three digits of what is too small for them."""
    return f"{value:.2f}" if abs(value) >= 0.1 or value == 0.0 else f"{value:.3g}"


def difference_words(found: IntervalEstimate, share: bool) -> str:
    """A difference with its interval; shares in percentage points."""
    ends = [found.value, found.low, found.high]
    if share:
        value, low, high = (f"{100.0 * end:+.1f}" for end in ends)
    else:
        value, low, high = (("+" if end >= 0 else "") + number_words(end) for end in ends)
    return value if math.isnan(found.low) else f"{value} [{low}, {high}]"


def verdict(found: IntervalEstimate) -> str:
    """Whether a difference is one."""
    if math.isnan(found.low):
        return "too few scenes"
    if not found.differs_from_zero:
        return "no difference shown"
    return "more" if found.low > 0.0 else "less"


def head(description: dict[str, Any], rows: int) -> str:
    """What every table says: of which plan, how many rows, and which code computed them."""
    missing = description["cells"] - rows
    left = f", {missing} cells have none yet" if missing > 0 else ""
    settings = description["settings"]
    threshold = "default" if settings["threshold"] is None else f"{settings['threshold']:g} px"
    return (
        f"Plan {description['plan']} (cells: {settings['kind']}): n = {rows} rows{left}; at most"
        f" {settings['max_iterations']} images, threshold {threshold}; code {description['version']}."
    )
