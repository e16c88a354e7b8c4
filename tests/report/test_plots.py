"""Scales, ticks and words of the page."""

import math
import xml.etree.ElementTree as ET

import pytest

from report import words
from report.axis import fitted
from report.plots import Rule, Series, bar_chart, line_chart, time_bar
from report.records import SettingsRecord


@pytest.mark.parametrize("values", [[0.41, 8.2, 1.0], [1.0, 2.0], [0.0, 0.0], [5.0], [1e-5, 3e4], []])
def test_an_axis_holds_its_values_and_has_ticks(values: list[float]) -> None:
    axis = fitted(values, 200.0, 10.0)
    for value in values:
        assert 10.0 <= axis.at(value) <= 200.0
    ticks = axis.ticks()
    assert 2 <= len(ticks) <= 12
    assert all(10.0 - 1e-6 <= axis.at(tick) <= 200.0 + 1e-6 for tick in ticks)


def test_wide_spreads_are_logarithmic() -> None:
    assert fitted([0.1, 10.0], 0, 1).log
    assert not fitted([1.0, 3.0], 0, 1).log
    assert not fitted([0.0, 300.0], 0, 1).log
    axis = fitted([0.1, 10.0], 0.0, 100.0)
    assert axis.at(1.0) == pytest.approx(50.0)


def test_charts_are_sound_svg_with_a_mark_per_value() -> None:
    series = Series("merit", 1, [4.0, None, 1.0], ["kept", "kept", "discarded"])
    chart = line_chart(["1", "2", "3"], [series], "iteration", "px", "a <chart>", Rule(2.0, "threshold"))
    tree = ET.fromstring(chart)
    assert tree.attrib["aria-label"] == "a <chart>"
    classes = [part.attrib.get("class", "") for part in tree.iter()]
    assert classes.count("mark fill1") == 1
    assert classes.count("cross stroke1") == 1
    assert classes.count("rule") == 1
    bars = ET.fromstring(bar_chart([1, None, 1], [True, True, False], "sizes"))
    kinds = [part.attrib["class"] for part in bars.iter("rect")]
    assert kinds == ["bar kept", "bar discarded"]


def test_the_time_bar_is_proportional() -> None:
    tree = ET.fromstring(time_bar([("capture", 1.0), ("edges", 3.0)], [1, 2], "time"))
    assert [float(part.attrib["width"]) for part in tree.iter("rect")] == [250.0, 750.0]


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
