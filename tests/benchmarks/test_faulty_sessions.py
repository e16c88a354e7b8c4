"""What a session with a planted fault counts as."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from benchmarks.faulty_sessions import SAID, Ended, outcome
from benchmarks.planted_faults import Planted
from benchmarks.surprises import first_settings
from geometry.pose import Pose
from tests.commands import module


def moved(folder: Path) -> tuple[Planted, Pose]:
    """A target that has moved; where it was."""
    device = Planted("nominal", 1, "target_moved", 1, folder)
    before = device.true
    device.capture(first_settings(device.describe()))
    return device, before


def test_a_pose_where_the_target_was_is_wrong_and_one_where_it_is_is_right(tmp_path: Path) -> None:
    device, before = moved(tmp_path)
    stale = outcome(device, Ended(before, True, 2, []), "target_moved")
    assert (stale["wrong_and_trusted"], stale["named"]) == (1, 0)
    found = outcome(device, Ended(device.true, True, 3, [("target_moved", ())]), "target_moved")
    assert (found["right"], found["wrong_and_trusted"], found["named"], found["named_otherwise"]) == (
        1,
        0,
        1,
        0,
    )
    doubted = outcome(device, Ended(before, False, 2, [("sun_changed", ())]), "target_moved")
    assert (doubted["wrong_and_trusted"], doubted["named_otherwise"]) == (0, 1)


def test_of_a_session_that_ends_before_its_fault_nothing_more_is_counted(tmp_path: Path) -> None:
    device = Planted("nominal", 1, "light_dead", 3, tmp_path)
    device.capture(first_settings(device.describe()))
    count = outcome(device, Ended(Pose(np.zeros(3), np.ones(3)), True, 1, []), "light_dead")
    assert count["sessions"] == 1
    assert not count["happened"]
    assert not count["wrong_and_trusted"]


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("exogenous(16,surprise(i2,target_moved)).", ("target_moved", "")),
        ("exogenous(16,surprise(i2,lights_swapped(left,'my top'))).", ("lights_swapped", "left,'my top'")),
    ],
)
def test_what_was_said_is_read_from_the_journal(line: str, said: tuple[str, str]) -> None:
    assert SAID.findall(f"executed(14,capture(i2,s),told(x,surprise(i2,light_dead(top)))).\n{line}\n") == [
        said
    ]


@pytest.mark.slow
def test_the_session_that_the_docs_show_names_the_light_that_died() -> None:
    page = (Path(__file__).resolve().parents[2] / "docs" / "surprises.md").read_text()
    shown = re.findall(r"^    \S+ -m (benchmarks.faulty_sessions) (.* --seeds 1 .*)$", page, re.MULTILINE)
    ((name, words),) = shown
    done = module(name, *words.split())
    assert done.returncode == 0, done.stderr
    counted = json.loads(done.stdout.splitlines()[-1])
    assert (counted["sessions"], counted["named"], counted["named_otherwise"]) == (1, 1, 0)
