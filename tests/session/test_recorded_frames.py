"""Sessions on a stack of recorded frames, none of which strategies ask for by their settings."""

import json
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import tomli_w

from stack.read import recorded_frames
from tests.session.command import ROOT, cut, steps_of
from tests.session.scenes import small
from tests.session.serving import served

pytestmark = pytest.mark.slow

SAID = "was taken under other settings than were asked for"


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What `record` makes of the simulator when it is told to record frames of each light."""
    out = tmp_path_factory.mktemp("recorded") / "stack"
    words = ["record", str(out), "--kind", "frames", "--scenario", str(small()), "--settings", "each"]
    subprocess.run([sys.executable, "-m", "image_server", *words], cwd=ROOT, check=True, capture_output=True)
    return out


@pytest.mark.parametrize("name", ["heuristic", "greedy", "simple", "auto_exposed", "fixed"])
def test_every_strategy_is_served_and_it_is_said_once(recorded: Path, tmp_path: Path, name: str) -> None:
    done = served("--stack", recorded, "--controller", name, "--out", tmp_path / "run", "--no-report")
    assert done.returncode == 0, done.stderr
    assert done.stderr.count(SAID) == 1
    result = json.loads((tmp_path / "run" / "result.json").read_text())
    assert (result["status"], result["target"]) == ("converged", "cube")
    taken = recorded_frames(tmp_path / "run" / "images").values()
    assert len({frame.sha256 for frame in taken}) == result["iterations"]  # no image twice


def without_places(stack: dict[str, Any]) -> None:
    for light in stack["lights"]:
        del light["position"]


def further_off(stack: dict[str, Any]) -> None:
    for light in stack["lights"]:
        light["position"] = [4.0 * x for x in light["position"]]


def one_frame(stack: dict[str, Any]) -> None:
    del stack["frames"][1:]


def changed(recorded: Path, folder: Path, change: Callable[[dict[str, Any]], None]) -> tuple[Path, Any]:
    """Another stack, and what its file tells."""
    stack = folder / "stack"
    shutil.copytree(recorded, stack)
    told = tomllib.loads((stack / "stack.toml").read_text())
    change(told)
    (stack / "stack.toml").write_text(tomli_w.dumps(told))
    return stack, told


@pytest.mark.parametrize(("change", "said"), [(without_places, 1), (further_off, 0), (one_frame, 0)])
def test_informed_does_with_what_is_known_of_the_lights(
    recorded: Path, tmp_path: Path, change: Callable[[dict[str, Any]], None], said: int
) -> None:
    stack, told = changed(recorded, tmp_path, change)
    done = served("--stack", stack, "--controller", "informed", "--out", tmp_path / "run", "--no-report")
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("`position` of left, right, top is not told") == said
    if change is one_frame:
        steps = json.loads((tmp_path / "run" / "result.json").read_text())["steps"]
        assert [step["decision"] for step in steps] == ["keep", "discard"]
        assert steps[1]["reason"] == "the same picture again"
        assert all("asked" in step for step in steps)
        assert steps[0]["settings"]["lights"] == steps[1]["settings"]["lights"] == told["frames"][0]["lights"]


@pytest.mark.parametrize(("frames", "advice"), [(2, "this one has 2 frames"), (3, "more than 2 images")])
def test_no_more_images_are_advised_than_there_are(
    recorded: Path, tmp_path: Path, frames: int, advice: str
) -> None:
    stack, _ = changed(recorded, tmp_path, lambda told: told["frames"].__delitem__(slice(frames, None)))
    never = ("--threshold", "0.000001", "--max-iterations", "2", "--no-report", "--quiet")
    done = served("--stack", stack, "--out", tmp_path / "run", *never)
    assert done.returncode == 3, done.stderr
    assert advice in json.loads((tmp_path / "run" / "result.json").read_text())["advice"][0]


def test_a_resumed_session_is_not_shown_the_same_frames_again(recorded: Path, tmp_path: Path) -> None:
    never = ("--threshold", "0.000001", "--max-iterations", "5", "--no-report")
    whole = served("--stack", recorded, "--out", tmp_path, "--quiet", *never)
    assert whole.returncode == 3, whole.stderr
    expected = steps_of(tmp_path)
    (tmp_path / "result.json").unlink()
    journal = (tmp_path / "history.pl").read_text()
    cut(tmp_path / "history.pl", "keep(i2)" if "keep(i2)" in journal else "discard(i2,")
    resumed = served("--resume", tmp_path, "--no-report", "--quiet")
    assert resumed.returncode == 3, resumed.stderr
    assert steps_of(tmp_path) == expected
