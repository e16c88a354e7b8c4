"""Plots and words of the page."""

import math
import xml.etree.ElementTree as ET

import pytest

from report import words
from report.figures import time_figure
from report.plots import Rule, Series, bar_chart, line_chart
from report.records import SettingsRecord

SVG = ""  # no namespace: the page is HTML
LABELS = ["1", "2", "3"]


def texts(chart: str) -> list[str]:
    return [part.text or "" for part in ET.fromstring(chart).iter(f"{SVG}text")]


def test_the_line_chart_is_sound_svg_with_a_mark_per_value() -> None:
    series = Series("merit", 1, [4.0, None, 1.0], ["kept", "kept", "discarded"])
    chart = line_chart(LABELS, [series], ("iteration", "px"), "a <chart>", Rule(2.0, "threshold"))
    assert ET.fromstring(chart).attrib["aria-label"] == "a <chart>"
    marks = [part for part in ET.fromstring(chart).iter(f"{SVG}use")]
    assert len(marks) == 2
    assert {"iteration", "px", "threshold", *LABELS} <= set(texts(chart))


def test_colours_are_the_style_sheets() -> None:
    series = Series("merit", 4, [4.0, 2.0, 1.0], ["kept", "kept", "discarded"])
    chart = line_chart(LABELS, [series], ("iteration", "px"), "chart")
    assert "var(--c4)" in chart and "var(--soft)" in chart
    assert "#fe0" not in chart
    assert "<style" not in chart  # it would be the whole page's


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


def test_a_discarded_image_leaves_a_hollow_bar() -> None:
    chart = bar_chart([1, None, 1], [True, True, False], "sizes")
    assert chart.count("fill: var(--c3)") == 2  # one has no height
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
        (words.seconds(0.0123), "12 ms"),
        (words.seconds(75), "1 min 15 s"),
        (words.shutter(0.0041667), "1/240 s"),
        (words.shutter(0.5), "0.50 s"),
        (words.aperture(2.8), "f/2.8"),
        (words.significant(math.inf), "∞"),
        (words.count(1, "image"), "1 image"),
        (words.settings_words(SettingsRecord([0, 2]), []), "light 1 off, light 2 2"),
    ],
)
def test_numbers_in_words(text: str, expected: str) -> None:
    assert text == expected
