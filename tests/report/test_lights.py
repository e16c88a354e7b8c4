"""The lights of an image as a diagram, and an approach as a strip of hold points."""

import math
import re
from itertools import combinations

import pytest

from bridge.result_file import SettingsRecord
from report.lights import lights_svg
from report.scene import LightRecord
from report.story import _bars

PLACED = (
    LightRecord("left", 8, (-0.35, 0.0, 0.0)),
    LightRecord("top", 8, (0.0, -0.35, 0.0)),
    LightRecord("lamp", 1, (0.35, 0.1, 0.0)),
)


def test_each_light_is_at_its_place_and_as_bright_as_it_was() -> None:
    svg = lights_svg(SettingsRecord(lights=[7, 0, 0]), PLACED)
    opacity = [float(value) for value in re.findall(r'fill-opacity="([\d.]+)"', svg)]
    assert opacity == [1.0, 0.0, 1.0]  # a light with one level is on
    (left, right, lamp) = [
        (float(x), float(y)) for x, y in re.findall(r"translate\(([-\d.]+) ([-\d.]+)\)", svg)
    ]
    assert left[0] < 0 and left[1] == 0
    assert right[0] == 0 and right[1] < 0
    assert lamp[0] > 0 and lamp[1] > 0
    assert "<title>left: 7 of 7</title>" in svg
    bars = _bars(SettingsRecord(lights=[7, 0, 0]), PLACED, [])
    assert [(bar.text, bar.share) for bar in bars] == [("7/7", 1.0), ("0/7", 0.0), ("on", 1.0)]


def test_nothing_leaves_the_frame() -> None:
    far = (LightRecord("a", 2, (3.0, 0.01, 0.0)), LightRecord("b", 2, (-0.01, 0.02, 0.0)))
    svg = lights_svg(SettingsRecord(lights=[1, 1]), far)
    for x, y in re.findall(r"translate\(([-\d.]+) ([-\d.]+)\)", svg):
        assert abs(float(x)) <= 60 - 9
        assert abs(float(y)) <= 42 - 9


def test_many_lights_leave_each_other_room() -> None:
    turns = [2 * math.pi * number / 24 for number in range(24)]
    ring = tuple(
        LightRecord(f"l{n}", 2, (math.cos(turn), math.sin(turn), 0.0)) for n, turn in enumerate(turns)
    )
    svg = lights_svg(SettingsRecord(lights=[1] * 24), ring)
    places = [(float(x), float(y)) for x, y in re.findall(r"translate\(([-\d.]+) ([-\d.]+)\)", svg)]
    (radius,) = {float(value) for value in re.findall(r'"lamp" r="([\d.]+)"', svg)}
    assert min(math.dist(*pair) for pair in combinations(places, 2)) == pytest.approx(2 * radius, abs=0.2)


def test_of_many_lights_those_alike_beside_each_other_have_one_bar() -> None:
    lights = tuple(LightRecord(f"l{number}", 8, None) for number in range(12))
    settings = SettingsRecord(lights=[7] * 4 + [0] * 7 + [3])
    bars = _bars(settings, lights, [])
    assert [(bar.name, bar.text) for bar in bars] == [
        ("l0 – l3", "100 %"),
        ("l4 – l10", "0 %"),
        ("l11", "3/7"),
    ]
    assert len(_bars(SettingsRecord(lights=[7] * 3), lights[:3], [])) == 3


@pytest.mark.parametrize(
    ("levels", "lights"),
    [
        ([1], ()),
        ([1], (LightRecord("left", 8),)),
        ([1, 2], PLACED),
        ([1], (LightRecord("l", 8, (0.0, 0.0, 0.5)),)),
    ],
)
def test_there_is_none_where_a_place_is_not_known(levels: list[int], lights: tuple[LightRecord, ...]) -> None:
    assert lights_svg(SettingsRecord(lights=levels), lights) == ""
