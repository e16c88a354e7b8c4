"""Blur of a moving and turning target, against the mean of many renders along its way."""

import msgspec
import numpy as np
import pytest

from bridge.messages import Settings
from geometry.pose import Pose
from geometry.rotation import matrix_of
from image_server.simulator.motion import image_velocity, smeared
from image_server.simulator.scenario_tables import DEFAULT_LIGHTS, Background, Scenario, ScenarioCamera, Time
from image_server.simulator.simulator import Simulator
from numerics.arrays import Field, Floats
from stack.sensor import blurred
from tests.stack.cameras import camera as still

pytestmark = pytest.mark.slow

SHUTTER_S = 1 / 15
MOMENTS = 9
LIGHTS = DEFAULT_LIGHTS[:1]
SMALL = ScenarioCamera(width=320, height=240, fx=400.0, fy=400.0, cx=159.5, cy=119.5)
SHAPE = (SMALL.height, SMALL.width)


def moving(
    velocity: tuple[float, float, float], spin_deg: tuple[float, float, float], **more: object
) -> Simulator:
    time = Time(seconds_per_capture=1.0, velocity_m_per_s=velocity, spin_deg_per_s=spin_deg)
    scenario = Scenario(time=time, lights=LIGHTS, camera=SMALL)
    return Simulator("cube", msgspec.structs.replace(scenario, **more), 4)


def exposure(simulator: Simulator, velocity: Floats, spin: Floats) -> Field:
    """The mean of renders at moments of the exposure: what the blur has to come near."""
    middle = simulator.true_pose
    total = np.zeros(SHAPE)
    for moment in (np.arange(MOMENTS) + 0.5) / MOMENTS - 0.5:
        seconds = SHUTTER_S * moment
        turned = matrix_of(spin * seconds) @ middle.matrix
        simulator.true_pose = Pose.from_matrix(turned, middle.translation + velocity * seconds)
        total += simulator.basis()[0]
    simulator.true_pose = middle
    return (total / MOMENTS).astype(np.float32)


@pytest.mark.parametrize(
    ("velocity", "spin_deg"),
    [
        ((0.12, -0.06, 0.0), (0.0, 0.0, 0.0)),
        ((0.0, 0.0, 0.6), (0.0, 0.0, 0.0)),
        ((0.0, 0.0, 0.0), (0.0, 0.0, 120.0)),
        ((0.0, 0.0, 0.0), (40.0, -60.0, 0.0)),
        ((0.1, 0.0, 0.1), (0.0, 40.0, 60.0)),
    ],
)
def test_blur_is_the_mean_of_the_way(
    velocity: tuple[float, float, float], spin_deg: tuple[float, float, float]
) -> None:
    simulator = moving(velocity, spin_deg)
    v, spin = np.array(velocity), np.radians(spin_deg)
    true = exposure(simulator, v, spin)
    sharp = simulator.basis()[0]
    origin, depth = simulator.true_pose.translation, simulator._view().target_depth
    ours = smeared(sharp, simulator.camera, origin, v, spin, depth, SHUTTER_S)
    blur, error = (float(np.sqrt(np.mean((image - true) ** 2))) for image in (sharp, ours))
    assert blur > 0.0005  # there is something to blur
    assert error < 0.4 * blur  # what is left is mostly interpolation, and light that changes on the way


def test_a_turn_about_the_line_of_sight_moves_in_circles() -> None:
    simulator = moving((0.0, 0.0, 0.0), (0.0, 0.0, 10.0))
    camera, spin = simulator.camera, np.array([0.0, 0.0, 0.2])
    field = image_velocity(
        camera, np.array([0.0, 0.0, 1.0]), np.zeros(3), spin, np.full(SHAPE, 0.7, np.float32)
    )
    x, y = 300, 50
    dx, dy = (x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy
    assert field[y, x] == pytest.approx([-0.2 * dy * camera.fx, 0.2 * dx * camera.fy], rel=1e-4)


def test_a_side_step_blurs_as_a_line() -> None:
    """Far from outlines it is the straight line of `motion_px_per_s`, as long as the depth asks for."""
    simulator = moving((0.05, 0.02, 0.0), (0.0, 0.0, 0.0))
    camera, origin = simulator.camera, simulator.true_pose.translation
    radiance = np.random.default_rng(1).random(SHAPE, np.float32)
    flat = np.full(SHAPE, 2.0, np.float32)
    ours = smeared(radiance, camera, origin, np.array([0.05, 0.02, 0.0]), np.zeros(3), flat, SHUTTER_S)
    sensor = still(motion_px_per_s=(0.05 * 2 * camera.fx, 0.02 * 2 * camera.fy))
    line = blurred(radiance, sensor, SHUTTER_S, 4.0)
    assert np.abs(ours - line)[20:-20, 20:-20].mean() < 0.02


def test_a_path_of_kilometres_is_a_frame_like_others() -> None:
    """What was searched for what moves by grew with the path, until there was no memory."""
    simulator = moving((1e6, 0.0, 0.0), (0.0, 0.0, 0.0))
    frame = simulator.capture(Settings((7,), SHUTTER_S, 4.0))
    assert frame.pixels.max() < 20  # its light is spread over all that it passes


def test_what_stands_behind_the_target_stays_sharp() -> None:
    simulator = moving((0.1, 0.0, 0.0), (0.0, 0.0, 0.0), background=Background(kind="wall"))
    view = simulator._view()
    origin, velocity = simulator.true_pose.translation, np.array([0.1, 0.0, 0.0])
    sharp = view.images[0]
    ours = smeared(sharp, simulator.camera, origin, velocity, np.zeros(3), view.target_depth, SHUTTER_S)
    changed = np.abs(ours - sharp) > 1e-4
    behind = view.target_depth == 0
    assert (view.inverse_depth[behind] > 0).all()
    assert changed[behind].mean() < 0.05 < changed[~behind].mean()
