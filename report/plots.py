"""The page's plots as SVG: text stays text, and the page's style sheet gives the colours.

Drawn here, not by matplotlib: the four plots of a session of 20 images take 0.02 s of processor time with all
that is loaded for them, and 0.34 s with matplotlib. A live page that opens beside its session takes 0.42 s in
all, and each session that ends writes a report.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape

WIDTH_PX, HEIGHT_PX = 480, 250
LEFT_PX, RIGHT_PX, TOP_PX, BOTTOM_PX = 68.0, 473.0, 8.0, 204.0  # of the plane that is drawn in
LOG_FROM = 15.0  # values that spread over more than this factor are drawn on a logarithmic scale
FEW_DECADES = 300.0  # a logarithmic scale over less than this factor has ticks at 1, 2 and 5
LOG_MARGIN = 1.35  # a logarithmic scale goes on by this factor beyond its values
MOST_TICKS = 5  # on a linear scale, beside zero
MOST_DECADES = 10  # with a tick each
MOST_X_LABELS = 12
DIGIT_PX = 9.5  # room for a figure of a label on a phone, where text is larger; gaps between labels included
ASIDE = 0.06  # of the plane's width, from the first place to its edge
BAR = 0.62  # of the room between two bars
MARK_PX = {"kept": 4.0, "discarded": 4.0, "dot": 2.5}  # half their size; what is discarded is a cross


@dataclass(frozen=True)
class Series:
    """A line of a chart.

    Attributes
    ----------
    label, style : legend text; number of the colour in the style sheet.
    values : one per x place; None leaves a gap.
    marks : one of `MARK_PX` per x place.
    """

    label: str
    style: int
    values: Sequence[float | None]
    marks: Sequence[str]
    dashed: bool = False


@dataclass(frozen=True)
class Rule:
    """A horizontal line with a text."""

    value: float
    label: str


@dataclass(frozen=True)
class Scale:
    """The y axis: from `low` at the bottom to `high` at the top, with its ticks."""

    low: float
    high: float
    ticks: tuple[float, ...]
    log: bool = False

    def place(self, value: float) -> float:
        """y of a value, px."""
        low, high, value = (math.log(v) if self.log else v for v in (self.low, self.high, value))
        return BOTTOM_PX - (value - low) / (high - low) * (BOTTOM_PX - TOP_PX)


def line_chart(
    x_labels: Sequence[str],
    series: Sequence[Series],
    titles: tuple[str, str],
    description: str,
    rule: Rule | None = None,
    x_values: Sequence[float] | None = None,
) -> str:
    """A chart of lines over numbered steps or over the given x values (first one at the left), as SVG.

    `titles` are those of the x and the y axis; `description` is for those who cannot see it.
    """
    values = [value for one in series for value in one.values if value is not None]
    scale = scale_of(values + ([rule.value] if rule is not None else []))
    places = _places(range(len(x_labels)) if x_values is None else x_values)
    every = -(-len(places) // MOST_X_LABELS) or 1
    parts = [
        *_axes(scale, _apart(list(zip(places, x_labels, strict=True))[::every]), titles),
        *(_line(one, places, scale) for one in series),
        *(_marks(one, places, scale) for one in series),
    ]
    if rule is not None:
        parts.append(_rule(rule, scale.place(rule.value)))
    return _svg(parts, description)


def bar_chart(values: Sequence[int | None], kept: Sequence[bool], description: str) -> str:
    """Size of the image set after each iteration, as SVG; a discarded image leaves a hollow bar."""
    top = max((value or 0 for value in values), default=1) or 1
    scale = Scale(0.0, 1.12 * top, _linear_ticks(0.0, 1.12 * top, 4, whole=True))
    room = (RIGHT_PX - LEFT_PX) / max(1, len(values))
    middles = [LEFT_PX + room * (number + 0.5) for number in range(len(values))]
    every = _step(len(values), MOST_X_LABELS, whole=True)
    labels = [(x, str(number)) for number, x in enumerate(middles, 1) if number % every == 0]
    parts = [*_axes(scale, labels, ("iteration", "images in the set"))]
    for x, value, keep in zip(middles, values, kept, strict=True):
        y = scale.place(value or 0)
        look = "fill:var(--c3)" if keep else "fill:none;stroke-dasharray:4.5 3"
        parts.append(
            f'<rect class="bar" x="{x - room * BAR / 2:.1f}" y="{y:.1f}" width="{room * BAR:.1f}"'
            f' height="{BOTTOM_PX - y:.1f}" style="{look};stroke:var(--c3);stroke-width:1.5"/>'
        )
        if value is not None and not keep:
            parts.append(_mark("discarded", 5, x, y))
    return _svg(parts, description)


def scale_of(values: Sequence[float]) -> Scale:
    """From zero, unless the values spread so far that only a logarithmic scale shows them all."""
    low, high = min(values, default=0.0), max(values, default=1.0)
    if low > 0 and high / low > LOG_FROM:
        ends = low / LOG_MARGIN, high * LOG_MARGIN
        return Scale(*ends, _log_ticks(*ends, high / low), log=True)
    ends = min(0.0, low), 1.08 * high if high > 0 else 1.0
    return Scale(*ends, _linear_ticks(*ends, MOST_TICKS))


def _log_ticks(low: float, high: float, spread: float) -> tuple[float, ...]:
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    decades = decades[:: -(-len(decades) // MOST_DECADES)]
    firsts = (1, 2, 5) if spread < FEW_DECADES else (1,)
    ticks = (first * 10.0**decade for decade in decades for first in firsts)
    return tuple(tick for tick in ticks if low <= tick <= high)


def _linear_ticks(low: float, high: float, most: int, whole: bool = False) -> tuple[float, ...]:
    step = _step(high - low, most, whole)
    return tuple(step * number for number in range(math.ceil(low / step), math.floor(high / step) + 1))


def _step(span: float, most: int, whole: bool) -> float:
    """The smallest of 1, 2, 2.5 and 5 times a power of ten of which no more than `most` make the span."""
    size = 10.0 ** math.floor(math.log10(span / most))
    steps = [size * first for first in ((1, 2, 5, 10) if whole else (1, 2, 2.5, 5, 10))]
    step = next((one for one in steps if one * most >= span * (1 - 1e-9)), steps[-1])
    return max(1.0, step) if whole else step


def _places(values: Sequence[float]) -> list[float]:
    """x of each place, px, the first at the left."""
    if not values:
        return []
    first, span = values[0], values[-1] - values[0]
    aside = ASIDE * (RIGHT_PX - LEFT_PX)
    return [
        LEFT_PX + aside + ((value - first) / span if span else 0.5) * (RIGHT_PX - LEFT_PX - 2 * aside)
        for value in values
    ]


def _apart(labels: Sequence[tuple[float, str]]) -> list[tuple[float, str]]:
    """Those labels that leave room for each other; the last one always."""
    kept: list[tuple[float, str]] = []
    for x, text in reversed(labels):
        if not kept or kept[-1][0] - x >= DIGIT_PX * (len(kept[-1][1]) + len(text)) / 2 + DIGIT_PX:
            kept.append((x, text))
    return kept[::-1]


def _axes(scale: Scale, labels: Iterable[tuple[float, str]], titles: tuple[str, str]) -> Iterable[str]:
    for tick in scale.ticks:
        y = scale.place(tick)
        yield f'<path class="grid" d="M{LEFT_PX:g} {y:.1f}H{RIGHT_PX:g}"/>'
        yield f'<text x="{LEFT_PX - 7:g}" y="{y + 4.5:.1f}" text-anchor="end">{round(tick, 12):g}</text>'
    yield f'<path class="base" d="M{LEFT_PX:g} {BOTTOM_PX:g}H{RIGHT_PX:g}"/>'
    for x, text in labels:
        yield f'<text x="{x:.1f}" y="{BOTTOM_PX + 17:g}" text-anchor="middle">{escape(text)}</text>'
    middle = (LEFT_PX + RIGHT_PX) / 2, (TOP_PX + BOTTOM_PX) / 2
    yield f'<text x="{middle[0]:g}" y="{HEIGHT_PX - 8}" text-anchor="middle">{escape(titles[0])}</text>'
    up = escape(titles[1]) + (", log" if scale.log else "")
    turn = f'transform="rotate(-90 12 {middle[1]:g})"'
    yield f'<text x="12" y="{middle[1]:g}" text-anchor="middle" {turn}>{up}</text>'


def _line(series: Series, places: Sequence[float], scale: Scale) -> str:
    """The line of a series, broken where it has no value."""
    path, gap = "", True
    for x, value in zip(places, series.values, strict=True):
        if value is not None:
            path += f"{'M' if gap else 'L'}{x:.1f} {scale.place(value):.1f}"
        gap = value is None
    look = "stroke-width:1.8;stroke-dasharray:5.4 3.6" if series.dashed else "stroke-width:2.2"
    return f'<path class="line" d="{path}" style="stroke:var(--c{series.style});{look}"/>'


def _marks(series: Series, places: Sequence[float], scale: Scale) -> str:
    found = zip(places, series.values, series.marks, strict=True)
    return "".join(
        _mark(kind, series.style, x, scale.place(value)) for x, value, kind in found if value is not None
    )


def _mark(kind: str, style: int, x: float, y: float) -> str:
    size = MARK_PX[kind]
    if kind == "discarded":
        wide = 2 * size
        cross = f"M{x - size:.1f} {y - size:.1f}l{wide:g} {wide:g}m0 {-wide:g}l{-wide:g} {wide:g}"
        return f'<path class="mark" d="{cross}" style="stroke:var(--c{style});stroke-width:2.4;fill:none"/>'
    look = f"fill:var(--c{style});stroke:var(--card);stroke-width:1.5"
    return f'<circle class="mark" cx="{x:.1f}" cy="{y:.1f}" r="{size:g}" style="{look}"/>'


def _rule(rule: Rule, y: float) -> str:
    return (
        f'<path class="rule" d="M{LEFT_PX:g} {y:.1f}H{RIGHT_PX:g}"/>'
        f'<text class="of-rule" x="{LEFT_PX + 4:g}" y="{y + 4.5:.1f}">{escape(rule.label)}</text>'
    )


def _svg(parts: Iterable[str], description: str) -> str:
    head = f'<svg class="plot" viewBox="0 0 {WIDTH_PX} {HEIGHT_PX}" role="img"'
    return f'{head} aria-label="{escape(description)}">{"".join(parts)}</svg>'
