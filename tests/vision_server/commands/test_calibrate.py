"""`python -m vision_server calibrate`: the camera that took the boards, or what is wrong with them."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from bridge.command_line import run_command
from geometry.camera import Camera
from tests.vision_server.boards import board_pose, photographed, rays_of, write_boards
from vision_server.__main__ import COMMANDS
from vision_server.calibration import board_corners, calibrated, drawn_board
from vision_server.channels.image_files import read_grey
from vision_server.serve.inputs import read_camera

CORNERS = (7, 5)
TRUE = Camera(480, 360, 560.0, 565.0, 236.0, 184.0, (-0.12, 0.05, 0.001, -0.002, 0.0))


@pytest.fixture(scope="module")
def boards(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    return write_boards(tmp_path_factory.mktemp("boards"), TRUE, CORNERS, 9)


def run(*words: str | Path) -> int:
    return run_command("vision_server", "", COMMANDS, ["calibrate", *map(str, words)])


@pytest.mark.slow
def test_finds_the_camera_that_took_the_boards(
    boards: list[Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    blank = tmp_path / "blank.png"
    cv2.imwrite(str(blank), np.full((360, 480), 90, np.uint8))
    assert run(*boards, blank, "--corners", "7x5", "--out", tmp_path / "camera.toml") == 0
    told = capsys.readouterr()
    assert f"no whole board in {blank}" in told.err
    assert "9 boards" in told.out
    found, _ = read_camera(tmp_path / "camera.toml")
    assert (found.width, found.height) == (480, 360)
    assert found.fx == pytest.approx(TRUE.fx, rel=3e-3)
    rng = np.random.default_rng(5)
    points = np.column_stack([rng.uniform(-0.35, 0.35, 50), rng.uniform(-0.25, 0.25, 50), np.ones(50)])
    apart = found.project(points) - TRUE.project(points)
    turned = apart.mean(axis=0)  # the middle of the image is what boards tell least
    assert np.abs(turned).max() < 3.0  # px, over the frame
    assert np.abs(apart - turned).max() < 0.7


def test_corners_of_a_soft_board_are_placed_to_a_fortieth_of_a_pixel() -> None:
    """Those by which it is found are 0.07 px off."""
    camera, corners, off = Camera(640, 480, 800.0, 800.0, 322.0, 244.0), (9, 6), []
    grid = np.column_stack([np.mgrid[:9, :6].T.reshape(-1, 2), np.zeros(54)])
    for number in range(3):
        rng = np.random.default_rng(number)
        pose = board_pose(rng, corners)
        sharp = photographed(camera, rays_of(camera), pose, corners, rng)
        found = board_corners(cv2.GaussianBlur(sharp, (0, 0), 1.2), corners)
        assert found is not None
        places, true = found.reshape(-1, 2), camera.project(pose.apply(grid))
        off.append(min(places - true, places[::-1] - true, key=lambda apart: float(np.abs(apart).max())))
    assert np.sqrt(np.mean(np.concatenate(off) ** 2)) < 0.025


@pytest.mark.slow
def test_boards_of_a_camera_of_twelve_bits_tell_the_same(boards: list[Path], tmp_path: Path) -> None:
    deep = [tmp_path / f"{board.stem}.tiff" for board in boards[:5]]
    for board, file in zip(boards, deep, strict=False):
        cv2.imwrite(str(file), np.uint16(16) * read_grey(board))
    found = {}
    for name, files in (("plain", boards[:5]), ("deep", deep)):
        assert run(*files, "--corners", "7x5", "--out", tmp_path / name) == 0
        found[name], _ = read_camera(tmp_path / name)
    assert found["deep"].fx == pytest.approx(found["plain"].fx, rel=2e-3)


@pytest.mark.slow
def test_a_fisheye_is_told_from_a_plain_lens(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    true = Camera(640, 480, 260.0, 262.0, 316.0, 244.0, (-0.02, 0.004, -0.003, 0.0006), "fisheye")
    boards = write_boards(tmp_path / "boards", true, CORNERS, 9, nearer=0.35)
    assert run(*boards, "--corners", "7x5", "--out", tmp_path / "camera.toml") == 0
    found, _ = read_camera(tmp_path / "camera.toml")
    assert found.lens == "fisheye"
    focal_sd = 0.01 * float(capsys.readouterr().out.rpartition(" px to ")[2].removesuffix(" %\n"))
    assert 0.0 < focal_sd < 0.005
    assert found.fx == pytest.approx(true.fx, rel=3.0 * focal_sd)


@pytest.mark.slow
def test_corners_of_a_large_image_are_placed_in_all_its_pixels(
    boards: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    images = {board.name: read_grey(board) for board in boards[:6]}
    whole = calibrated(images, CORNERS)
    monkeypatch.setattr("vision_server.calibration.SEARCHED_PX", 240)
    halved = calibrated(images, CORNERS)
    assert halved.seen == whole.seen
    assert halved.rms_px < 1.3 * whole.rms_px
    assert halved.camera["fx"] == pytest.approx(TRUE.fx, rel=3.0 * halved.focal_sd)


@pytest.mark.slow
def test_too_few_boards_are_refused(
    boards: list[Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(*boards[:4], "--corners", "7x5", "--out", tmp_path / "camera.toml") == 2
    assert "found in 4 of 4" in capsys.readouterr().err
    assert run(*boards[:6], "--corners", "9x6", "--out", tmp_path / "camera.toml") == 2
    assert "found in 0 of 6" in capsys.readouterr().err
    assert not (tmp_path / "camera.toml").exists()


@pytest.mark.parametrize("words", [(), ("a.png",), ("a.png", "--corners", "9"), ("--board", "b.xyz")])
def test_wrong_words_are_said(words: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    assert run(*words) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_the_board_to_print_is_one_that_is_found(tmp_path: Path) -> None:
    assert run("--board", tmp_path / "board.png", "--corners", "7x5", "--square-mm", "10") == 0
    board = read_grey(tmp_path / "board.png")
    np.testing.assert_array_equal(board, drawn_board(CORNERS, 10.0))
    assert board.shape == ((5 + 1 + 2) * 118, (7 + 1 + 2) * 118)  # 10 mm are 118 dots
    assert cv2.findChessboardCornersSB(board, CORNERS)[0]
