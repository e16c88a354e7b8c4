import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks.chessboards import (
    CORNERS,
    HALF_TURN,
    RIM,
    SQUARE_M,
    WHOLE,
    begins_black,
    board,
    grid,
    main,
    of_corners,
)
from geometry.camera import Camera
from geometry.pose import Pose
from tests.vision_server.boards import photographed, rays_of, write_boards

CAMERA = Camera(640, 480, 600.0, 601.0, 322.0, 238.0, (-0.2, 0.05, 0.0, 0.0, 0.0))
POSE = Pose(np.array([0.3, -0.2, 0.1]), np.array([0.01, -0.02, 0.5]))


def test_a_board_is_its_black_squares_and_is_cut_at_the_rim() -> None:
    whole, cut = board(WHOLE), board(RIM)
    assert len(whole.lines) == len(cut.lines) == 4 * (CORNERS[0] + 1) * (CORNERS[1] + 1) // 2
    np.testing.assert_allclose(np.ptp(whole.vertices, axis=0)[:2], [10 * SQUARE_M, 7 * SQUARE_M])
    np.testing.assert_allclose(np.ptp(cut.vertices, axis=0)[:2], [9.01 * SQUARE_M, 6.9 * SQUARE_M])


def test_corners_tell_the_pose_and_how_far_it_may_be_off() -> None:
    rng = np.random.default_rng(4)
    steps, spreads = [], []
    for _ in range(40):
        seen = CAMERA.project(POSE.apply(grid())) + rng.normal(0.0, 0.2, (CORNERS[0] * CORNERS[1], 2))
        found, spread = of_corners(CAMERA, seen)
        steps.append(POSE.step_from(found))
        spreads.append(spread)
    normalised = [step @ np.linalg.solve(spread, step) for step, spread in zip(steps, spreads, strict=True)]
    assert 4.0 < np.mean(normalised) < 8.0


def test_the_end_at_which_corners_begin_is_told_by_the_squares() -> None:
    unit = Pose(POSE.rotation_vector, POSE.translation / SQUARE_M)
    begins = Pose(np.zeros(3), np.array([*-np.array([CORNERS[0] - 1, CORNERS[1] - 1]) / 2.0, 0.0]))
    image = photographed(CAMERA, rays_of(CAMERA), unit.compose(begins), CORNERS, np.random.default_rng(1))
    assert begins_black(image, CAMERA, POSE)
    assert not begins_black(image, CAMERA, POSE.compose(HALF_TURN))


@pytest.mark.slow
def test_poses_of_drawn_boards_are_those_of_their_corners(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for number, file in enumerate(write_boards(tmp_path / "drawn", CAMERA, CORNERS, 5), 1):
        for name in ("left", "right"):
            cv2.imwrite(str(tmp_path / f"{name}{number:02d}.jpg"), cv2.imread(str(file)))
    main(tmp_path, starts=1, whole=True)
    rows = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert rows[-1]["estimates"] == rows[-1]["right"] == len(rows) - 1 == 10
    assert rows[-1]["wrong_and_trusted"] == 0 and max(row["degrees"] for row in rows[:-1]) < 0.3
