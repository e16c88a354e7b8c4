"""What the simulated device promises: draws, seeds, moves, scores, and scenarios."""

from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest
import trimesh

from benchmarks.machined_parts import cylinder, surface_of
from bridge.errors import BadInput
from bridge.image_messages import MoveDone
from bridge.messages import Settings
from geometry.model import Model, find_target, load_model
from geometry.rotation import vector_of
from image_server.serve.device import Change
from image_server.simulator.description import pose_message
from image_server.simulator.placement import drawn_pose, faces_shown, fraction_inside
from image_server.simulator.scenario import load_scenario
from image_server.simulator.scenario_tables import (
    PoseDraw,
    Scenario,
    ScenarioCamera,
    ScenarioEarth,
    Sun,
    Time,
)
from image_server.simulator.scene import skins
from image_server.simulator.simulator import Simulator
from stack.tables import toml_text
from tests.vision_server.synthetic import lines_alone

MIDDLE = Settings(lights=(4, 4, 4), shutter_s=1 / 60, aperture=4.0)
SMALL = ScenarioCamera(width=160, height=120, fx=200.0, fy=200.0, cx=79.5, cy=59.5)


def small(**changes: object) -> Scenario:
    return Scenario(camera=SMALL, **changes)  # type: ignore[arg-type]


def test_the_same_seed_gives_the_same_frames() -> None:
    one, same, other = (Simulator("fixture", small(), seed) for seed in (4, 4, 5))
    assert np.array_equal(one.capture(MIDDLE).pixels, same.capture(MIDDLE).pixels)
    assert not np.array_equal(one.capture(MIDDLE).pixels, other.capture(MIDDLE).pixels)


@pytest.mark.parametrize("target", ["cube", "fixture", "satellite"])
def test_the_true_pose_lies_in_the_search_range_of_the_seed_pose(target: str) -> None:
    for seed in range(8):
        sim = Simulator(target, "nominal", seed)
        start, true = sim.seed_pose, sim.true_pose
        assert start is not None
        turn = start.matrix.T @ true.matrix  # Rx·Ry·Rz
        angles = np.degrees(
            [np.arctan2(-turn[1, 2], turn[2, 2]), np.arcsin(turn[0, 2]), np.arctan2(-turn[0, 1], turn[0, 0])]
        )
        assert np.abs(angles).max() <= 25.0 + 1e-6
        (there,), (place,) = (pose.apply(sim.model.middle[None]) for pose in (true, start))
        offset_px = (there - place) * 800 / place[2]
        assert np.abs(offset_px).max() <= 40.0 + 1e-6
        assert 0.5 <= np.linalg.norm(true.translation) <= 1.0
        camera = sim._camera
        assert fraction_inside(sim.model, camera, true) > 0.9


def test_uniform_draws_show_several_faces() -> None:
    for seed in range(6):
        sim = Simulator("cube", Scenario(pose=PoseDraw(orientation="uniform")), seed)
        assert faces_shown(sim.model, sim.true_pose) >= 2


def test_settings_matter_from_dark_to_saturated() -> None:
    sim = Simulator("cube", "nominal", 3)
    target = sim.basis()[0] > 0

    def median(levels: tuple[int, int, int], shutter_s: float, aperture: float) -> float:
        settings = Settings(lights=levels, shutter_s=shutter_s, aperture=aperture)
        return float(np.median(sim.capture(settings).pixels[target]))

    assert 60 <= median((4, 4, 4), 1 / 60, 4.0) <= 190
    assert median((7, 7, 7), 1 / 15, 2.8) == 255
    assert median((1, 0, 0), 1 / 240, 5.6) < 20


def test_a_move_brings_the_target_to_its_range_and_says_so() -> None:
    sim = Simulator("cube", "approach", 2)
    before, first = sim.true_pose, sim.capture(MIDDLE).pixels
    changes = sim.move(0.8)
    after = sim.true_pose
    assert [change.event for change in changes] == ["target_moved", "sun_changed"]
    assert changes[0].args == {"range_m": 0.8}
    assert np.linalg.norm(after.translation) == pytest.approx(0.8, rel=0.06)
    sight = before.translation / np.linalg.norm(before.translation)
    assert np.linalg.norm(np.cross(sight, after.translation)) < 0.06 * 0.8
    assert np.degrees(np.linalg.norm(vector_of(after.matrix @ before.matrix.T))) < 8
    assert not np.array_equal(first, sim.capture(MIDDLE).pixels)
    target = sim.describe().target
    assert target is not None and target.seed_pose is None


def test_a_target_cannot_come_through_the_camera() -> None:
    with pytest.raises(BadInput, match=r"cannot come to 0.05 m.*Allowed: 0.17 m or more"):
        Simulator("cube", "nominal", 0).move(0.05)


def test_score_is_zero_at_the_true_pose() -> None:
    sim = Simulator("cube", "nominal", 1)
    error = sim.score(pose_message(sim.true_pose))
    assert error.rotation_deg == pytest.approx(0, abs=1e-5)
    assert error.translation_m == 0


def test_score_is_of_where_the_target_stood_after_so_many_moves() -> None:
    sim = Simulator("cube", "approach", 1)
    stood = []
    for range_m in (0.9, 0.7):
        sim.move(range_m)
        stood.append(pose_message(sim.true_pose))
    assert sim.score(stood[0]).translation_m > 0.1
    assert sim.score(stood[0], 1).translation_m == sim.score(stood[1], 2).translation_m == 0
    with pytest.raises(BadInput, match="moved 2 times, not 3"):
        sim.score(stood[0], 3)
    sim.restart(1, 0, [MoveDone(range_m=0.9), MoveDone(range_m=0.7)])
    assert sim.score(stood[0], 1).translation_m == 0


def test_no_description_holds_the_true_pose() -> None:
    sim = Simulator("cube", "nominal", 1)
    said = str(sim.describe()) + str(sim.health()) + str(sim.move(0.9)) + str(sim.describe())
    for number in (*sim.true_pose.rotation_vector, *sim.true_pose.translation):
        assert f"{number:.6f}"[:8] not in said


def test_a_zoom_lens_scales_what_it_describes() -> None:
    zoom = ScenarioCamera(
        width=160, height=120, fx=200.0, fy=200.0, cx=79.5, cy=59.5, focal_lengths_mm=(8.0, 12.0)
    )
    sim = Simulator("cube", Scenario(camera=zoom), 1)
    wide = sim.capture(Settings(lights=(4, 4, 4), shutter_s=1 / 60, aperture=4.0, focal_length_mm=8.0))
    near = sim.capture(Settings(lights=(4, 4, 4), shutter_s=1 / 60, aperture=4.0, focal_length_mm=12.0))
    camera = sim.describe().camera
    assert camera is not None and camera.fx == pytest.approx(300.0)
    assert (near.pixels > 15).sum() > 1.6 * (wide.pixels > 15).sum()


def test_a_focused_lens_is_described_and_blurs_what_is_not_in_focus() -> None:
    lens = msgspec.structs.replace(SMALL, focuses_m=(0.3, 0.75), fx=800.0, fy=800.0)
    sim = Simulator("cube", Scenario(camera=lens), 1)
    assert sim.describe().focuses_m == (0.3, 0.75)

    def sharpness(aperture: float, focus_m: float) -> float:
        shutter_s = 1 / 120 if aperture < 4 else 1 / 30  # the same exposure
        settings = Settings(lights=(2, 2, 2), shutter_s=shutter_s, aperture=aperture, focus_m=focus_m)
        pixels = sim.capture(settings).pixels.astype(float)
        return float(np.abs(np.diff(pixels)).sum() / pixels.sum())

    near_wide, near_narrow, right = sharpness(2.8, 0.3), sharpness(5.6, 0.3), sharpness(2.8, 0.75)
    assert near_wide < near_narrow < right
    with pytest.raises(BadInput, match=r"focus_m = 2 is not offered.*Allowed: 0.3, 0.75 m"):
        sharpness(2.8, 2.0)


DRIFTING = Time(seconds_per_capture=1.0, velocity_m_per_s=(0.002, 0.0, 0.0), target_event_fraction=0.005)


def test_a_drifting_target_moves_with_each_capture_and_says_so() -> None:
    sim = Simulator("cube", small(time=DRIFTING), 1)
    told: list[Change] = []
    sim.listen(told.append)
    start = sim.true_pose.translation
    for number in range(4):
        sim.capture(MIDDLE)
        assert sim.true_pose.translation - start == pytest.approx([0.002 * number, 0, 0], abs=1e-12)
    assert {change.event for change in told} == {"target_moved"}
    assert 1 <= len(told) <= 3  # each time it has gone 0.5 % of the range
    again = Simulator("cube", small(time=DRIFTING), 1)
    frames = [again.capture(MIDDLE).pixels for _ in range(4)]
    assert np.array_equal(sim.capture(MIDDLE).pixels, again.capture(MIDDLE).pixels)
    assert not np.array_equal(frames[0], frames[3])


def test_a_turning_sun_changes_the_light_and_says_so() -> None:
    turning = Time(seconds_per_capture=10.0, sun_deg_per_s=0.6, sun_event_deg=11.0)
    sim = Simulator("cube", small(time=turning), 1)
    told: list[Change] = []
    sim.listen(told.append)
    first = sim.basis()[-1].copy()
    for _ in range(5):
        sim.capture(MIDDLE)
    assert [change.event for change in told] == ["sun_changed", "sun_changed"]  # after 12 and 24 degrees
    assert np.abs(sim.basis()[-1] - first).max() > 0.02


def test_a_drift_blurs_the_image_as_long_as_the_shutter_is_open() -> None:
    still = Time(velocity_m_per_s=(0.0, 0.0, 0.0))
    fast = Time(seconds_per_capture=1e-9, velocity_m_per_s=(4.0, 0.0, 0.0))
    sharp, blurred = (
        Simulator("cube", small(time=time), 1)
        .capture(Settings(lights=(1, 0, 0), shutter_s=1 / 60, aperture=5.6))
        .pixels.astype(float)
        for time in (still, fast)
    )
    assert np.abs(np.diff(blurred, axis=1)).sum() < 0.7 * np.abs(np.diff(sharp, axis=1)).sum()
    assert blurred.mean() == pytest.approx(sharp.mean(), rel=0.05)


def test_a_sun_behind_the_earth_is_an_error() -> None:
    with pytest.raises(BadInput, match="sun stands behind its Earth"):
        Simulator("cube", Scenario(sun=Sun(direction=(0, 0, 1)), earth=ScenarioEarth(direction=(0, 0, 1))))


@pytest.mark.slow
def test_large_frames_come_too() -> None:
    large = ScenarioCamera(width=2048, height=1536, fx=2560.0, fy=2560.0, cx=1023.5, cy=767.5)
    far = PoseDraw(range_m=(1.6, 1.6))
    frame = Simulator("cube", Scenario(camera=large, pose=far), 1).capture(MIDDLE).pixels
    small_one = Simulator("cube", Scenario(pose=far), 1).capture(MIDDLE).pixels
    assert frame.shape == (1536, 2048)
    assert frame.mean() == pytest.approx(small_one.mean(), rel=0.1)


def test_lines_alone_cannot_be_photographed(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="lines alone, and no faces"):
        Simulator(lines_alone(load_model(find_target("cube")), tmp_path))


def test_an_arm_hides_part_of_the_target_and_of_nothing_else() -> None:
    """Without one, nothing is drawn otherwise than before."""
    small = ScenarioCamera(width=320, height=240, fx=400.0, fy=400.0, cx=159.5, cy=119.5)
    plain = msgspec.structs.replace(load_scenario("textured"), camera=small)
    behind = msgspec.structs.replace(plain.background, arm=0.2)
    settings = Settings(lights=(4, 4, 4), shutter_s=1 / 60, aperture=4.0)
    images = [
        Simulator("cube", msgspec.structs.replace(plain, background=one), 3)
        .capture(settings)
        .pixels.astype(float)
        for one in (plain.background, behind)
    ]
    changed = np.abs(images[1] - images[0]) > 20.0
    assert 0.02 < changed.mean() < 0.5


@pytest.mark.parametrize("unit", ["cm", "m"])
def test_a_target_of_any_size_is_seen_and_lit_as_a_usual_one(unit: str) -> None:
    """The satellite, 0.76 m across, and as if its numbers were centimetres."""
    simulator = Simulator("satellite", "nominal", 2, unit=unit)
    light, camera = simulator.describe().lights[0], simulator.camera
    middle = simulator.true_pose.apply(simulator.model.middle[None])[0]
    assert light.position is not None
    assert 0.2 < camera.fx * simulator.model.diameter / middle[2] / camera.height < 2.0
    assert 0.5 < light.power / np.sum((middle - light.position) ** 2) < 5.0


def test_a_range_that_is_told_is_kept(tmp_path: Path) -> None:
    (tmp_path / "near.toml").write_text("[pose]\nrange_m = [0.2, 0.2]\n")
    simulator = Simulator("satellite", str(tmp_path / "near.toml"), 1, unit="cm")
    assert np.linalg.norm(simulator.true_pose.translation) == pytest.approx(0.2)
    assert simulator.describe().lights[0].position == (-0.35, 0.0, 0.0)  # as are its lamps


def test_a_rig_of_one_s_own_stays_where_its_file_says(tmp_path: Path) -> None:
    """The satellite as if in centimetres: a bundled scenario fits it, the same lamps in a file do not."""
    bundled = load_scenario("beams")
    (tmp_path / "mine.toml").write_text(
        toml_text(msgspec.to_builtins(bundled)).replace("in_proportion = true\n", "")
    )
    mine = Simulator("satellite", str(tmp_path / "mine.toml"), 1, unit="cm")
    told = [light.position for light in bundled.lights]
    assert [light.position for light in mine.describe().lights] == told
    assert np.linalg.norm(mine.true_pose.translation) < 0.1  # its range is untold
    fitted = Simulator("satellite", "beams", 1, unit="cm")
    places = [light.position for light in fitted.describe().lights]
    assert np.allclose(places, 0.05 * np.array(told), rtol=0.1)


def test_a_part_far_from_its_file_s_origin_is_in_the_frame() -> None:
    cube = load_model(find_target("cube"))
    aside = replace(cube, vertices=np.add(cube.vertices, [3.0, 0.0, 0.0]))
    camera = Simulator("cube").camera
    pose = drawn_pose(PoseDraw(), aside, np.array([0.0, 0.0, 1.0]), camera, np.random.default_rng(1))
    assert fraction_inside(aside, camera, pose) == 1.0


def test_a_part_may_be_before_the_camera_and_its_file_s_origin_behind(tmp_path: Path) -> None:
    """As of one part of an assembly, in the assembly's coordinates."""
    trimesh.creation.box(bounds=[[0.3, 0.0, 0.6], [0.32, 0.02, 0.62]]).export(tmp_path / "bracket.stl")
    depths = []
    for seed in range(6):
        scene = Simulator(str(tmp_path / "bracket.stl"), small(in_proportion=True), seed)
        assert scene.seed_pose is not None and scene.seed_pose.apply(scene.model.middle)[2] > 0.0
        depths.append(scene.seed_pose.translation[2])
    assert min(depths) < 0.0


def test_facets_of_what_is_flat_or_round_have_one_texture() -> None:
    round_one = Model.of_surface("cylinder", surface_of(cylinder(24)))
    assert len(set(skins(round_one).tolist())) == 3
    cube = load_model(find_target("cube"))
    assert skins(cube).tolist() == list(range(len(cube.faces)))
