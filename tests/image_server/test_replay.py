"""Replay of stack folders: the formula, recorded frames, and every way in which a folder can be wrong."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from bridge.errors import BadInput, Unsupported
from bridge.messages import PoseMessage, Settings
from image_server.replay import Replay
from stack.read import BasisStack, FramesStack, load_stack, with_conditions
from tests.stack.stack_folders import BASIS, FRAMES, LEVELS, basis_stack, frames_stack
from tests.turned_jpeg import write_turned_jpeg

SETTINGS = Settings(lights=(3, 0), shutter_s=1 / 60, aperture=4.0)


def test_a_basis_frame_is_the_formula(tmp_path: Path) -> None:
    replay = Replay(load_stack(basis_stack(tmp_path)), seed=1)
    frame = replay.capture(SETTINGS)
    # a light with one level is on
    signal = (3 / 7 * LEVELS["left"] + 0.5 * LEVELS["right"] + 2 * LEVELS["sun"]) / 65535
    assert frame.pixels.dtype == np.uint8
    assert np.abs(frame.pixels - 255 * signal).max() <= 0.51
    assert frame.sequence == 1
    assert frame.requested == SETTINGS


def test_the_sun_and_the_lights_can_be_changed(tmp_path: Path) -> None:
    stack = load_stack(basis_stack(tmp_path))
    assert isinstance(stack, BasisStack)
    dark = Replay(with_conditions(stack, ambient_scale=0.0, light_power=2.0)).capture(SETTINGS)
    signal = 2 * (3 / 7 * LEVELS["left"] + 0.5 * LEVELS["right"]) / 65535
    assert np.abs(dark.pixels - 255 * signal).max() <= 0.51


@pytest.mark.parametrize(
    ("blur", "message"),
    [
        ({"defocus_sigma_px": 1e9}, r"The stack .*: defocus_sigma_px blurs over 1e\+09 px, and the"),
        ({"motion_px_per_s": (1e9, 0.0)}, r"motion_px_per_s blurs over 6.67e\+07 px in 0.0667 s"),
    ],
)
def test_a_blur_that_is_larger_than_the_frame_is_refused(
    tmp_path: Path, blur: dict[str, Any], message: str
) -> None:
    """The first capture ran out of memory."""
    stack = load_stack(basis_stack(tmp_path))
    assert isinstance(stack, BasisStack)
    with pytest.raises(BadInput, match=message):
        Replay(with_conditions(stack, **blur))


def test_recorded_frames_come_bit_for_bit_and_in_turn(tmp_path: Path) -> None:
    replay = Replay(load_stack(frames_stack(tmp_path)))
    twice = Settings(lights=(7, 0), shutter_s=1 / 30, aperture=5.6)
    seen = [replay.capture(twice).pixels for _ in range(3)]
    for pixels, name in zip(seen, "bcb", strict=True):
        recorded = cv2.imread(str(tmp_path / f"{name}.png"), cv2.IMREAD_GRAYSCALE)
        assert recorded is not None
        assert np.array_equal(pixels, recorded)


def test_recorded_frames_of_sixteen_bits_keep_them(tmp_path: Path) -> None:
    stack = load_stack(frames_stack(tmp_path))
    assert isinstance(stack, FramesStack)
    deep = np.random.default_rng(1).integers(0, 4096, (24, 32), np.uint16)
    cv2.imwrite(str(tmp_path / stack.table.frames[0].image), deep)
    replay = Replay(load_stack(tmp_path))
    np.testing.assert_array_equal(replay.capture(stack.table.frames[0].settings()).pixels, deep)


def test_recorded_photographs_are_turned_as_their_camera_was_held(tmp_path: Path) -> None:
    folder = frames_stack(tmp_path, FRAMES.replace("a.png", "a.jpg"))
    image = np.zeros((32, 24), np.uint8)
    image[16:] = 200
    write_turned_jpeg(folder / "a.jpg", image)
    seen = Replay(load_stack(folder)).capture(Settings(lights=(0, 7), shutter_s=1 / 60, aperture=4.0)).pixels
    assert seen.shape == (24, 32)
    assert seen[:, :12].min() > 150
    assert seen[:, 20:].max() < 50


def test_settings_that_were_not_recorded_name_the_nearest(tmp_path: Path) -> None:
    replay = Replay(load_stack(frames_stack(tmp_path)))
    with pytest.raises(BadInput, match=r"Nearest: lights \[0, 7\], 0.0166667 s, f/4;"):
        replay.capture(Settings(lights=(1, 7), shutter_s=1 / 60, aperture=4.0))


def test_the_nearest_frame_that_was_not_shown_serves_when_that_is_wanted(tmp_path: Path) -> None:
    stack = load_stack(frames_stack(tmp_path))
    asked = Settings(lights=(1, 7), shutter_s=1 / 60, aperture=4.0)
    replay = Replay(stack, nearest=True)
    frames = [replay.capture(asked) for _ in range(4)]
    assert [frame.applied.lights for frame in frames] == [(0, 7), (7, 0), (7, 0), (0, 7)]
    assert not np.array_equal(frames[1].pixels, frames[2].pixels)
    assert not any(frame.verified for frame in frames)
    assert all(frame.requested == asked for frame in frames)
    assert Replay(stack, nearest=True).capture(frames[0].applied).verified


def test_frames_that_a_session_has_seen_do_not_come_again_when_it_goes_on(tmp_path: Path) -> None:
    stack = load_stack(frames_stack(tmp_path))
    twice = Settings(lights=(7, 0), shutter_s=1 / 30, aperture=5.6)
    whole = Replay(stack)
    expected = [whole.capture(twice).pixels for _ in range(2)]
    resumed = Replay(stack, captures_taken=1, shown=[twice, twice])  # one was saved, but never heard of
    assert np.array_equal(resumed.capture(twice).pixels, expected[1])


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (Settings(lights=(8, 0), shutter_s=1 / 60, aperture=4.0), "'left' has no level 8. Allowed: 0 to 7"),
        (Settings(lights=(1,), shutter_s=1 / 60, aperture=4.0), "1 light levels.*2 lights"),
        (
            Settings(lights=(1, 0), shutter_s=1.0, aperture=4.0),
            "shutter_s = 1 is not offered. Allowed: 0.00416",
        ),
        (
            Settings(lights=(1, 0), shutter_s=1 / 60, aperture=8.0),
            "aperture = 8 is not offered. Allowed: 2.8, 4",
        ),
        (Settings(lights=(1, 0), shutter_s=1 / 60, aperture=4.0, focus_m=1.0), "focus_m.*fixed"),
    ],
)
def test_what_is_not_offered_is_an_error_and_never_clipped(
    tmp_path: Path, settings: Settings, message: str
) -> None:
    with pytest.raises(BadInput, match=message):
        Replay(load_stack(basis_stack(tmp_path))).capture(settings)


def test_score_knows_the_true_pose_and_describe_does_not_tell_it(tmp_path: Path) -> None:
    replay = Replay(load_stack(basis_stack(tmp_path)))
    target = replay.describe().target
    assert target is not None and target.seed_pose is not None
    assert target.seed_pose.rotation_vector == (0.1, 0.0, 0.0)
    error = replay.score(PoseMessage(rotation_vector=(0.0, 0.0, 0.0), translation=(0.0, 0.0, 1.1)))
    assert error is not None
    assert error.translation_fraction_of_range == pytest.approx(0.1)
    with pytest.raises(Unsupported, match="cannot move"):
        replay.move(0.5)


def without(text: str) -> Callable[[str], str]:
    return lambda stack: stack.replace(text, "")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (without('kind = "basis"'), "stack.toml has no key kind"),
        (without('ambient = "sun.png"'), "has no key ambient"),
        (lambda stack: stack.replace('"right"', '"left"'), "two lights are called 'left'"),
        (without("width = 32"), r"missing.*`width` in \[camera\]"),
        (without('model = "box.cao"'), r"has no \[target\] model"),
        (lambda s: s.replace("box.cao", "none.cao"), "there is no file .*none.cao"),
        (lambda s: s.replace("fx = 40.0", "fx = 40.0\nfz = 1"), r"unknown key `fz` in \[camera\]"),
        (lambda s: s.replace("levels = 8", 'levels = "8"'), r"expected `int`.*\[lights 1.levels\]"),
        (lambda s: s.replace("levels = 8", "levels = 0"), r">= 1.*\[lights 1.levels\]"),
        (lambda s: s.replace('"left.png"', '"none.png"'), "'left' radiance: there is no file .*none.png"),
        (lambda s: s.replace("width = 32", "width = 31"), r"left.png is 32×24 px, but \[camera\] says 31×24"),
        (lambda s: s.replace("[camera]", "[camera"), "is not valid TOML"),
    ],
)
def test_a_wrong_stack_says_what_and_where(
    tmp_path: Path, change: Callable[[str], str], message: str
) -> None:
    with pytest.raises(BadInput, match=message):
        load_stack(basis_stack(tmp_path, change(BASIS)))


def test_a_basis_image_of_eight_bits_is_refused(tmp_path: Path) -> None:
    basis_stack(tmp_path)
    cv2.imwrite(str(tmp_path / "left.png"), np.zeros((24, 32), np.uint8))
    with pytest.raises(BadInput, match=r"left.png has 8 bits a pixel"):
        load_stack(tmp_path)


def test_a_frame_with_too_few_levels_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=r"\[\[frames\]\] 2 gives 1 light levels, not 2"):
        load_stack(frames_stack(tmp_path, FRAMES.replace("lights = [7, 0]", "lights = [7]", 1)))


def test_a_run_folder_is_told_from_the_stack_in_it(tmp_path: Path) -> None:
    (tmp_path / "images").mkdir()
    frames_stack(tmp_path / "images")
    with pytest.raises(BadInput) as refused:
        load_stack(tmp_path)
    assert str(refused.value) == (
        f"{tmp_path} is a run folder, and not a stack folder. Its frames are one: give {tmp_path / 'images'}."
    )


def test_recorded_stacks_are_read(shared_data: Path) -> None:
    for folder in sorted((shared_data / "stacks").iterdir()):
        replay = Replay(load_stack(folder), seed=1)
        settings = Settings(lights=(4, 4, 4), shutter_s=1 / 60, aperture=4.0)
        assert replay.capture(settings).pixels.shape == (480, 640)
