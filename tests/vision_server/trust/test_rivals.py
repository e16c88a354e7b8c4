"""What the seed pose says of a pose, and of two that explain the images alike."""

from dataclasses import replace
from pathlib import Path

import manifold3d
import numpy as np
import pytest
import trimesh

from bridge.messages import Settings
from geometry.model import Model
from geometry.pose import RIGHT, Pose
from geometry.rotation import matrix_of
from geometry.symmetries import ASYMMETRIC, Symmetry
from image_server.simulator.simulator import Simulator
from tests.vision_server.refined_poses import channels_of
from tests.vision_server.synthetic import CAMERA, POSE, linear_picture, photographed
from vision_server.image_set import ImageSet
from vision_server.matching.draws import MARGIN_DEG, MARGIN_PX, MARGIN_SHARE, beyond_of
from vision_server.matching.match import SearchRange
from vision_server.pipeline import PipelineSettings, estimate_pose
from vision_server.pose.observation import PoseProblem
from vision_server.trust import rivals
from vision_server.trust.ranking import Refined, best_first, nowhere
from vision_server.trust.rivals import (
    BEYOND_NATS,
    TURNED_NATS,
    likeliest_first,
    nats_against,
    rivals_of,
    symmetric_images,
)

GREYS = (0.3, 0.7, 0.2, 0.9, 0.5, 0.8)


def turned_by(pose: Pose, degrees: float) -> Pose:
    """About the target's own x axis."""
    return Pose.from_matrix(pose.matrix @ matrix_of(np.radians([degrees, 0.0, 0.0])), pose.translation)


@pytest.fixture
def best(model: Model) -> Refined:
    pixels = photographed(linear_picture(model, CAMERA, POSE, GREYS), seed=1)
    return best_first(PoseProblem.at_scale(channels_of(pixels), model, CAMERA), [POSE])[0]


def aside(pose: Pose, place_px: float) -> Pose:
    """As many pixels to the side, of the same depth."""
    moved_m = place_px * pose.translation[2] / CAMERA.fx
    return Pose(pose.rotation_vector, pose.translation + np.array([moved_m, 0.0, 0.0]))


def at(one: Refined, pose: Pose) -> Refined:
    """As well supported, at another pose."""
    return replace(one, solution=replace(one.solution, pose=pose))


def test_nothing_speaks_against_a_pose_within_the_range() -> None:
    beyond = beyond_of(POSE, CAMERA, SearchRange(25.0, 40.0))
    margin = MARGIN_SHARE * 25.0 + MARGIN_DEG
    assert beyond(turned_by(POSE, 25.0 + margin)) == pytest.approx(1.0)
    angles = (0.0, 12.5, 24.9, 25.0 + 0.25 * margin, 25.0 + 0.5 * margin, 90.0)
    against = [nats_against(beyond(turned_by(POSE, angle))) for angle in angles]
    assert against == pytest.approx([0.0, 0.0, 0.0, 0.5 * BEYOND_NATS, BEYOND_NATS, BEYOND_NATS])
    margin_px = MARGIN_SHARE * 40.0 + MARGIN_PX
    places_px = (0.0, 39.9, -40.0 - 0.25 * margin_px, 40.0 + 0.5 * margin_px)
    against = [nats_against(beyond(aside(POSE, place_px))) for place_px in places_px]
    assert against == pytest.approx([0.0, 0.0, 0.5 * BEYOND_NATS, BEYOND_NATS])


def test_of_parts_in_a_row_the_one_at_the_seed_pose_comes_first(best: Refined) -> None:
    """Those beside it explain their edges as well: beyond the search range, and at its border."""
    beyond = beyond_of(POSE, CAMERA, SearchRange(25.0, 40.0))
    near = at(best, aside(POSE, 5.0))
    for place_px in (-42.0, 35.0):
        other = at(best, aside(POSE, place_px))
        assert likeliest_first([other, near], beyond) == [near, other]
        assert likeliest_first([near, other], beyond) == [near, other]


def test_of_two_poses_that_explain_the_images_alike_the_one_within_the_range_comes_first(
    best: Refined,
) -> None:
    beyond = beyond_of(POSE, CAMERA, SearchRange(25.0, 40.0))
    near, far = at(best, turned_by(POSE, 5.0)), at(best, turned_by(POSE, 27.0))
    assert likeliest_first([far, near], beyond) == [near, far]
    assert likeliest_first([near, far], beyond) == [near, far]
    seen = best.support.supports & (np.arange(len(best.support.distance)) % 3 > 0)
    less = replace(near, support=replace(near.support, supports=seen))
    assert likeliest_first([far, less], beyond) == [far, less]
    against = nats_against(beyond(far.pose))
    assert 2.0 < against < BEYOND_NATS
    assert [one.nats for one in rivals_of([near, far], ASYMMETRIC, nowhere, beyond)] == [-against]
    assert [one.nats for one in rivals_of([far, near], ASYMMETRIC, nowhere, beyond)] == [against]
    assert [one.nats for one in rivals_of([near, far], ASYMMETRIC, nowhere, lambda _: 0.0)] == [0.0]


def test_a_pose_that_explains_clearly_more_comes_first(best: Refined) -> None:
    """Quality is a mean: a side of a round part that shows little has more of it than one that shows all."""
    beyond = beyond_of(POSE, CAMERA, SearchRange(25.0, 40.0))
    few = np.isin(best.support.samples.line, np.unique(best.support.samples.line)[:4])
    less = replace(best.support, supports=best.support.supports & few)
    little = replace(
        at(best, turned_by(POSE, 5.0)), support=replace(less, strength=1.0, supported_fraction=1.0)
    )
    assert little.quality > best.quality
    assert likeliest_first([little, best], beyond) == [best, little]
    poor = replace(best, support=replace(best.support, strength=0.45))
    assert poor.quality < 0.5 * little.quality
    assert likeliest_first([little, poor], beyond) == [little, poor]


def test_a_pose_that_a_near_symmetry_leads_to_is_the_first_one_turned(
    best: Refined, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Lines that agree speak for one of the two; of another pose nearby they may be the wrong lines."""
    turn = Pose.turn_about(best.problem.model.middle, matrix_of(np.radians([0.0, 40.0, 0.0])))
    monkeypatch.setattr(rivals, "near_symmetries", lambda _: (turn,))
    found = [best, at(best, turned_by(POSE, 5.0)), at(best, best.pose.compose(turn))]
    told = rivals_of(found, ASYMMETRIC, lambda _: True, lambda _: 0.0)
    assert [one.turned for one in told] == [False, True]


def test_a_turn_counts_by_what_it_explains_where_it_is_turned_exactly(
    best: Refined, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Refined by itself it may explain less, by chance, though the same lines are seen."""
    turn = Pose.turn_about(best.problem.model.middle, matrix_of(np.array([0.0, 0.0, np.pi])))
    monkeypatch.setattr(rivals, "near_symmetries", lambda _: (turn,))
    some = best.support.supports & (np.arange(len(best.support.distance)) % 3 > 0)
    less = replace(best.support, supports=some)
    assert less.evidence < best.support.evidence - 10.0
    other = replace(at(best, best.pose.compose(turn)), support=less)
    for inside, nats in (True, 0.0), (False, -TURNED_NATS):
        told = rivals_of([best, other], ASYMMETRIC, lambda _, inside=inside: inside, lambda _: 0.0)
        of_turn = [one.nats for one in told if other.ends_at(one.pose, RIGHT)]
        assert of_turn == pytest.approx([nats], abs=1.0)


def test_what_a_symmetry_makes_of_a_pose_is_as_likely_within_the_range_and_not_beyond() -> None:
    beyond = beyond_of(POSE, CAMERA, SearchRange(25.0, 40.0))
    pose, about_x = turned_by(POSE, 20.0), [np.radians([angle, 0.0, 0.0]) for angle in (0.0, -40.0, 40.0)]
    turns = tuple(Pose(vector, np.zeros(3)) for vector in about_x)
    found = symmetric_images(pose, Symmetry(turns, None, np.zeros(3)), beyond)
    assert [one.nats for one in found] == [0.0]
    assert found[0].pose.error_to(turned_by(POSE, -20.0)).rotation_deg < 1e-6
    upside_down = Pose(np.array([0.0, np.pi, 0.0]), np.zeros(3))
    rod = Symmetry((turns[0], upside_down), np.array([1.0, 0.0, 0.0]), np.zeros(3))
    assert symmetric_images(pose, rod, beyond) == []


@pytest.mark.slow
@pytest.mark.parametrize("seed", [3, 4])
def test_a_dial_of_ten_equal_marks_is_not_trusted_with_a_seed_pose(tmp_path: Path, seed: int) -> None:
    """It may be turned by 36 degrees within the search range, and noise would tell which of them it is."""
    disc = manifold3d.Manifold.cylinder(0.03, 0.1, 0.1, 96)
    mark = manifold3d.Manifold.cylinder(0.02, 0.012, 0.012, 32)
    places = [(0.08 * np.cos(angle), 0.08 * np.sin(angle), 0.03) for angle in np.arange(10) * np.pi / 5]
    marks = manifold3d.Manifold.batch_boolean([mark.translate(one) for one in places], manifold3d.OpType.Add)
    solid = (disc + marks).to_mesh64()
    mesh = trimesh.Trimesh(solid.vert_properties[:, :3], solid.tri_verts, process=False)
    mesh.export(tmp_path / "dial.stl")
    scene = Simulator(tmp_path / "dial.stl", "nominal", seed)
    images = ImageSet(scene.camera.width, scene.camera.height)
    for name, lights in (("i1", (7, 7, 7)), ("i2", (7, 0, 2))):
        frame = scene.capture(Settings(lights=lights, shutter_s=1 / 60, aperture=5.6))
        images.add(name, frame.pixels, 1.0, 1.0)
    settings = PipelineSettings()
    estimate = estimate_pose(images, ["i1", "i2"], scene.model, scene.camera, scene.seed_pose, settings)
    assert estimate.pose is not None
    assert estimate.ambiguity == 1.0
    assert estimate.score < 0.6
