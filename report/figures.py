"""Which plots a session gets, with their legends and what they say to those who cannot see them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from bridge.result_file import HoldRecord, Result, StepRecord
from report.plots import Rule, Series, bar_chart, line_chart
from report.uncertainty import uncertainty_of
from report.verdict import HOLD_PASSED, RIGHT_DEG, RIGHT_FRACTION
from report.words import percent, seconds

PARTS = ("capture", "edges", "linking", "matching", "refinement", "controller", "bridge")
REST = "other"
REST_STYLE = 8
REST_FROM = 0.005  # a rest below this share of the total is rounding


@dataclass(frozen=True)
class Legend:
    """One entry: kind "line", "dashed", "kept", "discarded", "bar" or "hollow", colour number, text."""

    kind: str
    style: int
    text: str


@dataclass(frozen=True)
class Figure:
    """A plot with its title and legend."""

    title: str
    svg: str
    legend: tuple[Legend, ...]


@dataclass(frozen=True)
class Part:
    """A part of the session's time; `fraction` is what `share` says."""

    name: str
    time: str
    share: str
    style: int
    fraction: float


@dataclass(frozen=True)
class TimeFigure:
    """Where the time went."""

    description: str
    parts: tuple[Part, ...]
    total: str


def was_kept(step: StepRecord) -> bool:
    """Whether the step's image stayed in the set."""
    return step.decision != "discard"


def session_figures(result: Result) -> list[Figure]:
    """Error, certainty, size of the set and, where the truth is known, the true error over the iterations."""
    steps = result.steps
    if not steps:
        return []
    figures = [_error_figure(result), _certainty_figure(steps), _set_figure(steps), _truth_figure(steps)]
    return [figure for figure in figures if figure is not None]


def _error_figure(result: Result) -> Figure | None:
    steps = result.steps
    marks = ["kept" if was_kept(step) else "discarded" for step in steps]
    rms = [step.rms_px for step in steps]
    merit = [step.merit if step.pose is not None else None for step in steps]
    series, legend = [], []
    if any(value is not None for value in merit):
        series.append(Series("merit", 1, merit, marks))
        legend.append(Legend("line", 1, "merit: what decides, the doubt that the pose is right"))
    if any(value is not None for value in rms):
        plain_marks = marks if not series else ["dot"] * len(marks)
        series.append(Series("RMS error", 2, rms, plain_marks, dashed=bool(series)))
        legend.append(Legend("dashed" if len(series) > 1 else "line", 2, "RMS error"))
    if not series:
        return None
    legend += [Legend("kept", 0, "image kept"), Legend("discarded", 0, "image discarded")]
    rule = Rule(result.threshold_px, f"threshold {result.threshold_px:g} px") if result.threshold_px else None
    last = next((value for value in reversed(series[0].values) if value is not None), None)
    description = f"{series[0].label} over {len(steps)} iterations, ending at {last:.2f} px" if last else ""
    svg = line_chart(_numbers(steps), series, ("iteration", "px"), description, rule)
    return Figure("Error over the iterations", svg, tuple(legend))


def _certainty_figure(steps: Sequence[StepRecord]) -> Figure | None:
    values = [100 * step.uncertainty if step.uncertainty is not None else None for step in steps]
    if all(value is None for value in values):
        return None
    marks = ["kept" if was_kept(step) else "discarded" for step in steps]
    series = [Series("uncertainty", 4, values, marks)]
    description = f"Standard deviation of the position over {len(steps)} iterations"
    svg = line_chart(_numbers(steps), series, ("iteration", "% of range"), description)
    legend = (Legend("line", 4, "largest standard deviation of the pose: 1 is 1 % of the range or 1°"),)
    return Figure("Certainty over the iterations", svg, legend)


def _set_figure(steps: Sequence[StepRecord]) -> Figure | None:
    if all(step.set_size is None for step in steps):
        return None
    kept = [was_kept(step) for step in steps]
    description = f"Size of the image set over {len(steps)} iterations, {sum(kept)} images kept"
    svg = bar_chart([step.set_size for step in steps], kept, description)
    legend = (Legend("bar", 3, "image kept"), Legend("hollow", 3, "image discarded"))
    return Figure("Images in the set", svg, legend)


def _truth_figure(steps: Sequence[StepRecord]) -> Figure | None:
    if all(step.error is None for step in steps):
        return None
    dots = ["kept" if was_kept(step) else "discarded" for step in steps]
    turn = [step.error.rotation_deg if step.error else None for step in steps]
    shift = [100 * step.error.translation_fraction_of_range if step.error else None for step in steps]
    series = [Series("rotation", 4, turn, dots), Series("position", 5, shift, dots)]
    rule = Rule(RIGHT_DEG, f"right: under {RIGHT_DEG:g}° and {100 * RIGHT_FRACTION:g} %")
    titles = ("iteration", "° and % of range")
    svg = line_chart(_numbers(steps), series, titles, "Error against the true pose by iteration", rule)
    legend = (Legend("line", 4, "rotation, °"), Legend("line", 5, "position, % of range"))
    return Figure("Error against the true pose", svg, legend)


def approach_figure(holds: Sequence[HoldRecord]) -> Figure | None:
    """Uncertainty of the position against the range, over the hold points of an approach."""
    deviation: list[float | None] = []
    for hold in holds:
        known = uncertainty_of(hold.pose, hold.covariance)
        if known is not None:
            deviation.append(1000 * known.worst_position_m)
        elif hold.uncertainty is not None:
            deviation.append(1000 * hold.uncertainty * hold.range_m)
        else:
            deviation.append(None)
    off = [1000 * hold.error.translation_m if hold.error else None for hold in holds]
    marks = ["kept" if hold.status in HOLD_PASSED else "discarded" for hold in holds]
    series, legend = [], []
    if any(value is not None for value in deviation):
        series.append(Series("uncertainty", 1, deviation, marks))
        legend.append(Legend("line", 1, "standard deviation of the position"))
    if any(value is not None for value in off):
        series.append(Series("true error", 5, off, marks, dashed=True))
        legend.append(Legend("dashed", 5, "error against the true position"))
    if not series:
        return None
    legend += [Legend("kept", 0, "passed"), Legend("discarded", 0, "not passed")]
    labels = [f"{hold.range_m:.2g}" for hold in holds]
    description = f"Position uncertainty at {len(holds)} hold points from {labels[0]} m to {labels[-1]} m"
    ranges = [hold.range_m for hold in holds]
    svg = line_chart(labels, series, ("range, m", "mm"), description, x_values=ranges)
    return Figure("Uncertainty on the way in", svg, tuple(legend))


def time_figure(times: Mapping[str, float | None]) -> TimeFigure | None:
    """Where the time went, part by part; what no part accounts for is `other`."""
    known = {name: value for name, value in times.items() if value is not None and value >= 0}
    order = [name for name in PARTS if name in known]
    order += [name for name in known if name not in PARTS and name != "total"]
    parts = [(name, known[name]) for name in order]
    spent = sum(value for _, value in parts)
    total = known.get("total", spent)
    if total <= 0:
        return None
    if total - spent > REST_FROM * total:
        parts.append((REST, total - spent))
    whole = max(total, spent)
    description = "Time: " + ", ".join(f"{name} {seconds(value)}" for name, value in parts)
    rows = tuple(
        Part(
            name,
            seconds(value),
            percent(value / whole),
            PARTS.index(name) + 1 if name in PARTS else REST_STYLE,
            value / whole,
        )
        for name, value in parts
    )
    return TimeFigure(description, rows, seconds(total))


def _numbers(steps: Sequence[StepRecord]) -> list[str]:
    return [str(step.iteration or number + 1) for number, step in enumerate(steps)]
