"""Where an image says little, or something else, there is no pose, or one that says how doubtful it is."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks.photographs import image_set, simulated
from geometry.errors import GeometryError
from geometry.model import Model, find_target, load_model
from geometry.near_symmetries import near_symmetries
from geometry.pose import RIGHT, Pose, disturbed
from numerics.arrays import Floats, Grey
from tests.vision_server.synthetic import CAMERA, POSE, linear_picture, one_image, photographed
from vision_server.matchers import MATCHERS
from vision_server.pipeline import PipelineSettings, estimate_pose
from vision_server.trust.judgement import Estimate

pytestmark = pytest.mark.slow

DOUBT = 0.8  # scores under this are not believed
GREYS = (0.3, 0.7, 0.2, 0.9, 0.5, 0.8)


def estimated(pixels: Grey, model: Model, seed: Pose, **settings: object) -> Estimate:
    chosen = PipelineSettings(**settings)  # type: ignore[arg-type]
    return estimate_pose(one_image(pixels), ["i1"], model, CAMERA, seed, chosen)


def must_not_mislead(estimate: Estimate, true: Pose | None = None) -> None:
    """No pose, the right pose, or one that is not believed and has no small error."""
    if estimate.pose is None:
        assert estimate.score == 0.0
        return
    if true is not None and estimate.pose.error_to(true).within(*RIGHT):
        return
    assert estimate.score < DOUBT
    assert estimate.rms_px is not None
    assert estimate.rms_px > 1.0


@pytest.fixture(scope="module")
def pixels(model: Model) -> Grey:
    return photographed(linear_picture(model, CAMERA, POSE, GREYS))


def test_two_poses_that_explain_the_image_are_both_reported() -> None:
    """A cube halfway between two of its poses: edges cannot tell by which quarter turn it is seen."""
    cube = load_model(find_target("cube"))
    true = Pose(np.array([0.5, 0.6, 0.15]), np.array([0.0, 0.0, 4.0 * cube.diameter]))
    quarter = true.compose(Pose(np.array([0.0, np.pi / 2, 0.0]), np.zeros(3)))
    between = true.compose(Pose(np.array([0.0, np.pi / 4, 0.0]), np.zeros(3)))
    picture = photographed(linear_picture(cube, CAMERA, true, GREYS))
    estimate = estimated(picture, cube, between, rotation_range_deg=50.0)
    assert estimate.pose is not None
    found = [estimate.pose, *(rival.pose for rival in estimate.rivals)]
    for pose in (true, quarter):
        assert any(one.error_to(pose).within(*RIGHT) for one in found)
    assert estimate.rivals[0].share > 0.9
    assert estimate.ambiguity > 0.9
    alone = estimated(picture, cube, disturbed(true, np.random.default_rng(0), 20.0, 20.0, CAMERA.fx))
    assert alone.ambiguity < 0.5
    assert alone.score > max(DOUBT, estimate.score)


@pytest.mark.parametrize("seed", [71, 72])
def test_a_seed_upside_down_is_told_by_the_few_lines_that_differ(seed: int) -> None:
    """The fixture turned by half fits all lines but those of its bar and box."""
    one = simulated("fixture", "nominal", seed)
    turn = near_symmetries(one.model)[0]
    chosen = PipelineSettings(tone_sd_px=one.tone_sd_px)
    rng = np.random.default_rng(seed)
    for start, believed in ((one.true, True), (one.true.compose(turn), False)):
        seed_pose = disturbed(start, rng, 15.0, 20.0, one.camera.fx, one.model.middle)
        estimate = estimate_pose(image_set([one]), ["i0"], one.model, one.camera, seed_pose, chosen)
        assert (estimate.score > DOUBT) == believed
    assert estimate.ambiguity == 1.0
    assert max(rival.share for rival in estimate.rivals) == 1.0
    assert estimate.rivals[0].pose.error_to(one.true).within(*RIGHT)


@pytest.mark.parametrize("matcher", sorted(MATCHERS))
@pytest.mark.parametrize(
    ("turn_deg", "shift"), [(0.0, (0.3, 0.0, 0.0)), (0.0, (0.0, 0.0, 3.0)), (90.0, (0.05, 0.05, 0.0))]
)
def test_a_seed_far_off_does_not_mislead(
    model: Model, pixels: Grey, matcher: str, turn_deg: float, shift: tuple[float, ...]
) -> None:
    turned = POSE.compose(Pose(np.array([0.0, 0.0, np.radians(turn_deg)]), np.zeros(3)))
    seed = Pose(turned.rotation_vector, turned.translation + np.array(shift))
    must_not_mislead(estimated(pixels, model, seed, matcher=matcher), POSE)


@pytest.mark.parametrize("depth_m", [1e-4, 0.02, 0.05])
def test_a_camera_inside_the_model_does_not_mislead(model: Model, pixels: Grey, depth_m: float) -> None:
    seed = Pose(POSE.rotation_vector, np.array([0.0, 0.0, depth_m]))
    must_not_mislead(estimated(pixels, model, seed), POSE)


def test_a_model_behind_the_camera_is_refused(model: Model, pixels: Grey) -> None:
    with pytest.raises(GeometryError, match="behind the camera"):
        estimated(pixels, model, Pose(POSE.rotation_vector, -POSE.translation))


def test_a_pose_that_is_no_number_is_refused() -> None:
    for rotation, translation in (([np.nan, 0, 0], [0, 0, 1]), ([0, 0, 0], [0, np.inf, 1])):
        with pytest.raises(GeometryError, match="finite"):
            Pose(np.array(rotation), np.array(translation))


def one_edge() -> Floats:
    picture = np.full((240, 320), 0.1)
    picture[:, 170:] = 0.6
    return picture


def stripes() -> Floats:
    y, x = np.mgrid[0:240, 0:320]
    return 0.3 + 0.25 * np.sign(np.sin((x + 0.4 * y) / 9.0))


def clutter() -> Floats:
    rng = np.random.default_rng(3)
    picture = np.full((240, 320), 0.2, dtype=np.float32)
    for _ in range(150):
        ends = rng.integers(0, [320, 240], (2, 2))
        cv2.line(picture, tuple(map(int, ends[0])), tuple(map(int, ends[1])), float(rng.uniform(0, 1)), 2)
    return picture.astype(np.float64)


@pytest.mark.parametrize("matcher", sorted(MATCHERS))
@pytest.mark.parametrize("picture", [one_edge, stripes, clutter])
def test_lines_of_something_else_do_not_mislead(model: Model, matcher: str, picture: object) -> None:
    blurred = cv2.GaussianBlur(picture(), (0, 0), 0.7)  # type: ignore[operator]
    for seed in (POSE, disturbed(POSE, np.random.default_rng(1), 20.0, 20.0, CAMERA.fx)):
        must_not_mislead(estimated(photographed(np.asarray(blurred)), model, seed, matcher=matcher))


def test_a_model_of_five_thousand_lines_is_searched_and_does_not_mislead(
    tmp_path: Path, pixels: Grey
) -> None:
    """A plate of 30 x 30 small pyramids, matched with the picture of a plain box."""
    side, step, height = 30, 0.0084, 0.003
    corners = [(i * step - 0.126, j * step - 0.126, 0.0) for j in range(side + 1) for i in range(side + 1)]
    tips = [
        ((i + 0.5) * step - 0.126, (j + 0.5) * step - 0.126, -height)
        for j in range(side)
        for i in range(side)
    ]
    faces = []
    for j in range(side):
        for i in range(side):
            a, tip = j * (side + 1) + i + 1, len(corners) + j * side + i + 1
            around = [a, a + 1, a + side + 2, a + side + 1]
            faces += [(around[k], tip, around[(k + 1) % 4]) for k in range(4)]
    lines = [f"v {x} {y} {z}" for x, y, z in corners + tips] + [f"f {a} {b} {c}" for a, b, c in faces]
    (tmp_path / "plate.obj").write_text("\n".join(lines) + "\n")
    plate = load_model(tmp_path / "plate.obj")
    assert len(plate.lines) > 5000
    for matcher in sorted(MATCHERS):
        must_not_mislead(
            estimated(pixels, plate, Pose(np.array([3.0, 0.2, 0.1]), POSE.translation), matcher=matcher)
        )
