"""Pictures of a comparison: success with intervals, images to trust, errors, paired differences, scenes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.comparison import SHARES, measure, pairs
from experiments.outcomes import Outcomes
from experiments.statistics import paired, resampled
from numerics.arrays import Floats

# Okabe and Ito
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#f0e442")
FORMATS = ("png", "svg")
MOST_SCENES = 60  # rows of a picture of scenes


def draw_all(outcomes: Outcomes, caption: str, folder: Path) -> list[str]:
    """Draw every picture as PNG and SVG; their names without ending."""
    names = []
    for name, (draw, size) in PICTURES.items():
        figure = Figure(figsize=size(outcomes), layout="constrained")
        draw(outcomes, figure)
        figure.supxlabel(caption, fontsize=7, color="0.4")
        for ending in FORMATS:
            figure.savefig(folder / f"{name}.{ending}", dpi=110)
        names.append(name)
    return names


def colour(number: int) -> str:
    """Of a strategy."""
    return COLOURS[number % len(COLOURS)]


def success(outcomes: Outcomes, figure: Figure) -> None:
    """Shares with intervals, strategies side by side."""
    axes = figure.subplots()
    width = 0.8 / len(outcomes.strategies)
    for number, strategy in enumerate(outcomes.strategies):
        found = [resampled(measure(outcomes, number, name)) for name in SHARES]
        places = np.arange(len(SHARES)) + (number - (len(outcomes.strategies) - 1) / 2) * width
        values = 100 * np.array([estimate.value for estimate in found])
        low, high = (100 * np.array([getattr(e, end) for e in found]) for end in ("low", "high"))
        errors = np.nan_to_num(np.abs(np.stack([values - low, high - values])))
        axes.bar(places, values, 0.9 * width, label=strategy, color=colour(number))
        axes.errorbar(places, values, errors, fmt="none", ecolor="0.25", capsize=2, lw=1)
    axes.set_xticks(range(len(SHARES)), SHARES)
    axes.set(ylabel="% of cells", ylim=(0, 105))
    columns = min(4, len(outcomes.strategies))
    axes.legend(frameon=False, ncols=columns, loc="lower center", bbox_to_anchor=(0.5, 1.0))


def trust_by_images(outcomes: Outcomes, figure: Figure) -> None:
    """Share of cells that are trusted and right after so many images."""
    axes = figure.subplots()
    most = int(np.nanmax(outcomes.columns["images"], initial=1))
    for number, strategy in enumerate(outcomes.strategies):
        mine = outcomes.told & (outcomes.strategy_of == number)
        good = mine & outcomes.trusted & outcomes.right
        counts = [float((good & (outcomes.columns["images"] <= i)).sum()) for i in range(most + 1)]
        axes.step(range(most + 1), 100 * np.array(counts) / max(1, mine.sum()), where="post",
                  label=strategy, color=colour(number))  # fmt: skip
    axes.set(xlabel="images", ylabel="% of cells trusted, and right", xlim=(0, most), ylim=(0, 102))
    axes.legend(frameon=False)


def errors(outcomes: Outcomes, figure: Figure) -> None:
    """Cumulative shares of errors; cells without a pose never come."""
    panels = (("rotation_deg", 1.0, "rotation error, degrees", (1.0, 0.2)),
              ("translation_fraction", 100.0, "translation error, % of range", (1.0, 0.2)))  # fmt: skip
    for axes, (column, scale, label, limits) in zip(figure.subplots(1, 2, sharey=True), panels, strict=True):
        for number, strategy in enumerate(outcomes.strategies):
            mine = scale * outcomes.columns[column][outcomes.told & (outcomes.strategy_of == number)]
            known = np.sort(mine[np.isfinite(mine)])
            axes.step(known, 100 * np.arange(1, len(known) + 1) / max(1, len(mine)), where="post",
                      label=strategy, color=colour(number))  # fmt: skip
        for limit in limits:
            axes.axvline(limit, color="0.7", lw=0.8, ls=":")
        axes.set(xscale="log", xlabel=label, ylim=(0, 102))
    figure.axes[0].set_ylabel("% of cells under it")
    figure.axes[0].legend(frameon=False)


def differences(outcomes: Outcomes, figure: Figure) -> None:
    """Paired differences of right and trusted with their intervals; bold where they exclude zero."""
    for axes, name in zip(figure.subplots(1, 2, sharey=True), ("right", "trusted"), strict=True):
        labels = []
        for place, (ours, theirs) in enumerate(pairs(outcomes)):
            found = paired(measure(outcomes, ours, name), measure(outcomes, theirs, name))
            labels.append(f"{outcomes.strategies[ours]} − {outcomes.strategies[theirs]}")
            shown = found.differs_from_zero
            if found.n:
                axes.plot(100 * found.value, place, "o", color="black" if shown else "0.6", ms=4)
            if np.isfinite(found.low):
                axes.plot(100 * np.array([found.low, found.high]), [place, place], lw=2.5 if shown else 1.2,
                          color="black" if shown else "0.6")  # fmt: skip
        axes.axvline(0.0, color="0.7", lw=0.8)
        axes.set_yticks(range(len(labels)), labels)
        axes.set(xlabel=f"{name}, percentage points")
    figure.axes[0].invert_yaxis()


def scenes(outcomes: Outcomes, figure: Figure) -> None:
    """Share of right poses by scene and strategy."""
    axes: Axes = figure.subplots()
    names, shares = shares_by_group(outcomes)
    axes.imshow(shares, cmap="RdYlGn", vmin=0, vmax=1, aspect="auto")
    for (row, column), share in np.ndenumerate(shares):
        if np.isfinite(share):
            axes.text(column, row, f"{100 * share:.0f}", ha="center", va="center", fontsize=7)
    axes.set_xticks(range(len(outcomes.strategies)), outcomes.strategies, fontsize=8)
    axes.set_yticks(range(len(names)), names, fontsize=7)
    axes.xaxis.tick_top()


def shares_by_group(outcomes: Outcomes) -> tuple[list[str], Floats]:
    """Names of scenes without their poses, worst first, and shares of right poses (groups, strategies)."""
    groups = list(dict.fromkeys(outcomes.groups))
    known = {group: number for number, group in enumerate(groups)}
    place = np.array([known[group] for group in outcomes.groups])[outcomes.scene_of]
    index = (place * len(outcomes.strategies) + outcomes.strategy_of)[outcomes.told]
    size = len(groups) * len(outcomes.strategies)
    with np.errstate(invalid="ignore"):
        flat = np.bincount(index, outcomes.right[outcomes.told], size) / np.bincount(index, minlength=size)
    shares = flat.reshape(len(groups), -1)
    order = np.argsort(np.nan_to_num(shares).mean(axis=1), kind="stable")[:MOST_SCENES]
    return [groups[number] for number in order], shares[order]


Draw = Callable[[Outcomes, Figure], None]
PICTURES: dict[str, tuple[Draw, Callable[[Outcomes], tuple[float, float]]]] = {
    "success": (success, lambda _: (7.2, 3.6)),
    "images-to-trust": (trust_by_images, lambda _: (5.6, 3.6)),
    "errors": (errors, lambda _: (8.4, 3.4)),
    "differences": (differences, lambda o: (8.4, 1.4 + 0.24 * sum(1 for _ in pairs(o)))),
    "scenes": (scenes, lambda o: (2.4 + 1.1 * len(o.strategies), 1.0 + 0.2 * len(shares_by_group(o)[0]))),
}
