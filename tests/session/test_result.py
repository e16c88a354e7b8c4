"""result.json as docs/result.md and its schema describe it."""

import json
import math
import shlex
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
import trimesh

from bridge.commands.schema import laid_out
from bridge.mocks import MockImageServer, MockVisionServer, mock_image_server, mock_vision_server
from bridge.result_file import result_schema
from tests.session.command import ROOT, controller
from tests.session.scenes import small
from tests.session.serving import served

pytestmark = pytest.mark.slow

__all__ = ["mock_image_server", "mock_vision_server"]

SCHEMA = json.loads((ROOT / "session" / "result.schema.json").read_text())


def merit_px(estimate: dict[str, Any]) -> float:
    """The formula of docs/result.md."""
    if estimate["pose"] is None:
        return 100.0
    return float(15 * (1 - estimate["score"]))


def checked(folder: Path) -> dict[str, Any]:
    """The result of a run folder, after it was held against the schema and its merits made anew."""
    result: dict[str, Any] = json.loads((folder / "result.json").read_text())
    jsonschema.Draft202012Validator(SCHEMA).validate(result)
    assert math.isclose(result["merit_px"], merit_px(result))
    for told in [*result["steps"], *result.get("holds", [])]:
        assert math.isclose(told["merit"], merit_px(told))
    return result


def test_the_schema_is_one() -> None:
    assert (ROOT / "session" / "result.schema.json").read_text() == laid_out(result_schema()) + "\n"
    jsonschema.Draft202012Validator.check_schema(SCHEMA)


def test_the_schema_refuses_what_is_not_a_result(tmp_path: Path) -> None:
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.Draft202012Validator(SCHEMA).validate({"version": 1, "status": "converged"})


def test_the_page_names_every_key() -> None:
    page = (ROOT / "docs" / "result.md").read_text()
    keys = [*SCHEMA["properties"], *SCHEMA["$defs"]["StepRecord"]["properties"]]
    assert [key for key in keys if f"`{key}`" not in page] == []


def test_a_session_on_the_simulator(tmp_path: Path) -> None:
    folder = tmp_path / "it's $1"
    done = served("--seed", "3", "--out", folder, "--no-report", "--json", "--quiet")
    result = checked(folder)
    assert str(folder) in shlex.split(result["command"])
    assert json.loads(done.stdout) == result
    assert (result["scenario"], result["stack"]) == ("nominal", None)
    assert [light["levels"] for light in result["lights"]] == [8, 8, 8]
    assert result["steps"][-1]["error"] == result["error"]


def test_a_round_target_with_a_seed_pose(tmp_path: Path) -> None:
    trimesh.creation.cylinder(0.1, 0.15, sections=64).export(tmp_path / "can.stl")
    served("--target", tmp_path / "can.stl", "--seed", "3", "--out", tmp_path / "run", "--no-report")
    result = checked(tmp_path / "run")
    assert result["status"] == "converged"
    assert np.abs(result["free"]).round(6).tolist() == [[0, 0, 1]]
    assert result["error"]["rotation_deg"] < 1.0


def test_an_approach(tmp_path: Path) -> None:
    ranges = ("--first-range", "0.8", "--contact-range", "0.65")
    served("--approach", *ranges, "--scenario", small("approach"), "--out", tmp_path, "--no-report")
    result = checked(tmp_path)
    assert [hold["status"] for hold in result["holds"]] == ["fixed", "reached"]
    assert result["planned_holds_m"] == [hold["range_m"] for hold in result["holds"]] == [0.8, 0.65]
    assert all(hold["error"]["translation_fraction_of_range"] < 0.01 for hold in result["holds"])
    assert {step["hold"] for step in result["steps"]} == {1, 2}
    assert all(("error" in step) == (step["hold"] == 2) for step in result["steps"])


def test_no_pose_and_a_light_that_died(
    mock_vision_server: MockVisionServer, mock_image_server: MockImageServer, tmp_path: Path
) -> None:
    mock_vision_server.amend("estimate", pose=None, covariance=None)

    def capture_and_fail(args: Any) -> Any:
        mock_vision_server.publish("light_fault", {"light": "left"})
        return mock_vision_server.capture(args)

    mock_vision_server.answer("capture", capture_and_fail)
    controller(
        "--vision-server", mock_vision_server.endpoint, "--image-server", mock_image_server.endpoint,
        "--out", tmp_path, "--no-report", "--max-iterations", "3",
    )  # fmt: skip
    result = checked(tmp_path)
    assert result["pose"] is None
    assert (result["status"], result["merit_px"], result["scenario"]) == ("exhausted", 100.0, None)
    assert result["lights"][0] == {"name": "left", "levels": None}


def test_whatever_a_strategy_gives_for_a_reason_stands_there_in_words(tmp_path: Path) -> None:
    reasons = ["iteration", "why(merit, [1, 2])", '"a string"', "[]"]
    dropped = ", ".join(f"choose_reference, take_image, drop_image({reason})" for reason in reasons)
    (tmp_path / "mine.pl").write_text(f"proc(control, [{dropped}]).\n")
    options = ("--controller", tmp_path / "mine.pl", "--scenario", small(), "--out", tmp_path / "run")
    done = served(*options, "--no-report")
    assert done.returncode == 3, done.stderr
    result = checked(tmp_path / "run")
    told = [step["reason"] for step in result["steps"]]
    assert told == ["1", "why(100.0,[1,2])", "a string", "[]"]
