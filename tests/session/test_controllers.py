"""The strategies against mock servers: what they ask for, what they make of the answers."""

import json
from pathlib import Path
from typing import Any

import pytest

from bridge.errors import ServerError
from bridge.mock_session import mock_session
from bridge.mocks import MockImageServer, MockVisionServer, mock_image_server, mock_vision_server
from tests.session.command import ROOT, controller, cut

pytestmark = pytest.mark.slow

__all__ = ["mock_image_server", "mock_vision_server"]

NEVER = "0.000001"
LEFT_IS_DEAD = {"surprise": {"cause": "light_dead", "lights": ["left"]}}


def run(
    vision: MockVisionServer, image: MockImageServer, out: Path, *options: str
) -> tuple[int, dict[str, Any], str]:
    """One session against the mocks; exit status, result.json, and what the terminal showed."""
    done = mock_session(vision, image, out, *options)
    return done.status, done.result, done.shown


def tell_with(vision: MockVisionServer, **images: dict[str, Any]) -> None:
    """Have captures of these images tell this, too."""

    def capture(args: Any) -> Any:
        reply: Any = vision.capture(args)
        reply.result.update(images.get(args.image, {}))
        return reply

    vision.answer("capture", capture)


def asked(vision: MockVisionServer, op: str) -> list[dict[str, Any]]:
    """The arguments of all requests of one operation."""
    requests: list[dict[str, Any]] = json.loads(json.dumps(vision.requests_of(op)))
    return requests


def test_simple_keeps_every_image(
    mock_vision_server: MockVisionServer, mock_image_server: MockImageServer, tmp_path: Path
) -> None:
    status, result, _ = run(
        mock_vision_server, mock_image_server, tmp_path,
        "--controller", "simple", "--max-iterations", "4", "--threshold", NEVER,
    )  # fmt: skip
    assert status == 3
    assert result["status"] == "exhausted"
    assert result["kept"] == ["i1", "i2", "i3", "i4"]
    assert result["discarded"] == []
    assert [call["images"] for call in asked(mock_vision_server, "estimate")][-1] == ["i1", "i2", "i3", "i4"]


@pytest.mark.parametrize("name", ["greedy", "heuristic"])
def test_images_that_do_not_help_are_discarded(
    mock_vision_server: MockVisionServer, mock_image_server: MockImageServer, tmp_path: Path, name: str
) -> None:
    mock_vision_server.amend("estimate", rms_px=1.0, uncertainty=0.001, score=0.5)
    _, result, _ = run(
        mock_vision_server, mock_image_server, tmp_path,
        "--controller", name, "--max-iterations", "4", "--threshold", NEVER,
    )  # fmt: skip
    assert result["kept"] == ["i1"]
    assert result["discarded"] == ["i2", "i3", "i4"]
    assert [call["image"] for call in asked(mock_vision_server, "discard")] == ["i2", "i3", "i4"]
    assert [step["decision"] for step in result["steps"]] == ["keep", "discard", "discard", "discard"]


def test_heuristic_does_not_repeat_itself(
    mock_vision_server: MockVisionServer, mock_image_server: MockImageServer, tmp_path: Path
) -> None:
    mock_vision_server.amend("estimate", rms_px=1.0, uncertainty=0.001, score=0.5)
    run(mock_vision_server, mock_image_server, tmp_path, "--max-iterations", "6", "--threshold", NEVER)
    settings = [json.dumps(call["settings"], sort_keys=True) for call in asked(mock_vision_server, "capture")]
    assert len(settings) == len(set(settings)) == 6


@pytest.mark.parametrize("name", ["heuristic"])
def test_same_seed_same_session(
    mock_vision_server: MockVisionServer, mock_image_server: MockImageServer, tmp_path: Path, name: str
) -> None:
    steps = []
    for attempt in ("first", "second"):
        _, result, _ = run(
            mock_vision_server, mock_image_server, tmp_path / attempt,
            "--controller", name, "--seed", "5", "--max-iterations", "4", "--threshold", NEVER,
        )  # fmt: skip
        steps.append(result["steps"])
    assert steps[0] == steps[1]


def test_one_image_for_the_fixed_camera(
    mock_vision_server: MockVisionServer, mock_image_server: MockImageServer, tmp_path: Path
) -> None:
    _, result, _ = run(mock_vision_server, mock_image_server, tmp_path, "--controller", "fixed")
    (settings,) = [call["settings"] for call in asked(mock_vision_server, "capture")]
    assert settings["lights"] == [4, 4, 4]
    assert result["iterations"] == 1


def test_auto_exposed_uses_one_image_of_those_it_metered(
    mock_vision_server: MockVisionServer, mock_image_server: MockImageServer, tmp_path: Path
) -> None:
    _, result, _ = run(mock_vision_server, mock_image_server, tmp_path, "--controller", "auto_exposed")
    assert len(result["kept"]) == 1
    assert len(asked(mock_vision_server, "estimate")) == 1
    assert 2 <= result["iterations"] <= 6


def test_a_users_own_controller(
    mock_vision_server: MockVisionServer, mock_image_server: MockImageServer, tmp_path: Path
) -> None:
    _, result, _ = run(
        mock_vision_server, mock_image_server, tmp_path,
        "--controller", str(ROOT / "examples" / "one_light_at_a_time.pl"), "--threshold", NEVER,
    )  # fmt: skip
    lit = [
        [level > 0 for level in call["settings"]["lights"]] for call in asked(mock_vision_server, "capture")
    ]
    assert lit == [[True, False, False], [False, True, False], [False, False, True]]
    assert result["controller"] == "one_light_at_a_time"


def test_convergence_ends_the_session(
    mock_vision_server: MockVisionServer, mock_image_server: MockImageServer, tmp_path: Path
) -> None:
    status, result, shown = run(mock_vision_server, mock_image_server, tmp_path, "--threshold", "50")
    assert status == 0
    assert result["status"] == "converged"
    assert "Pose found" in shown


def test_no_pose_is_said(
    mock_vision_server: MockVisionServer, mock_image_server: MockImageServer, tmp_path: Path
) -> None:
    mock_vision_server.amend("estimate", pose=None, covariance=None)
    status, result, shown = run(mock_vision_server, mock_image_server, tmp_path, "--max-iterations", "3")
    assert status == 3
    assert result["pose"] is None
    assert "no pose" in shown


def test_a_light_that_dies_is_left_out(
    mock_vision_server: MockVisionServer, mock_image_server: MockImageServer, tmp_path: Path
) -> None:
    mock_vision_server.amend("estimate", rms_px=1.0)

    def capture_and_fail(args: Any) -> Any:
        if args.image == "i2":
            mock_vision_server.publish("light_fault", {"light": "left"})
        return mock_vision_server.capture(args)

    mock_vision_server.answer("capture", capture_and_fail)
    _, _, shown = run(
        mock_vision_server, mock_image_server, tmp_path, "--max-iterations", "8", "--threshold", NEVER
    )
    assert "light_fault(left)" in shown
    later = [call["settings"]["lights"][0] for call in asked(mock_vision_server, "capture")[3:]]
    assert set(later) == {0}


def test_a_target_that_moved_unannounced_is_told_and_the_set_begins_anew(
    mock_vision_server: MockVisionServer, mock_image_server: MockImageServer, tmp_path: Path
) -> None:
    tell_with(mock_vision_server, i3={"surprise": {"cause": "target_moved"}})
    words = "--controller", "informed", "--max-iterations", "4", "--threshold", NEVER
    _, result, shown = run(mock_vision_server, mock_image_server, tmp_path, *words)
    assert "i3 is not as foreseen: the target has moved" in shown
    assert result["steps"][2]["reason"] == "not as foreseen: the target has moved"
    assert asked(mock_vision_server, "estimate")[2]["images"] == ["i3"]


def test_a_doubt_is_told_and_tested_and_a_dead_light_stays_off(
    mock_vision_server: MockVisionServer, mock_image_server: MockImageServer, tmp_path: Path
) -> None:
    tell_with(mock_vision_server, i2={"doubt": {"cause": "light_dead", "lights": ["left"]}}, i3=LEFT_IS_DEAD)
    words = "--controller", "informed", "--max-iterations", "5", "--threshold", NEVER
    _, result, shown = run(mock_vision_server, mock_image_server, tmp_path, *words)
    assert "i2 is not as foreseen, perhaps: the light left is dead" in shown
    assert "i3 is not as foreseen: the light left is dead" in shown
    assert result["steps"][1]["reason"] == "not as foreseen: perhaps the light left is dead"
    levels = [call["settings"]["lights"][0] for call in asked(mock_vision_server, "capture")]
    assert levels[2:] == [0, 0, 0]


def test_a_model_that_does_not_fit_is_said_once_and_stands_in_the_result(
    mock_vision_server: MockVisionServer, mock_image_server: MockImageServer, tmp_path: Path
) -> None:
    mock_vision_server.amend("estimate", model_wrong={"axis": "y", "share": -0.021})
    words = "--controller", "simple", "--max-iterations", "3", "--threshold", NEVER
    _, result, shown = run(mock_vision_server, mock_image_server, tmp_path, *words)
    said = "the model does not fit, it is about 2.1 % too short along y"
    assert result["model_wrong"] == {"axis": "y", "share": -0.021}
    assert [step["reason"] for step in result["steps"]] == [said, "", ""]
    assert shown.count(said) >= 2  # when it is found, and at the end
    assert (tmp_path / "history.pl").read_text().count("model_wrong(") == 1


def test_killed_between_an_image_and_its_surprise_a_session_goes_on_with_it(
    mock_vision_server: MockVisionServer, mock_image_server: MockImageServer, tmp_path: Path
) -> None:
    tell_with(mock_vision_server, i2=LEFT_IS_DEAD)
    words = "--controller", "informed", "--max-iterations", "4", "--threshold", NEVER
    _, whole, _ = run(mock_vision_server, mock_image_server, tmp_path, *words)
    cut(tmp_path / "history.pl", "capture(i2")
    (tmp_path / "result.json").unlink()
    resumed = controller(
        "--resume", tmp_path, "--no-report", "--json",
        "--image-server", mock_image_server.endpoint, "--vision-server", mock_vision_server.endpoint,
    )  # fmt: skip
    steps = json.loads(resumed.stdout)["steps"]
    for key in ("settings", "decision", "reason"):
        assert [step[key] for step in steps] == [step[key] for step in whole["steps"]]
    assert steps[1]["reason"] == "not as foreseen: the light left is dead"
    told = asked(mock_vision_server, "restore")[0]["told"]
    assert told[-1]["happened"] == {"cause": "light_dead", "lights": ["left"], "since": "i2"}


def test_a_request_that_is_refused_ends_the_session(
    mock_vision_server: MockVisionServer, mock_image_server: MockImageServer, tmp_path: Path
) -> None:
    mock_vision_server.answer(
        "estimate", ServerError("no_model", "The matcher has no model.", "Start again.")
    )
    status, result, shown = run(mock_vision_server, mock_image_server, tmp_path)
    assert status == 4
    assert "The matcher has no model." in shown
    assert result["status"] == "stopped"


def test_lost_replies_are_asked_for_again(
    mock_vision_server: MockVisionServer, mock_image_server: MockImageServer, tmp_path: Path
) -> None:
    mock_vision_server.drop("capture", 1)
    status, _, shown = run(
        mock_vision_server, mock_image_server, tmp_path, "--threshold", "50", "--max-iterations", "1"
    )
    assert status == 0, shown
    assert len(asked(mock_vision_server, "capture")) == 1


def test_an_estimate_without_a_pose_replaces_the_one_before(
    mock_vision_server: MockVisionServer, mock_image_server: MockImageServer, tmp_path: Path
) -> None:
    def pose_only_from_the_first(args: Any) -> Any:
        reply = mock_vision_server.estimate(args)
        if len(args.images) > 1:
            return {**reply.result, "pose": None, "covariance": None, "score": 0.0}
        return reply

    mock_vision_server.answer("estimate", pose_only_from_the_first)
    _, result, _ = run(
        mock_vision_server, mock_image_server, tmp_path,
        "--controller", "greedy", "--max-iterations", "3", "--threshold", NEVER,
    )  # fmt: skip
    assert result["kept"] == ["i1"]
    assert [step["pose"] is None for step in result["steps"]] == [False, True, True]


def test_a_strategy_that_takes_images_for_ever_is_ended(
    mock_vision_server: MockVisionServer, mock_image_server: MockImageServer, tmp_path: Path
) -> None:
    program = "while(true, [choose_random, take_image, measure, drop_image(again)])"
    (tmp_path / "forever.pl").write_text(f"proc(control, {program}).\n")
    ended, result, shown = run(
        mock_vision_server, mock_image_server, tmp_path / "run",
        "--controller", str(tmp_path / "forever.pl"), "--max-iterations", "2", "--threshold", NEVER,
    )  # fmt: skip
    assert ended == 3
    assert "ends by --max-iterations 2" in shown
    assert result["status"] == "exhausted"
