"""The page's plots: matplotlib draws them as SVG, and the page's style sheet colours them."""

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from html import escape
from io import StringIO
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter, NullLocator, StrMethodFormatter

WIDTH_PX, HEIGHT_PX = 480, 250
POINTS_PER_INCH = 72  # of SVG: a figure of this many pixels to the inch has one pixel to the point
LOG_FROM = 15.0  # values that spread over more than this factor are drawn on a logarithmic scale
FEW_DECADES = 300.0  # a logarithmic scale over less than this factor has ticks at 1, 2 and 5
MOST_X_LABELS = 12
MARKS = {"kept": ("o", 8.0), "discarded": ("x", 8.0), "dot": ("o", 5.0)}

# What stands for a colour of the style sheet until the page is put together.
COLOURS = {name: f"#fe00{number:02x}" for number, name in enumerate(("ink", "soft", "grid", "card"))} | {
    f"c{number}": f"#fe01{number:02x}" for number in range(9)
}
STYLE: Any = {
    "svg.fonttype": "none",  # text stays text, in the page's font
    "font.size": 12.5,
    "axes.edgecolor": COLOURS["soft"],
    "axes.labelcolor": COLOURS["soft"],
    "axes.spines.left": False,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.axisbelow": True,
    "grid.color": COLOURS["grid"],
    "text.color": COLOURS["ink"],
    "xtick.color": COLOURS["soft"],
    "ytick.color": COLOURS["soft"],
    "xtick.major.size": 0,
    "ytick.major.size": 0,
    "lines.markeredgewidth": 2.4,
}


@dataclass(frozen=True)
class Series:
    """A line of a chart.

    Attributes
    ----------
    label, style : legend text; number of the colour in the style sheet.
    values : one per x place; None leaves a gap.
    marks : one of `MARKS` per x place.
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
    titles: tuple[str, str],
    description: str,
    rule: Rule | None = None,
    x_values: Sequence[float] | None = None,
) -> str:
    """A chart of lines over numbered steps or over the given x values (first one at the left), as SVG.

    `titles` are those of the x and the y axis; `description` is for those who cannot see it.
    """
    values = [value for one in series for value in one.values if value is not None]
    values += [rule.value] if rule is not None else []
    places = list(range(len(x_labels))) if x_values is None else list(x_values)
    with _figure(titles, description) as (axes, out):
        for one in series:
            _draw(axes, one, places)
        if rule is not None:
            axes.axhline(rule.value, color=COLOURS["ink"], linestyle=(0, (2, 4)), linewidth=1.4)
            paper = {"facecolor": COLOURS["card"], "edgecolor": "none", "pad": 1.5}
            above = axes.get_yaxis_transform()
            axes.text(0.01, rule.value, rule.label, transform=above, verticalalignment="center", bbox=paper)
        _scale(axes, values)
        if x_values is not None and x_values[0] > x_values[-1]:
            axes.invert_xaxis()
        every = -(-len(places) // MOST_X_LABELS) or 1
        axes.set_xticks(places[::every], x_labels[::every])
        axes.margins(x=0.06)
        _save(axes, out)
    return _svg(out.getvalue(), description)


def bar_chart(values: Sequence[int | None], kept: Sequence[bool], description: str) -> str:
    """Size of the image set after each iteration, as SVG; a discarded image leaves a hollow bar."""
    green = COLOURS["c3"]
    with _figure(("iteration", "images in the set"), description) as (axes, out):
        for place, (value, keep) in enumerate(zip(values, kept, strict=True), start=1):
            face = green if keep else "none"
            line = "solid" if keep else (0, (3, 2))
            axes.bar(place, value or 0, 0.62, facecolor=face, edgecolor=green, linestyle=line, linewidth=1.5)
            if value is not None and not keep:
                axes.plot(place, value, "x", color=COLOURS["c5"], markersize=8, zorder=3)
        axes.set_ylim(0, 1.12 * max((value or 0 for value in values), default=1) or 1)
        axes.yaxis.set_major_locator(MaxNLocator(4, integer=True))
        axes.xaxis.set_major_locator(MaxNLocator(MOST_X_LABELS, integer=True, min_n_ticks=1))
        axes.set_xlim(0.4, len(values) + 0.6)
        _save(axes, out)
    return _svg(out.getvalue(), description)


@contextmanager
def _figure(titles: tuple[str, str], description: str) -> Iterator[tuple[Axes, StringIO]]:
    with mpl.rc_context(STYLE | {"svg.hashsalt": description}):  # ids: each plot its own, always the same
        figure = Figure((WIDTH_PX / POINTS_PER_INCH, HEIGHT_PX / POINTS_PER_INCH))
        figure.subplots_adjust(left=0.125, right=0.985, bottom=0.185, top=0.97)
        FigureCanvasSVG(figure)
        figure.patch.set_visible(False)
        axes = figure.add_subplot()
        axes.patch.set_visible(False)
        axes.grid(axis="y")
        axes.set_xlabel(titles[0])
        axes.set_ylabel(titles[1])
        yield axes, StringIO()


def _draw(axes: Axes, series: Series, places: Sequence[float]) -> None:
    values = np.array([np.nan if value is None else value for value in series.values], dtype=float)
    colour = COLOURS[f"c{series.style}"]
    dashes = (0, (3, 2)) if series.dashed else "solid"
    axes.plot(places, values, color=colour, linestyle=dashes, linewidth=1.8 if series.dashed else 2.2)
    for kind, (marker, size) in MARKS.items():
        here = np.array([mark == kind for mark in series.marks]) & np.isfinite(values)
        at = np.array(places, dtype=float)[here]
        (drawn,) = axes.plot(at, values[here], marker, color=colour, markersize=size, zorder=3)
        if marker == "o":
            drawn.set(markeredgecolor=COLOURS["card"], markeredgewidth=1.5)


def _scale(axes: Axes, values: Sequence[float]) -> None:
    """From zero, unless the values spread so far that only a logarithmic scale shows them all."""
    low, high = min(values, default=0.0), max(values, default=1.0)
    if low > 0 and high / low > LOG_FROM:
        axes.set_yscale("log")
        axes.set_ylim(low / 1.35, high * 1.35)
        axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5) if high / low < FEW_DECADES else (1,)))
        axes.yaxis.set_minor_locator(NullLocator())
        axes.yaxis.set_minor_formatter(NullFormatter())
        axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
        axes.set_ylabel(f"{axes.get_ylabel()}, log")
    else:
        axes.set_ylim(min(0.0, low), 1.08 * high if high > 0 else 1.0)
        axes.yaxis.set_major_locator(MaxNLocator(5))


def _save(axes: Axes, out: StringIO) -> None:
    figure = axes.figure
    assert isinstance(figure, Figure)
    figure.savefig(out, format="svg", metadata={"Date": None}, transparent=True)


def _svg(text: str, description: str) -> str:
    """What matplotlib wrote as a part of the page: its size and colours are the style sheet's."""
    body = text[text.index("<defs") : text.rindex("</svg>")]
    body = re.sub(r"<(metadata|style).*?</\1>", "", body, flags=re.DOTALL)  # it styles a whole page
    body = re.sub(r" font-family: [^;]*;", "", body)
    body = re.sub(r' id="(?:figure|axes|patch|matplotlib|line2d|text|xtick|ytick)[\w.]*"', "", body)
    for name, colour in COLOURS.items():
        body = body.replace(colour, f"var(--{name})")
    head = f'<svg class="plot" viewBox="0 0 {WIDTH_PX} {HEIGHT_PX}" role="img"'
    return (
        f'{head} aria-label="{escape(description)}" xmlns:xlink="http://www.w3.org/1999/xlink">{body}</svg>'
    )
