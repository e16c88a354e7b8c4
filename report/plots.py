"""The page's plots as hand-written SVG, coloured by the page's style sheet."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from report.axis import Axis, fitted
from report.words import percent, seconds, significant

WIDTH, HEIGHT = 480, 250
LEFT, RIGHT, TOP, BOTTOM = 52, 14, 14, 40
MOST_X_LABELS = 12


@dataclass(frozen=True)
class Series:
    """A line of a chart.

    Attributes
    ----------
    label, style : legend text; number of the colour in the style sheet.
    values : one per x place; None leaves a gap.
    marks : one of "kept", "discarded", "dot" per x place.
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


def line_chart(
    x_labels: Sequence[str],
    series: Sequence[Series],
    x_title: str,
    y_title: str,
    description: str,
    rule: Rule | None = None,
    x_values: Sequence[float] | None = None,
) -> str:
    """A chart of lines over numbered steps or over the given x values (first one at the left)."""
    values = [value for one in series for value in one.values if value is not None]
    if rule is not None:
        values.append(rule.value)
    y = fitted(values, HEIGHT - BOTTOM, TOP)
    places = _places(len(x_labels), x_values)
    parts = [_grid(y), _x_axis(places, x_labels, x_title), _y_title(y_title, y.log)]
    if rule is not None:
        at = y.at(rule.value)
        parts.append(f'<line class="rule" x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{at:.1f}" y2="{at:.1f}"/>')
    parts += [_line(one, places, y) for one in series]
    parts += [_marks(one, places, y) for one in series]
    if rule is not None:  # over the lines, so that it can be read
        above = at - 5 if at > TOP + 16 else at + 14
        parts.append(f'<text class="rule-text" x="{LEFT + 4}" y="{above:.1f}">{escape(rule.label)}</text>')
    return _figure(parts, description, HEIGHT)


def bar_chart(values: Sequence[int | None], kept: Sequence[bool], description: str) -> str:
    """Size of the image set after each iteration; a discarded image leaves a hollow bar."""
    y = fitted([float(value or 0) for value in values], HEIGHT - BOTTOM, TOP, log=False)
    places = _places(len(values), None)
    wide = min(34.0, 0.62 * (WIDTH - LEFT - RIGHT) / max(1, len(values)))
    parts = [
        _grid(y),
        _x_axis(places, _numbers(len(values)), "iteration"),
        _y_title("images in the set", False),
    ]
    for place, value, keep in zip(places, values, kept, strict=True):
        if value is None:
            continue
        top = y.at(value)
        kind = "bar kept" if keep else "bar discarded"
        parts.append(
            f'<rect class="{kind}" x="{place - wide / 2:.1f}" y="{top:.1f}" width="{wide:.1f}" '
            f'height="{HEIGHT - BOTTOM - top:.1f}" rx="2"/>'
        )
        if not keep:
            parts.append(_mark("discarded", 3, place, top - 9 if top > TOP + 16 else top + 11))
    return _figure(parts, description, HEIGHT)


def time_bar(parts: Sequence[tuple[str, float]], styles: Sequence[int], description: str) -> str:
    """One bar whose stretches are the parts' shares of the whole."""
    total = sum(value for _, value in parts) or 1.0
    out, place = [], 0.0
    for style, (name, value) in zip(styles, parts, strict=True):
        wide = 1000 * value / total
        title = f"{name}: {seconds(value)}, {percent(value / total)}"
        out.append(
            f'<rect class="fill{style}" x="{place:.2f}" y="0" width="{wide:.2f}" height="36">'
            f"<title>{escape(title)}</title></rect>"
        )
        place += wide
    body = "".join(out)
    return (
        f'<svg class="timebar" viewBox="0 0 1000 36" preserveAspectRatio="none" role="img" '
        f'aria-label="{escape(description)}">{body}</svg>'
    )


def _numbers(count: int) -> list[str]:
    return [str(number + 1) for number in range(count)]


def _places(count: int, x_values: Sequence[float] | None) -> list[float]:
    inner_left, inner_right = LEFT + 18.0, WIDTH - RIGHT - 18.0
    if x_values is not None and len(set(x_values)) > 1:
        axis = Axis(x_values[0], x_values[-1], inner_left, inner_right)
        if axis.low != axis.high:
            return [axis.at(value) for value in x_values]
    if count == 1:
        return [(inner_left + inner_right) / 2]
    return [inner_left + number * (inner_right - inner_left) / (count - 1) for number in range(count)]


def _grid(y: Axis) -> str:
    out = []
    for tick in y.ticks():
        at = y.at(tick)
        out.append(f'<line class="grid" x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{at:.1f}" y2="{at:.1f}"/>')
        out.append(f'<text class="tick y" x="{LEFT - 7}" y="{at + 4:.1f}">{_number(tick)}</text>')
    return "".join(out)


def _number(value: float) -> str:
    return significant(value, 1) if 0 < abs(value) < 1 and value == float(f"{value:.0e}") else f"{value:g}"


def _x_axis(places: Sequence[float], labels: Sequence[str], title: str) -> str:
    base = HEIGHT - BOTTOM
    out = [f'<line class="axis" x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{base}" y2="{base}"/>']
    every = -(-len(places) // MOST_X_LABELS) or 1
    for number, (place, label) in enumerate(zip(places, labels, strict=True)):
        if number % every == 0:
            out.append(f'<text class="tick" x="{place:.1f}" y="{base + 17}">{escape(label)}</text>')
    middle = (LEFT + WIDTH - RIGHT) / 2
    out.append(f'<text class="title" x="{middle}" y="{HEIGHT - 5}">{escape(title)}</text>')
    return "".join(out)


def _y_title(title: str, log: bool) -> str:
    text = escape(title + (", log" if log else ""))
    middle = (TOP + HEIGHT - BOTTOM) / 2
    return f'<text class="title" transform="rotate(-90)" x="{-middle}" y="13">{text}</text>'


def _line(series: Series, places: Sequence[float], y: Axis) -> str:
    commands, pen = [], "M"
    for place, value in zip(places, series.values, strict=True):
        if value is None:
            pen = "M"
            continue
        commands.append(f"{pen}{place:.1f} {y.at(value):.1f}")
        pen = "L"
    dash = " dashed" if series.dashed else ""
    return f'<path class="line stroke{series.style}{dash}" d="{"".join(commands)}"/>' if commands else ""


def _marks(series: Series, places: Sequence[float], y: Axis) -> str:
    points = zip(places, series.values, series.marks, strict=True)
    return "".join(
        _mark(mark, series.style, x, y.at(value)) for x, value, mark in points if value is not None
    )


def _mark(kind: str, style: int, x: float, y: float) -> str:
    if kind == "discarded":
        arms = f"M{x - 4.5:.1f} {y - 4.5:.1f}l9 9m0 -9l-9 9"
        return f'<path class="under" d="{arms}"/><path class="cross stroke{style}" d="{arms}"/>'
    radius = 4.5 if kind == "kept" else 3
    return f'<circle class="mark fill{style}" cx="{x:.1f}" cy="{y:.1f}" r="{radius}"/>'


def _figure(parts: Sequence[str], description: str, height: int) -> str:
    body = "".join(parts)
    return (
        f'<svg class="plot" viewBox="0 0 {WIDTH} {height}" role="img" aria-label="{escape(description)}">'
        f"{body}</svg>"
    )
