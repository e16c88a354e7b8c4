"""What a session leaves behind, wherever it was started from."""

import json
from pathlib import Path

import pytest

from stack.read import FramesStack, load_stack
from tests.session.command import controller

pytestmark = pytest.mark.slow


def test_a_session_runs_from_any_folder_and_its_images_can_be_moved(tmp_path: Path) -> None:
    here = tmp_path / "here"
    here.mkdir()
    done = controller("--seed", "3", "--out", "run", "--json", "--quiet", cwd=here)
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    assert result["status"] == "converged"
    assert result["error"]["rotation_deg"] < 1.0
    assert {path.name for path in (here / "run").iterdir()} == {
        "history.pl", "image_server.log", "images", "report.html", "result.json", "session.pl",
        "vision_server.log",
    }  # fmt: skip
    moved = here.rename(tmp_path / "there") / "run" / "images"
    stack = (moved / "stack.toml").read_text()
    assert str(tmp_path) not in stack
    assert 'model = "cube.cao"' in stack
    assert isinstance(load_stack(moved), FramesStack)
