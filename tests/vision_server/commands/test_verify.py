"""`python -m vision_server verify`: a run folder is what it says, or what differs is named."""

import json
import shutil
import warnings
from pathlib import Path
from typing import Any

import cv2
import pytest

from tests.commands import Done, command, process
from tests.session.scenes import small
from tests.session.serving import served

pytestmark = pytest.mark.slow


def verify(*arguments: str | Path) -> Done:
    return command("vision_server", "verify", *arguments)


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One of several images, of which some are discarded."""
    out = tmp_path_factory.mktemp("verify") / "run"
    done = served(
        "--controller", "heuristic", "--target", "satellite", "--scenario", small("harsh"), "--seed", "2",
        "--threshold", "0.000001", "--max-iterations", "6", "--no-report", "--quiet", "--out", out,
    )  # fmt: skip
    assert done.returncode == 3, done.stderr
    result = json.loads((out / "result.json").read_text())
    assert result["discarded"]
    assert len(result["kept"]) > 1
    return out


@pytest.fixture
def copy(session: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(session, tmp_path / "run"))


def changed(folder: Path, **values: Any) -> None:
    file = folder / "result.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | values))


def test_a_session_is_as_it_states_wherever_its_folder_is(session: Path, copy: Path) -> None:
    stated = json.loads((session / "result.json").read_text())
    done = process("vision_server", "verify", copy, "--json")
    assert done.returncode == 0, done.stderr + done.stdout
    found = json.loads(done.stdout)
    assert found["as_stated"]
    assert set(found["images"]) <= set(stated["kept"])
    assert found["estimate"]["pose"] == stated["pose"]
    assert "as stated" in verify(copy).stdout


def test_a_changed_image_is_named(copy: Path) -> None:
    image = copy / "images" / f"{json.loads((copy / 'result.json').read_text())['kept'][0]}.png"
    pixels = cv2.imread(str(image), cv2.IMREAD_GRAYSCALE)
    cv2.imwrite(str(image), 255 - pixels[::-1])
    done = verify(copy)
    assert done.returncode == 1
    assert f"Differs: {image} is not the file that it was." in done.stdout


def test_a_changed_model_or_list_of_settings_is_named(copy: Path) -> None:
    for name in ("satellite.cao", "stack.toml"):
        file = copy / "images" / name
        text = file.read_text()
        file.write_text(text + "\n# changed\n")
        done = verify(copy)
        assert done.returncode == 1
        assert f"{file} is not the file that it was" in done.stdout
        file.write_text(text)
    assert verify(copy).returncode == 0


def test_a_pose_or_score_that_the_images_do_not_show_is_told(copy: Path) -> None:
    result = json.loads((copy / "result.json").read_text())
    changed(copy, score=result["score"] - 0.2)
    done = verify(copy)
    assert done.returncode == 1
    assert "stated is" in done.stdout
    pose = result["pose"]
    pose["translation"][0] += 0.001
    steps = [step | {"pose": pose} for step in result["steps"]]
    changed(copy, score=result["score"], pose=pose, steps=steps)
    done = verify(copy)
    assert done.returncode == 1
    assert "mm from the stated one" in done.stdout


def test_a_merit_that_is_not_of_the_score_is_told(copy: Path) -> None:
    changed(copy, merit_px=0.5)
    done = verify(copy)
    assert done.returncode == 1
    assert "by the stated score, stated is 0.5." in done.stdout


@pytest.mark.parametrize("name", ["poses", "free"])
def test_other_poses_and_free_turns_that_the_images_do_not_show_are_told(copy: Path, name: str) -> None:
    pose = json.loads((copy / "result.json").read_text())["pose"]
    changed(copy, **{name: {"poses": [{"pose": pose, "probability": 0.5}], "free": [[0.0, 0.0, 1.0]]}[name]})
    done = verify(copy)
    assert done.returncode == 1
    assert f"Differs: {name} are others than stated." in done.stdout


def test_a_covariance_that_is_none_differs_without_more_words(copy: Path) -> None:
    covariance = json.loads((copy / "result.json").read_text())["covariance"]
    covariance[0][0] = -1.0
    changed(copy, covariance=covariance)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        done = verify(copy)
    assert (done.returncode, done.stderr) == (1, "")
    assert "the covariance is another than stated" in done.stdout


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"pose": None, "covariance": None}, "states no pose"),
        ({"estimated_with": None}, "does not say what its pose was estimated with"),
        ({"estimated_with": None, "status": "stopped"}, "stopped before its end"),
        (
            {"estimated_with": {"parameters": {"tone_sd_px": -1.0}}},
            "run cannot be estimated again: Parameter tone_sd_px must be",
        ),
        ({"steps": []}, "no step has the stated pose"),
        ({"steps": 3}, "result.json"),
        ({"holds": []}, "is an approach"),
        ({"version": 9}, "of format 9, and this version reads format 1"),
    ],
)
def test_what_cannot_be_verified_is_said(copy: Path, values: dict[str, Any], said: str) -> None:
    changed(copy, **values)
    done = verify(copy)
    assert done.returncode == 2
    assert done.stdout == ""
    assert said in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_a_folder_without_a_session_is_said(tmp_path: Path) -> None:
    done = verify(tmp_path)
    assert done.returncode == 2
    assert "no result.json in it" in done.stderr
