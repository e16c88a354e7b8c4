"""What a session leaves behind, wherever it was started from."""

import json
from pathlib import Path

import pytest

from stack.read import FramesStack, load_stack
from tests.session.command import ROOT, controller
from tests.session.scenes import small
from tests.session.serving import served

pytestmark = pytest.mark.slow


def test_a_session_runs_from_any_folder_and_its_images_can_be_moved(tmp_path: Path) -> None:
    here = tmp_path / "here"
    here.mkdir()
    done = controller(
        "--seed", "3", "--out", "run", "--json", "--quiet", "--instead", "i9: left 7, 1/60 s, f/4", cwd=here
    )
    assert done.returncode == 0, done.stderr
    assert "--instead: the session ended before i9" in done.stderr
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


def test_a_session_without_a_folder_makes_one_where_the_user_is(tmp_path: Path) -> None:
    done = served("--controller", "fixed", "--max-iterations", "1", "--no-report", cwd=tmp_path)
    assert done.returncode in (0, 3), done.stderr
    (folder,) = (tmp_path / "runs").iterdir()
    assert (folder / "result.json").exists()
    assert folder.name.endswith("-fixed-cube")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            "i1: lft 7, right 2",
            "--instead: there is no light lft; there are left, right, top. Did you mean left?",
        ),
        (
            "i1: left 7 right 2",
            "does not tell lights, shutter and aperture, as 'i3: left 4 right 4 top 4, 1/60 s",
        ),
    ],
)
def test_what_is_wrong_with_instead_is_named_and_leaves_no_folder(
    tmp_path: Path, words: str, said: str
) -> None:
    done = served("--instead", words, cwd=tmp_path)
    assert done.returncode == 2
    assert said in " ".join(done.stderr.split())
    assert list((tmp_path / "runs").iterdir()) == []


def test_a_mistake_that_a_server_finds_is_said_and_leaves_no_folder(tmp_path: Path) -> None:
    (tmp_path / "dim.toml").write_text("ambient_scal = 0.1\n")
    done = controller("--scenario", "dim.toml", "--quiet", cwd=tmp_path)
    assert done.returncode == 2
    assert " ".join(done.stderr.split()).endswith("unknown key `ambient_scal`. Did you mean ambient_scale?")
    assert list((tmp_path / "runs").iterdir()) == []


def test_a_model_in_millimetres_gives_the_pose_in_metres(tmp_path: Path) -> None:
    lines = (ROOT / "targets" / "cube.cao").read_text().splitlines()
    scaled = [
        " ".join(str(1000 * float(word)) for word in line.split("#")[0].split())
        if len(line.split("#")[0].split()) == 3 and "." in line.split("#")[0]
        else line
        for line in lines
    ]
    (tmp_path / "part.cao").write_text("\n".join(scaled) + "\n")
    options = ("--seed", "3", "--scenario", small(), "--no-report", "--quiet", "--json")
    part = served("--target", tmp_path / "part.cao", "--unit", "mm", "--out", tmp_path / "run", *options)
    assert part.returncode == 0, part.stderr
    result = json.loads(part.stdout)
    assert 0.2 < result["pose"]["translation"][2] < 2.0
    assert result["error"]["translation_fraction_of_range"] < 0.01
    taken_for_metres = served(
        "--target", tmp_path / "part.cao", "--scenario", small(), "--max-iterations", "1", "--no-report",
        "--out", tmp_path / "metres",
    )  # fmt: skip
    assert "model part: 346 m across" in taken_for_metres.stderr
    assert "can that be?" in taken_for_metres.stderr and "(--unit mm?)" in taken_for_metres.stderr
    assert "--unit" in taken_for_metres.stdout  # among what may help
    anywhere = served("--target", tmp_path / "part.cao", "--first-sight", "--dry-run")
    assert "can that be?" in anywhere.stderr + anywhere.stdout


def test_what_is_drawn_depends_on_the_seed_and_on_the_scene(tmp_path: Path) -> None:
    drawn = []
    for number, (target, seed) in enumerate(
        [("cube", "1"), ("cube", "1"), ("satellite", "1"), ("cube", "2")]
    ):
        out = tmp_path / str(number)
        served(
            "--target", target, "--seed", seed, "--scenario", small(), "--controller", "simple",
            "--max-iterations", "2",
            "--threshold", "0.000001", "--no-report", "--out", out,
        )  # fmt: skip
        steps = json.loads((out / "result.json").read_text())["steps"]
        drawn.append(json.dumps([step["settings"] for step in steps]))
    assert drawn[0] == drawn[1]
    assert len(set(drawn)) == 3
