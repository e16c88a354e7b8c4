"""Scenarios: every one can be read, conditions change it, and what is wrong is named."""

from pathlib import Path

import msgspec
import pytest
import trimesh

from bridge.errors import BadInput
from bridge.messages import Describe, Settings
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
        ("[camera]\nbits = 12", r"\[camera\] bits and bayer are of recorded frames"),
        ("[camera]\nbayer = true", r"\[camera\] bits and bayer are of recorded frames"),
        ("light_power = inf", "light_power is not a finite number"),
        ("[sun]\ndirection = [0.0, nan, 1.0]", "sun.direction 2 is not a finite number"),
        ("[earth]\ndirection = [0.0, 0.0, 0.0]", r"\[earth\] direction has no length"),
        ("[sun]\ndirection = [1e-300, 0.0, 0.0]", r"\[sun\] direction has no length"),
        (f"{ONE_LIGHT}aim = [0.0, 1e-200, 0.0]", r"\[\[lights\]\] 'a' aim has no length"),
        (f"{ONE_LIGHT}beam = [[0.0, 1.0], [0.0, 0.5]]", r"'a': the angles of its beam do not grow"),
        (
            f"{ONE_LIGHT}beam = [[0.0, 1.0], [9.0, 0.5]]\nhalf_intensity_deg = 9.0",
            "half_intensity_deg and beam",
        ),
        ("[sun", "not valid TOML"),
        (ONE_LIGHT.replace("[[", "[").replace("]]", "]"), r"in \[lights\]. Write \[\[lights\]\]"),
        ("[[sun]]\nglint = true", r"in \[sun\]. Write \[sun\]\."),
        (2 * ONE_LIGHT, "two lights are called 'a'"),
        (ONE_LIGHT.replace("0.0]", "1e300]"), r"<= 20000.0 in \[lights 1.position 3\]"),
        (f"{ONE_LIGHT}power = 1e300", r"in \[lights 1.power\]"),
        ("light_power = 1e300", r"in \[light_power\]"),
        ("[camera]\nshutters_s = [1e300]", r"<= 100000.0 in \[camera.shutters_s 1\]"),
        ("[camera]\nshutters_s = [1e-300]", r">= 1e-09 in \[camera.shutters_s 1\]"),
        ("[camera]\napertures = [4.0, 1e300]", r"<= 10000.0 in \[camera.apertures 2\]"),
        ("[camera]\nfocuses_m = [1e300]", r"in \[camera.focuses_m 1\]"),
        ("[camera]\nfocal_lengths_mm = [1e-300]", r"in \[camera.focal_lengths_mm 1\]"),
        ("[camera]\nfx = 1e300", r"in \[camera.fx\]"),
        ("[camera]\ncx = 1e300", r"in \[camera.cx\]"),
        ("[camera]\ngain = 1e300", r"in \[camera.gain\]"),
        ("[camera]\nfull_well_e = 1e-300", r"in \[camera.full_well_e\]"),
        ("[camera]\nread_noise_e = 1e300", r"in \[camera.read_noise_e\]"),
        ("[pose]\ncentre_px = [1e300, 0.0]", r"in \[pose.centre_px 1\]"),
        ("[sun]\ndirection = [1e300, 0.0, 1.0]", r"in \[sun.direction 1\]"),
        ("[time]\nspin_deg_per_s = [1e300, 0.0, 1.0]", r"in \[time.spin_deg_per_s 1\]"),
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


UTMOST = """
in_proportion = true
light_power = 1e9
[camera]
shutters_s = [1e-9, 1e5]
apertures = [1e-2, 1e4]
focal_lengths_mm = [1e-3, 1e6]
focuses_m = [1e-3, 2e4]
[[lights]]
name = "a"
position = [2e4, -2e4, 2e4]
power = 1e9
"""


def test_a_blur_that_is_larger_than_the_frame_is_refused() -> None:
    with pytest.raises(BadInput, match="The scenario: defocus_sigma_px blurs over 641 px, and the frame"):
        Simulator("cube", with_conditions(load_scenario("nominal"), defocus_sigma_px=641.0))


@pytest.mark.parametrize("size_m", [0.004, 17.0])
def test_messages_hold_the_utmost_that_a_scenario_may_say(tmp_path: Path, size_m: float) -> None:
    """For the least and largest of targets, to which all of it is in proportion."""
    file, model = tmp_path / "mine.toml", tmp_path / "box.stl"
    file.write_text(UTMOST)
    trimesh.creation.box([size_m] * 3).export(model)
    told = Simulator(str(model), str(file)).describe()
    assert msgspec.json.decode(msgspec.json.encode(told), type=Describe) == told
    for focus_m, focal_mm in zip(told.focuses_m or (), told.focal_lengths_mm or (), strict=True):
        settings = Settings((0,), 1.0, 4.0, focal_length_mm=focal_mm, focus_m=focus_m)
        assert msgspec.json.decode(msgspec.json.encode(settings), type=Settings) == settings


def test_a_range_that_grows_beyond_all_bounds_with_the_target_is_refused(tmp_path: Path) -> None:
    file, model = tmp_path / "mine.toml", tmp_path / "box.stl"
    file.write_text("in_proportion = true\n[pose]\nrange_m = [1e4, 1e5]\n")
    trimesh.creation.box([10.0] * 3).export(model)
    with pytest.raises(
        BadInput, match=r"range_m ends at 2.16506e\+06 m, .* 17 m large. Allowed: 100000 m or less"
    ):
        Simulator(str(model), str(file))


@pytest.mark.parametrize("seed", [1, 2])
def test_a_focal_length_in_mm_is_told(tmp_path: Path, seed: int) -> None:
    file = tmp_path / "mine.toml"
    file.write_text("[camera]\nwidth = 64\nheight = 48\nfx = 12.0\n")
    with pytest.raises(BadInput, match=r"\[camera\] fx is 12 px: .* behind the camera. fx is no focal"):
        Simulator("cube", str(file), seed=seed)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[pose]\nrange_m = [500.0, 1000.0]", r"target, which is 0\.35 m large, is less than a pixel wide"),
        ("[camera]\ncx = 5000.0", r"outside of its frame of 640×480 px\. Check \[camera\] fx, cx and cy"),
        ("[pose]\ncentre_px = [1e6, 1e6]", r"outside of its frame"),
    ],
)
def test_a_target_that_is_not_seen_is_told(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(text)
    with pytest.raises(BadInput, match=message):
        Simulator("cube", str(file))


def test_a_focal_length_that_does_not_fit_the_width_is_the_scenarios(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text("[camera]\nfx = 60.0\n")
    with pytest.raises(BadInput, match="The scenario's camera fx is 60 px of a frame 640 px wide"):
        Simulator("cube", str(file))


def test_a_distortion_that_folds_the_picture_is_the_scenarios(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text("[camera]\ndistortion = [1e300, 0.0, 0.0, 0.0]\n")
    with pytest.raises(BadInput, match="The scenario's camera distortion cannot be undone"):
        Simulator("cube", str(file))


def test_unknown_names_list_the_known_ones() -> None:
    with pytest.raises(BadInput, match=r"no scenario 'dusk'.*Known: .*eclipse.*nominal"):
        load_scenario("dusk")
    with pytest.raises(BadInput, match=r"unknown target 'pyramid'.*cube"):
        Simulator("pyramid")
