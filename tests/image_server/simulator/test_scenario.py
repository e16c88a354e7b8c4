"""Scenarios: every one can be read, conditions change it, and what is wrong is named."""

from pathlib import Path

import pytest

from bridge.errors import BadInput
from image_server.simulator.scenario import SCENARIOS, load_scenario, with_conditions
from image_server.simulator.simulator import Simulator

ONE_LIGHT = "[[lights]]\nname = 'a'\nposition = [0.0, 0.0, 0.0]\n"


@pytest.mark.parametrize("name", sorted(path.stem for path in SCENARIOS.glob("*.toml")))
def test_every_scenario_can_be_read_and_says_what_it_is(name: str) -> None:
    assert load_scenario(name).description


def test_conditions_change_a_scenario() -> None:
    changed = with_conditions(load_scenario("blur"), 8.0, 2.0, 1.0, (5.0, 6.0))
    assert changed.ambient_scale == 8.0
    assert changed.light_power == 0.5
    assert changed.camera.defocus_sigma_px == 1.0
    assert changed.camera.motion_px_per_s == (5.0, 6.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("sunlight = 1", "unknown key `sunlight`"),
        ("[sun]\nangel_deg = [1.0, 2.0]", r"unknown key `angel_deg` in \[sun\]"),
        ("ambient_scale = -1.0", r">= 0.*\[ambient_scale\]"),
        ("[pose]\nrange_m = [1e6, 1e6]", r"range_m"),
        ("[pose]\nrange_m = [1.0, 0.5]", r"\[pose\] range_m runs from 1 down to 0.5"),
        (
            "[background]\nkind = 'forest'",
            r"unknown word 'forest' in \[background.kind\]. There are clutter, space, wall.",
        ),
        ("[background]\nkind = 'spce'", r"Did you mean space\?"),
        ("ambient_scal = 1.0", r"unknown key `ambient_scal`. Did you mean ambient_scale\?"),
        ("[[lights]]\nname = 'a'\nposition = [0, 0, 0]\naimm = 1", r"in \[lights 1\]. Did you mean aim\?"),
        ("light_power = inf", "light_power is not a finite number"),
        ("[sun]\ndirection = [0.0, nan, 1.0]", "sun.direction 2 is not a finite number"),
        ("[earth]\ndirection = [0.0, 0.0, 0.0]", r"\[earth\] direction has no length"),
        (f"{ONE_LIGHT}beam = [[0.0, 1.0], [0.0, 0.5]]", r"'a': the angles of its beam do not grow"),
        (
            f"{ONE_LIGHT}beam = [[0.0, 1.0], [9.0, 0.5]]\nhalf_intensity_deg = 9.0",
            "half_intensity_deg and beam",
        ),
        ("[sun", "not valid TOML"),
    ],
)
def test_a_wrong_scenario_says_what_and_where(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(text)
    with pytest.raises(BadInput, match=message):
        load_scenario(str(file))


@pytest.mark.parametrize(
    ("told", "fx", "fy", "cx"),
    [
        ("", 800.0, 800.0, 319.5),
        ("width = 1280\nheight = 960", 1600.0, 1600.0, 639.5),
        ("width = 320\nfy = 300.0\ncx = 100.0", 300.0, 300.0, 100.0),
    ],
)
def test_a_camera_that_tells_its_frame_alone_sees_as_much(
    tmp_path: Path, told: str, fx: float, fy: float, cx: float
) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(f"[camera]\n{told}\n")
    camera = load_scenario(str(file)).camera
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == (fx, fy, cx, (camera.height - 1) / 2)


def test_a_range_inside_the_target_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text("[pose]\nrange_m = [0.05, 0.1]\n")
    with pytest.raises(BadInput, match=r"range_m begins at 0.05 m, and the target is 0\.\d+ m large"):
        Simulator("cube", str(file))


def test_unknown_names_list_the_known_ones() -> None:
    with pytest.raises(BadInput, match=r"no scenario 'dusk'.*Known: .*eclipse.*nominal"):
        load_scenario("dusk")
    with pytest.raises(BadInput, match=r"unknown target 'pyramid'.*cube"):
        Simulator("pyramid")
