"""A model that is mirrored or upside down, and shows its plain back or the part's, is not believed."""

from typing import Any

import numpy as np
import pytest

from geometry.deformed import deformed
from geometry.model import Model, find_target, load_model
from geometry.pose import Pose
from tests.vision_server.synthetic import CAMERA, POSE, SIZE_M, boxes, linear_picture, one_image, photographed
from vision_server import pipeline
from vision_server.matching.search import match_near
from vision_server.pipeline import estimate_pose
from vision_server.trust import other_hand, ranking, rivals
from vision_server.trust.judgement import Estimate
from vision_server.trust.other_hand import other_ways
from vision_server.trust.probability import confidence
from vision_server.trust.stretch import stretched

GREYS = (0.3, 0.7, 0.2, 0.9, 0.5, 0.8)


@pytest.fixture(scope="module")
def part(tmp_path_factory: pytest.TempPathFactory) -> Model:
    """The cuboid with two blocks on the side that is turned to the camera."""
    half = 0.5 * np.array(SIZE_M)
    ends = [[[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]], [[-0.7, -0.6, -1.4], [0.5, 0.2, -1.0]],
            [[0.6, -0.6, -1.2], [0.8, 0.5, -1.0]]]  # fmt: skip
    return boxes(tmp_path_factory.mktemp("part"), [(low * half, high * half) for low, high in np.array(ends)])


@pytest.fixture(scope="module")
def plate(tmp_path_factory: pytest.TempPathFactory) -> Model:
    """The cuboid with three lower blocks on that side: many short lines."""
    half = 0.5 * np.array(SIZE_M)
    ends = [[[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]], [[-0.8, -0.8, -1.25], [-0.3, -0.1, -1.0]],
            [[0.1, -0.7, -1.2], [0.6, 0.4, -1.0]], [[-0.6, 0.2, -1.15], [-0.1, 0.8, -1.0]]]  # fmt: skip
    return boxes(
        tmp_path_factory.mktemp("plate"), [(low * half, high * half) for low, high in np.array(ends)]
    )


def estimated(part: Model, model: Model) -> Estimate:
    picture = photographed(linear_picture(part, CAMERA, POSE, GREYS * 4))
    return estimate_pose(one_image(picture), ["i1"], model, CAMERA, POSE)


def test_a_mirrored_model_whose_back_fits_is_not_believed(part: Model) -> None:
    assert estimated(part, part).score > 0.93
    for way in ([1.0, 1.0, -1.0], [1.0, -1.0, -1.0]):
        found = estimated(part, deformed(part, np.diag(way)))
        assert found.score < 0.6


@pytest.mark.parametrize("way", [[1.0, 1.0, -1.0], [1.0, -1.0, -1.0]])
def test_a_model_whose_front_lies_where_the_part_has_its_plain_back_is_not_believed(
    plate: Model, way: list[float], monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in (ranking, rivals):  # a turned rival alone says as much
        monkeypatch.setattr(module, "near_symmetries", lambda _: ())
    found = estimated(deformed(plate, np.diag(way)), plate)
    assert found.support is not None
    assert found.misfit is not None
    assert found.uncertainty is not None
    assert found.support.missing > 0.3
    assert confidence(found.support, 0.0, found.uncertainty) > 0.9  # but for the look
    assert found.misfit.otherwise > 10.0
    assert found.score < 0.1
    assert found.ambiguity == 1.0


@pytest.mark.parametrize("right_of_middle_px", [-20, -5, 0])
def test_a_part_of_which_much_is_hidden_is_still_the_right_way_round(
    plate: Model, right_of_middle_px: int
) -> None:
    """A plain back would miss less, but explain less as well."""
    picture = photographed(linear_picture(plate, CAMERA, POSE, GREYS * 4))
    picture[:, : CAMERA.width // 2 + right_of_middle_px] = 20
    found = estimate_pose(one_image(picture), ["i1"], plate, CAMERA, POSE)
    assert found.pose is not None
    assert found.support is not None
    assert found.misfit is not None
    assert found.pose.error_to(POSE).within(1.0, 0.01)
    assert found.support.missing > 0.3
    assert found.misfit.otherwise < 0.01


def test_the_other_way_is_found_at_the_pose_itself(part: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the body is alike on both sides, what stands on it is hardly among the segments."""
    for module in (ranking, rivals):  # a turned rival alone says as much
        monkeypatch.setattr(module, "near_symmetries", lambda _: ())
    monkeypatch.setattr(pipeline, "match_near", lambda *args: [[] for _ in args[3]])
    found = estimated(part, deformed(part, np.diag([-1.0, 1.0, 1.0])))
    assert found.pose is not None
    assert found.misfit is not None
    assert found.pose.error_to(POSE).within(1.0, 0.01)
    assert found.misfit.otherwise > 1.0
    assert estimated(part, part).score > 0.93


@pytest.mark.parametrize(("share", "looked_at"), [(0.97, True), (0.9, False)])
def test_another_way_that_matches_nearly_as_well_is_worth_a_look(
    plate: Model, share: float, looked_at: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    def matched(*args: Any) -> list[list[tuple[float, Pose]]]:
        itself, *others = match_near(*args)
        pose = itself[0][1]
        most = max(score for one in others for score, _ in one)
        return [[(most / share, pose), *itself[1:]], *others]

    for module in (ranking, rivals):  # a turned rival alone says as much
        monkeypatch.setattr(module, "near_symmetries", lambda _: ())
    monkeypatch.setattr(pipeline, "match_near", matched)
    monkeypatch.setattr(other_hand, "_is_likely_here", lambda *_: False)
    found = estimated(deformed(plate, np.diag([1.0, 1.0, -1.0])), plate)
    assert found.misfit is not None
    assert (found.misfit.otherwise > 10.0) == looked_at


def test_a_satellite_upside_down_is_not_believed_where_all_that_it_shows_is_seen() -> None:
    """What stands on it is behind it then, and all of its lines lie on lines of the right one."""
    satellite = load_model(find_target("satellite"))
    pose = Pose(np.array([0.73, 0.225, -0.484]), np.array([-0.036, -0.054, 0.972]))
    greys = np.random.default_rng(7).uniform(0.15, 0.95, len(satellite.faces))
    images = one_image(photographed(linear_picture(satellite, CAMERA, pose, greys)))
    upright, over = (
        estimate_pose(images, ["i1"], model, CAMERA, pose)
        for model in (satellite, deformed(satellite, np.diag([1.0, -1.0, -1.0])))
    )
    assert upright.score > 0.93
    assert over.support is not None
    assert over.support.missing < 0.01
    assert over.score < 0.6


def test_a_mirror_that_changes_nothing_is_no_other_way(plate: Model, model: Model) -> None:
    assert other_ways(model) == ()
    assert len(other_ways(plate)) == 6
    assert len(other_ways(stretched(model, np.array([0.0, 0.0, 0.0, 0.2, 0.0, 0.0])))) == 1


def test_a_true_model_is_believed_from_its_plain_back(part: Model, model: Model) -> None:
    """The part as seen from behind is the cuboid alone: that it is not turned the seed pose alone tells."""
    behind = deformed(part, np.diag([1.0, 1.0, -1.0]))
    assert len(estimated(model, behind).lines) <= 9
    assert estimated(model, behind).score > 0.9


def test_a_mirrored_model_is_a_body_whose_faces_look_outwards() -> None:
    model = load_model(find_target("fixture"))
    mirrored = deformed(model, np.diag([-1.0, 1.0, 1.0]))
    corners = mirrored.vertices[mirrored.triangles]
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum()
    assert volume > 0.0
    np.testing.assert_allclose(mirrored.face_normals, model.face_normals * [-1.0, 1.0, 1.0], atol=1e-12)
    np.testing.assert_allclose(mirrored.middle, model.middle, atol=1e-12)
