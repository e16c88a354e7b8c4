"""The hold points of an approach as a strip: which there are, and which image stands for each."""

import json
from typing import Any

import msgspec
import pytest

from bridge.messages import PoseMessage
from bridge.result_file import Result
from report.approach import strip_of
from report.following import State
from report.fragments import fragments
from report.page import write_report
from report.strokes import Strokes
from tests.report.run_folders import Bench, RunMaker, result_record, step_record

PLANNED = [1.5, 0.8, 0.5]


def drawn(pose: PoseMessage | None) -> Strokes | None:
    return None if pose is None else Strokes("M0 0", "", (0, 0, 1, 1), ())


def approach(bench: Bench, status: str = "running", **first: Any) -> Result:
    """Two images at the first hold point, which was passed, and one at the second; the third is far."""
    steps = [step_record(number, bench.pose) | {"hold": 1 if number < 3 else 2} for number in (1, 2, 3)]
    hold = {"range_m": 1.5, "status": "fixed", "merit": 0.5, "pose": bench.pose.to_dict()} | first
    record = result_record(steps, bench.pose) | {
        "status": status,
        "planned_holds_m": PLANNED,
        "holds": [hold],
    }
    return msgspec.convert(record, Result)


def test_hold_points_that_were_passed_are_to_come_and_where_the_session_is(bench: Bench) -> None:
    passed, here, far = strip_of(approach(bench), ["i1", "i2", "i3"], drawn, runs=True)
    assert (passed.range_m, passed.outcome, passed.decision) == (1.5, "fixed", "keep")
    assert passed.image == "i1"  # i2 was discarded
    assert (here.outcome, here.decision, here.image) == ("here", "", "i3")
    assert here.strokes is not None
    assert (far.range_m, far.outcome, far.image, far.strokes) == (0.5, "", None, None)


def test_a_session_that_has_ended_is_nowhere(bench: Bench) -> None:
    assert [stop.outcome for stop in strip_of(approach(bench), ["i1"], drawn)] == ["fixed", "", ""]


@pytest.mark.parametrize(
    ("first", "shown", "image"),
    [
        ({}, ["i1", "i2", "i3"], "i1"),
        ({}, ["i2", "i3"], "i2"),
        ({}, ["i3"], None),
    ],
)
def test_the_last_kept_image_that_can_be_shown_stands_for_a_hold_point(
    bench: Bench, first: dict[str, Any], shown: list[str], image: str | None
) -> None:
    assert strip_of(approach(bench, **first), shown, drawn)[0].image == image


def test_a_session_without_hold_points_has_no_strip(bench: Bench) -> None:
    steps = [step_record(1, bench.pose)]
    assert strip_of(msgspec.convert(result_record(steps, bench.pose), Result), ["i1"], drawn) == []


def test_the_live_page_shows_the_strip_while_the_approach_goes_on(make_run: RunMaker, bench: Bench) -> None:
    folder = make_run()
    running = approach(bench)
    part = fragments(folder, State(running, "running"), "secret")["approach"]
    assert part.count("<li") == 3 and part.count(">fixed<") == 1 and part.count(">here<") == 1
    assert "images/i1.png?token=secret" in part and "images/i3.png?token=secret" in part
    assert part.count('class="supported"') == 2 and part.count("not come to") == 1
    ended = fragments(folder, State(approach(bench, "exhausted"), "exhausted"), "secret")["approach"]
    assert ">here<" not in ended
    plain = msgspec.structs.replace(running, planned_holds_m=None, holds=None)
    assert fragments(folder, State(plain, "running"), "secret")["approach"] == ""


def test_the_report_of_an_approach_has_a_strip_of_all_planned_hold_points(make_run: RunMaker) -> None:
    folder = make_run(steps=3)
    result = json.loads((folder / "result.json").read_text())
    for number, step in enumerate(result["steps"]):
        step["hold"] = 1 + number // 2
    pose = result["steps"][0]["pose"]
    result["holds"] = [
        {"range_m": 1.5, "status": "fixed", "pose": pose, "merit": 0.4},
        {"range_m": 0.8, "status": "aborted", "pose": None, "merit": 3.0},
    ]
    result["planned_holds_m"] = [1.5, 0.8, 0.3]
    (folder / "result.json").write_text(json.dumps(result))
    page = write_report(folder).read_text()
    strip = page.split('class="strip"')[1].split("</ol>")[0]
    stops = strip.split("<li")[1:]
    assert len(stops) == 3
    assert "#image-i1" in stops[0] and "1.5 m" in stops[0] and "wire" in stops[0]
    assert "#image-i3" in stops[1] and "aborted" in stops[1] and "wire" not in stops[1]
    assert "not come to" in stops[2] and "0.3 m" in stops[2]
