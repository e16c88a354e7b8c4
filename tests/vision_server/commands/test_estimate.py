"""`python -m vision_server estimate`: exit statuses, and one JSON object on stdout."""

import json
import subprocess
from pathlib import Path

import cv2
import numpy as np
import pytest

from geometry.model import load_model
from geometry.pose import Pose, disturbed
from tests.commands import ROOT, Done, command, process
from tests.vision_server.synthetic import (
    CAMERA,
    POSE,
    camera_file,
    cuboid,
    linear_picture,
    lines_alone,
    photographed,
)
from vision_server.commands import estimate as estimate_command
from vision_server.commands.warm import drawn
from vision_server.pipeline import SURE_SCORE

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("estimate")
    model = cuboid(path)
    picture = linear_picture(model, CAMERA, POSE, (0.3, 0.7, 0.2, 0.9, 0.5, 0.8))
    cv2.imwrite(str(path / "a.png"), photographed(picture, exposure=0.8))
    cv2.imwrite(str(path / "b.png"), photographed(picture, exposure=0.4, seed=1))
    cv2.imwrite(str(path / "black.png"), np.zeros((240, 320), np.uint8))
    cv2.imwrite(str(path / "small.png"), np.zeros((100, 100), np.uint8))
    cv2.imwrite(str(path / "thin.png"), np.zeros((240, 1), np.uint8))
    camera_file(path / "camera.toml")
    seed = disturbed(POSE, np.random.default_rng(0), 10.0, 10.0, CAMERA.fx)
    write_pose(path / "seed.toml", seed.rotation_vector.tolist(), seed.translation.tolist())
    return path


def write_pose(path: Path, rotation: list[float], translation: list[float]) -> None:
    path.write_text(f"[target.seed_pose]\nrotation_vector = {rotation}\ntranslation = {translation}\n")


def words_of(
    folder: Path,
    *images: str,
    seed_pose: str | None = "seed.toml",
    camera: str = "camera.toml",
    model: str = "cuboid.cao",
    **options: str,
) -> list[str]:
    words = ["estimate", "--model", str(folder / model), "--camera", str(folder / camera)]
    if seed_pose is not None:
        words += ["--seed-pose", str(folder / seed_pose)]
    for name, value in options.items():
        words += [f"--{name}", value] if value else [f"--{name}"]
    return words + [str(folder / image) for image in images]


def estimate(folder: Path, *images: str, **options: str | None) -> Done:
    return command("vision_server", *words_of(folder, *images, **options))


def test_one_json_object_with_the_pose(folder: Path) -> None:
    done = process("vision_server", *words_of(folder, "a.png", "b.png", exposures="0.8,0.4", json=""))
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    assert {"pose", "covariance", "rms_px", "lines", "seconds", "seed", "kept"} <= set(result)
    assert set(result["seconds"]) >= {"edges", "linking", "matching", "refinement", "total"}
    assert result["kept"] == ["i1", "i2"]
    assert [Path(file).name for file in result["files"].values()] == ["a.png", "b.png"]
    assert Pose.from_dict(result["pose"]).error_to(POSE).within(0.5, 0.005)


def test_a_part_that_may_be_off_its_model_has_a_less_certain_pose(folder: Path) -> None:
    camera = (folder / "camera.toml").read_text()
    for name, tolerance_m in (("exact", 0.0), ("told", 0.0001)):
        (folder / f"{name}.toml").write_text(camera + f"[target]\ntolerance_m = {tolerance_m}\n")
    exact, told, untold = (
        json.loads(estimate(folder, "a.png", camera=name, json="").stdout)
        for name in ("exact.toml", "told.toml", "camera.toml")
    )
    assert told["uncertainty"] > 1.5 * exact["uncertainty"]
    assert untold["uncertainty"] > 1.2 * exact["uncertainty"]
    assert untold["pose"] == exact["pose"]


def test_people_get_a_table(folder: Path) -> None:
    (folder / "lit [left].png").write_bytes((folder / "a.png").read_bytes())
    done = estimate(folder, "lit [left].png", overlay=str(folder / "over.png"))
    assert done.returncode == 0, done.stderr
    assert "lit [left].png" in done.stdout  # the file that shows a line best, by its own name
    drawn, plain = (cv2.imread(str(folder / name)) for name in ("over.png", "a.png"))
    assert 0.005 < np.any(np.not_equal(drawn, plain), axis=2).mean() < 0.2
    assert "translation" in done.stdout
    assert "RMS" in done.stdout
    assert "  trusted: " in done.stdout


def test_a_pose_is_trusted_where_a_session_would_end_with_it() -> None:
    goal = (
        "use_module(domain/reasoning/merit), default_threshold(Threshold), "
        f"merit(fix(_, _, quality(_, _, _, {SURE_SCORE!r}, _), _), Merit), "
        "abs(Merit - Threshold) < 1.0e-9"
    )
    assert subprocess.run(["swipl", "-g", goal, "-t", "halt"], cwd=ROOT, check=False).returncode == 0


def test_a_wrong_unit_is_suspected(folder: Path) -> None:
    done = estimate(folder, "a.png", unit="mm", json="")
    assert "(--unit m?)" in done.stderr
    assert json.loads(done.stdout)["pose"] is None


def test_no_pose_is_said_honestly(folder: Path) -> None:
    done = estimate(folder, "black.png", json="")
    assert done.returncode == 3, done.stderr
    assert json.loads(done.stdout)["pose"] is None
    assert "no pose: the images have 0 straight edges" in done.stderr


def test_a_wrong_focal_length_is_suspected(folder: Path) -> None:
    camera_file(folder / "focal.toml", fx=1.6 * CAMERA.fx, fy=1.6 * CAMERA.fy)
    done = estimate(folder, "a.png", camera="focal.toml", seed_pose=None)
    assert "fx, fy or distortion of the camera are wrong" in done.stderr, done.stdout
    assert estimate(folder, "a.png", seed_pose=None).stderr == ""


def test_no_pose_beside_a_wrong_seed_is_drawn_and_a_wider_search_finds_it(folder: Path) -> None:
    beside = POSE.translation + np.array([60.0 / CAMERA.fx * POSE.translation[2], 0.0, 0.0])
    write_pose(folder / "beside.toml", POSE.rotation_vector.tolist(), beside.tolist())
    over = folder / "seed.png"
    near = {"rotation-range-deg": "1", "translation-range-px": "1"}
    done = estimate(folder, "a.png", seed_pose="beside.toml", overlay=str(over), json="", **near)
    assert done.returncode == 3, done.stdout
    assert "within 1 degrees and 1 px of the seed pose" in done.stderr
    drawn, plain = (cv2.imread(str(file)) for file in (over, folder / "a.png"))
    assert np.any(np.not_equal(drawn, plain), axis=2).mean() > 0.002
    wide = {"translation-range-px": "90"}
    done = estimate(folder, "a.png", seed_pose="beside.toml", json="", **wide)
    assert Pose.from_dict(json.loads(done.stdout)["pose"]).error_to(POSE).within(0.5, 0.005)


def test_a_seed_outside_of_the_frame_is_said(folder: Path) -> None:
    away = POSE.translation + np.array([3.0 * POSE.translation[2], 0.0, 0.0])
    write_pose(folder / "away.toml", POSE.rotation_vector.tolist(), away.tolist())
    done = estimate(folder, "a.png", seed_pose="away.toml", json="")
    assert done.returncode == 3, done.stdout
    assert "no line of the model is in the frame" in done.stderr


def test_of_a_large_frame_that_part_is_looked_at_where_the_target_can_be(folder: Path) -> None:
    camera = CAMERA.scaled(6.0)
    picture = drawn(cuboid(folder), camera, POSE, 0.8)
    picture[:, :200:20] = 200  # nothing of the target's: hundreds of edges
    cv2.imwrite(str(folder / "large.png"), picture)
    table = "".join(f"{key} = {value}\n" for key, value in camera.to_dict().items())
    (folder / "large.toml").write_text("[camera]\n" + table)
    aside = POSE.translation + np.array([100.0 / camera.fx * POSE.translation[2], 0.0, 0.0])
    write_pose(folder / "aside.toml", POSE.rotation_vector.tolist(), aside.tolist())
    over = str(folder / "l.png")
    options = {"camera": "large.toml", "seed_pose": "aside.toml", "json": "", "overlay": over}
    done = estimate(folder, "large.png", **options)
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    assert Pose.from_dict(result["pose"]).error_to(POSE).within(0.2, 0.002)
    assert result["segments"] < 40
    shown = cv2.imread(over)
    assert shown is not None
    assert shown.shape == (1440, 1920, 3)


@pytest.mark.parametrize(
    ("images", "options", "word"),
    [
        (["missing.png"], {}, "missing.png"),
        (["a.png", "small.png"], {}, "small.png"),
        (["small.png"], {}, "small.png has 100x100 px, the camera"),
        (["thin.png"], {}, "thin.png"),
        (["cut.png"], {}, "cut.png is not an image that can be read"),
        (["missing.png"], {"overlay": "/nowhere/o.png"}, "Cannot write /nowhere/o.png: there is no folder"),
        (["a.png"], {"model": "."}, "is a folder"),
        (["a.png"], {"translation-range-px": "-3"}, "--translation-range-px: must be at least 0, not -3"),
        (["camera.toml"], {}, "camera.toml"),
        (["a.png"], {"exposures": "1,2"}, "exposures"),
        (["a.png"], {"exposures": "-1"}, "exposures"),
        (["a.png"], {"seed_pose": "nan.toml"}, "finite"),
        (["a.png"], {"seed_pose": "behind.toml"}, "behind"),
        (["a.png"], {"seed_pose": "camera.toml"}, "rotation_vector"),
        (["a.png"], {"matcher": "luck"}, "luck"),
        (["a.png"], {"overlay": "a.xyz"}, "Cannot write pictures of the kind '.xyz'"),
        (["a.png"], {"seed_pose": None, "rotation-range-deg": "5"}, "--rotation-range-deg is how far around"),
        (["a.png"], {"seed_pose": None, "translation-range-px": "5"}, "--translation-range-px is how far"),
        (["a.png"], {"gamma": "0"}, "gamma"),
        (["a.png"], {"camera": "loose.toml"}, "tolerance_m must be a number from 0 to"),
        (["a.png"], {"camera": "millimetres.toml", "seed_pose": None}, "range_m = [400, 440]"),
        (["a.png"], {"camera": "range.toml"}, "unknown key `range` in [target]. Did you mean range_m?"),
        (
            ["a.png"],
            {"camera": "misspelt.toml"},
            "unknown key `distorsion` in [camera]. Did you mean distortion?",
        ),
    ],
)
def test_bad_input_is_one_plain_line(
    folder: Path, images: list[str], options: dict[str, str | None], word: str
) -> None:
    whole = (folder / "a.png").read_bytes()
    (folder / "cut.png").write_bytes(whole[: len(whole) // 2])
    (folder / "nan.toml").write_text(
        "[target.seed_pose]\nrotation_vector = [nan, 0, 0]\ntranslation = [0, 0, 1]\n"
    )
    write_pose(folder / "behind.toml", [0.0, 0.0, 0.0], [0.0, 0.0, -1.0])
    camera = (folder / "camera.toml").read_text()
    (folder / "loose.toml").write_text(camera + "[target]\ntolerance_m = -0.001\n")
    (folder / "millimetres.toml").write_text(camera + "[target]\nrange_m = [400, 440]\n")
    (folder / "range.toml").write_text(camera + "[target]\nrange = [0.5, 2.0]\n")
    (folder / "misspelt.toml").write_text(camera.replace("distortion", "distorsion"))
    done = estimate(folder, *images, **options)
    assert done.returncode == 2, done.stdout + done.stderr
    assert word in done.stderr
    assert "Traceback" not in done.stderr
    assert done.stdout == ""


def test_without_a_seed_pose_all_poses_that_fit_are_told(folder: Path) -> None:
    """A cuboid looks the same after half turns: four poses, as probable as each other, none of them sure."""
    done = estimate(folder, "a.png", seed_pose=None, json="")
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    poses = [Pose.from_dict(one["pose"]) for one in result["poses"]]
    assert sum(pose.error_to(POSE).within(0.5, 0.005) for pose in poses) == 1
    probabilities = [one["probability"] for one in result["poses"]]
    assert len(poses) == 4
    assert probabilities == pytest.approx([probabilities[0]] * 4)
    assert sum(probabilities) <= 1.0
    assert result["score"] <= probabilities[0] + 1e-9
    assert "free" not in result


@pytest.mark.parametrize(("range_m", "said"), [([0.4, 0.44], False), ([0.8, 0.9], True)])
def test_a_pose_at_another_distance_than_was_told_is_said(
    folder: Path, range_m: list[float], said: bool
) -> None:
    text = (folder / "camera.toml").read_text()
    (folder / "told.toml").write_text(f"{text}[target]\nrange_m = {range_m}\n")
    done = estimate(folder, "a.png", seed_pose=None, camera="told.toml", json="")
    assert done.returncode == 0, done.stderr
    assert ("m away; [target] range_m says" in done.stderr) == said


def test_a_wrong_unit_is_what_is_said_with_a_seed_pose_and_without(folder: Path) -> None:
    seeded = estimate(folder, "a.png", unit="mm")
    assert seeded.returncode == 3
    assert "Check the model's unit" in seeded.stderr
    assert "Correct the seed pose" not in seeded.stderr
    done = estimate(folder, "a.png", seed_pose=None, unit="mm")
    assert "0.000141 m across" in done.stderr
    assert "--unit is wrong" in done.stderr


def test_lines_alone_are_found_too_and_what_they_leave_out_is_said(folder: Path) -> None:
    lines = lines_alone(load_model(folder / "cuboid.cao"), folder)
    done = estimate(folder, "a.png", "b.png", model=lines.name, exposures="0.8,0.4", json="")
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("no faces") == 1
    assert Pose.from_dict(json.loads(done.stdout)["pose"]).error_to(POSE).within(0.5, 0.005)


def test_lines_for_people_are_not_broken_and_say_first_of_how_many_poses_it_is_one(
    capsys: pytest.CaptureFixture[str],
) -> None:
    pose = {"rotation_vector": [0.1, 0.2, 0.3], "translation": [0.015, 0.001, 0.666]}
    others = [{"pose": pose, "probability": share} for share in (0.5, 0.25, 0.25)]
    numbers = {"rms_px": 0.1, "supported_fraction": 1.0, "score": 0.5, "ambiguity": 0.0, "segments": 139}
    result = {"target": "cube", "pose": pose, "covariance": np.eye(6).tolist(), "poses": others, **numbers}
    estimate_command._print(result | {"lines": [], "seconds": {f"stage {k}": 1.0 for k in range(10)}}, 0.1732)
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "Pose of cube (camera_T_target), 0.173 m across"
    many = lines.index("  one of 3 poses that fit, its probability 50 %")
    assert lines[many + 1].endswith("139 segments")
    assert lines[many + 2].startswith("  not trusted: the score is the chance that it is right")
    assert all(line.endswith("+0.015  +0.001  +0.666") for line in lines if line.startswith("  or, 25 %"))
    assert lines[-1].endswith("stage 9 1000 ms")
