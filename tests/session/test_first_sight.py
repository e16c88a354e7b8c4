"""Sessions that are told nothing of where the target is."""

import json
import shutil
import tomllib
from pathlib import Path
from typing import Any

import pytest
import tomli_w

from geometry.pose import Pose
from tests.commands import command
from tests.session.command import cut, outcome
from tests.session.scenes import small
from tests.session.serving import served

pytestmark = pytest.mark.slow

SHORT = ("--max-iterations", "2", "--no-report", "--quiet")
LIMITS = (1.0, 0.01)  # right: degrees, share of the range


def result_of(out: Path) -> dict[str, Any]:
    return dict(json.loads((out / "result.json").read_text()))


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One on the simulator, of a target of which nearly all sides differ."""
    out = tmp_path_factory.mktemp("first-sight") / "run"
    words = ("--first-sight", "--target", "fixture", "--seed", "2", "--scenario", small())
    done = served(*words, "--out", out, *SHORT)
    assert done.returncode in (0, 3), done.stderr
    return out


def test_it_finds_the_target_and_tells_what_else_fits(session: Path) -> None:
    result = result_of(session)
    assert result["error"]["rotation_deg"] < LIMITS[0]
    assert result["error"]["translation_fraction_of_range"] < LIMITS[1]
    assert result["estimated_with"]["parameters"]["seed_pose"] == "anywhere"
    assert result["poses"][0]["pose"] == result["pose"]
    assert sum(one["probability"] for one in result["poses"]) <= 1.0
    assert result["score"] <= result["poses"][0]["probability"]
    assert "seed_pose" not in tomllib.loads((session / "images" / "stack.toml").read_text())["target"]


def test_poses_are_told_also_where_a_picture_that_came_again_was_discarded(
    session: Path, tmp_path: Path
) -> None:
    """The estimate with the same picture twice is the same, and the second is not there any more."""
    asked = ("--first-sight", "--stack", session / "images", "--threshold", "0.0001", "--max-iterations", "4")
    done = served(*asked, "--out", tmp_path / "run", "--no-report", "--quiet")
    assert done.returncode == 3, done.stderr
    result = result_of(tmp_path / "run")
    assert len(result["discarded"]) > 0
    assert result["poses"][0]["pose"] == result["pose"]


def test_its_estimate_is_made_again(session: Path) -> None:
    done = command("vision_server", "verify", session)
    assert done.returncode == 0, done.stdout + done.stderr


def test_it_goes_on_after_a_kill(session: Path, tmp_path: Path) -> None:
    out = Path(shutil.copytree(session, tmp_path / "run"))
    (out / "result.json").unlink()
    cut(out / "history.pl", "capture(i2")
    resumed = served("--resume", out, "--no-report", "--quiet")
    assert resumed.returncode in (0, 3), resumed.stderr
    assert outcome(out) == outcome(session)


def test_a_dry_run_says_that_it_will_look_everywhere() -> None:
    done = served("--first-sight", "--target", "fixture", "--dry-run")
    assert done.returncode == 0, done.stderr
    assert "looked for everywhere" in done.stdout + done.stderr


def test_a_seed_pose_beside_it_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "seed.toml"
    file.write_text("[target.seed_pose]\nrotation_vector = [0, 0, 0]\ntranslation = [0, 0, 1]\n")
    done = served("--first-sight", "--seed-pose", file, "--dry-run")
    assert done.returncode == 2
    assert "--first-sight looks everywhere" in done.stderr


STACKS = ("cube-0", "cube-1", "fixture-0", "fixture-1", "satellite-0", "satellite-1")


@pytest.mark.parametrize("name", STACKS)
def test_a_stack_without_a_seed_pose(name: str, shared_data: Path, tmp_path: Path) -> None:
    """The right pose is among those found; a wrong one is never trusted."""
    table = tomllib.loads((shared_data / "stacks" / name / "stack.toml").read_text())
    true = Pose.from_dict(table["target"]["true_pose"])
    del table["target"]["seed_pose"]
    stack = tmp_path / name
    stack.mkdir()
    for file in (shared_data / "stacks" / name).iterdir():
        if file.name != "stack.toml":
            (stack / file.name).symlink_to(file)
    (stack / "stack.toml").write_text(tomli_w.dumps(table))
    done = served("--stack", stack, "--out", tmp_path / "run", "--max-iterations", "1", *SHORT[2:])
    assert done.returncode in (0, 3), done.stderr
    result = result_of(tmp_path / "run")
    assert any(Pose.from_dict(one["pose"]).error_to(true).within(*LIMITS) for one in result["poses"])
    if result["status"] == "converged":
        assert Pose.from_dict(result["pose"]).error_to(true).within(*LIMITS)
