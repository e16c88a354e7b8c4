"""Plots and words of the page."""

import math
import re
import xml.etree.ElementTree as ET
from itertools import pairwise

import pytest

from report import words
from report.figures import time_figure
from report.plots import Rule, Series, bar_chart, line_chart, scale_of

SVG = ""  # no namespace: the page is HTML
LABELS = ["1", "2", "3"]


def texts(chart: str) -> list[str]:
    return [part.text or "" for part in ET.fromstring(chart).iter(f"{SVG}text")]


def labels_of(chart: ET.Element, anchor: str) -> list[ET.Element]:
    """Texts that end at their place (of the y axis), or have it in the middle (of the x axis)."""
    return [part for part in chart.iter("text") if part.get("text-anchor") == anchor]


def test_the_line_chart_is_sound_svg_with_a_mark_per_value() -> None:
    series = Series("merit", 1, [4.0, None, 1.0], ["kept", "kept", "discarded"])
    chart = line_chart(LABELS, [series], ("iteration", "px"), "a <chart>", Rule(2.0, "threshold"))
    assert ET.fromstring(chart).attrib["aria-label"] == "a <chart>"
    marks = [part.tag for part in ET.fromstring(chart) if part.get("class") == "mark"]
    assert marks == ["circle", "path"]
    assert {"iteration", "px", "threshold", *LABELS} <= set(texts(chart))


def test_colours_are_the_style_sheets() -> None:
    series = Series("merit", 4, [4.0, 2.0, 1.0], ["kept", "kept", "discarded"])
    chart = line_chart(LABELS, [series], ("iteration", "px"), "chart")
    assert "stroke:var(--c4)" in chart
    assert "<style" not in chart and "#" not in chart


@pytest.mark.parametrize(
    ("values", "log"),
    [([0.1, 10.0], True), ([1.0, 3.0], False), ([0.0, 300.0], False), ([5.0], False), ([1e-5, 3e4], True)],
)
def test_wide_spreads_are_logarithmic(values: list[float], log: bool) -> None:
    labels = [str(number) for number in range(len(values))]
    chart = line_chart(labels, [Series("merit", 1, values, ["dot"] * len(values))], ("x", "px"), "chart")
    assert ("px, log" in texts(chart)) == log
    ticks = [text for text in texts(chart) if text[0].isdigit() and text not in labels]
    assert 2 <= len(ticks) <= 12


def test_ranges_run_towards_the_target() -> None:
    series = Series("uncertainty", 1, [4.0, 2.0, 1.0], ["kept"] * 3)
    chart = line_chart(["1.5", "0.8", "0.3"], [series], ("range, m", "mm"), "way", x_values=[1.5, 0.8, 0.3])
    places = {
        part.text: float(part.attrib["x"])
        for part in ET.fromstring(chart).iter(f"{SVG}text")
        if part.text in ("1.5", "0.8", "0.3")
    }
    assert places["1.5"] < places["0.8"] < places["0.3"]


def test_a_line_is_broken_where_it_has_no_value() -> None:
    series = Series("merit", 1, [4.0, None, 2.0, 1.0], ["dot"] * 4)
    chart = line_chart([*LABELS, "4"], [series], ("iteration", "px"), "chart")
    (line,) = [part.attrib["d"] for part in ET.fromstring(chart) if part.get("class") == "line"]
    assert [line.count(letter) for letter in "ML"] == [2, 1]


def test_a_line_goes_through_its_marks_and_ticks_stand_where_their_values_are() -> None:
    series = Series("merit", 1, [4.0, 2.0, 0.0], ["dot"] * 3)
    chart = ET.fromstring(line_chart(LABELS, [series], ("iteration", "px"), "chart"))
    ys = [float(part.attrib["cy"]) for part in chart if part.get("class") == "mark"]
    assert ys[1] - ys[0] == pytest.approx(ys[2] - ys[1], abs=0.11) and ys[0] < ys[2]
    (line,) = [part.attrib["d"] for part in chart if part.get("class") == "line"]
    assert [float(y) for y in re.findall(r"[ML][\d.]+ ([\d.]+)", line)] == ys
    ticks = {part.text: float(part.attrib["y"]) - 4.5 for part in labels_of(chart, "end")}
    assert [ticks["4"], ticks["0"]] == pytest.approx([ys[0], ys[2]], abs=0.11)


@pytest.mark.parametrize(
    ("values", "ticks"),
    [
        ([1.0], [0, 0.25, 0.5, 0.75, 1.0]),
        ([0.0], [0, 0.2, 0.4, 0.6, 0.8, 1.0]),
        ([130.0], [0, 50, 100]),
        ([0.1, 10.0], [0.1, 0.2, 0.5, 1, 2, 5, 10]),
        ([0.001, 10.0], [0.001, 0.01, 0.1, 1, 10]),
        ([], [0, 0.25, 0.5, 0.75, 1.0]),
    ],
)
def test_ticks_are_round_numbers(values: list[float], ticks: list[float]) -> None:
    assert scale_of(values).ticks == pytest.approx(ticks)


def test_labels_of_near_places_leave_room_for_each_other() -> None:
    ranges = [1.5, 1.147, 0.877, 0.671, 0.513, 0.392, 0.3]
    labels = [f"{range_m:.2g}" for range_m in ranges]
    series = Series("uncertainty", 1, ranges, ["kept"] * 7)
    chart = ET.fromstring(line_chart(labels, [series], ("range, m", "mm"), "way", x_values=ranges))
    below = [part for part in labels_of(chart, "middle") if part.text in labels]
    places = [float(part.attrib["x"]) for part in below]
    assert [part.text for part in below][-1] == "0.3" and len(below) >= 5
    assert all(b - a > 24 for a, b in pairwise(places))


def test_a_discarded_image_leaves_a_hollow_bar() -> None:
    chart = bar_chart([1, None, 1], [True, True, False], "sizes")
    assert chart.count("fill:var(--c3)") == 2  # one has no height
    assert chart.count("stroke-dasharray") >= 1


def test_the_parts_of_the_time_add_up() -> None:
    figure = time_figure({"capture": 1.0, "edges": 2.0, "total": 4.0})
    assert figure is not None
    assert [(part.name, part.fraction) for part in figure.parts] == [
        ("capture", 0.25), ("edges", 0.5), ("other", 0.25),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (words.length(0.000118), "0.12 mm"),
        (words.length(0.62731, 4), "627.3 mm"),
        (words.length(1.5), "1.50 m"),
        (words.length(2.3e-6), "2.3 µm"),
        (words.length(None), "–"),
        (words.angle(0.0312), "0.031°"),
        (words.percent(0.000651), "0.065 %"),
        (words.pixels(0.414), "0.41 px"),
        (words.pixels(0.0098), "0.0098 px"),
        (words.seconds(0.0123), "12 ms"),
        (words.seconds(75), "1 min 15 s"),
        (words.shutter(0.0041667), "1/240 s"),
        (words.shutter(0.5), "0.50 s"),
        (words.aperture(2.8), "f/2.8"),
        (words.significant(math.inf), "∞"),
    ],
)
def test_numbers_in_words(text: str, expected: str) -> None:
    assert text == expected
