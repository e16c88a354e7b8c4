"""Long films: continued where they ended, and a frame that is sure and wrong is told with what it stated."""

import json
from pathlib import Path

import numpy as np
import pytest

from benchmarks import films, long_films
from benchmarks.films import film
from geometry.model import Model


def test_films_that_were_made_are_not_made_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(long_films, "LENGTH", 2)
    rows = tmp_path / "rows.jsonl"
    long_films.main(rows, 4, ["fast", "lights"])
    first = rows.read_text()
    assert [(row["kind"], row["number"]) for row in map(json.loads, first.splitlines())] == [
        ("fast", 0),
        ("lights", 0),
    ]
    long_films.main(rows, 6, ["fast", "lights"])
    assert rows.read_text().startswith(first)
    assert len(rows.read_text().splitlines()) == 3


def test_a_kind_that_is_given_twice_has_twice_as_many_films(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(long_films, "row_of", made)
    rows = tmp_path / "rows.jsonl"
    long_films.main(rows, 6, ["fast", "fast", "arm"], first=7)
    told = [(row["kind"], row["number"]) for row in map(json.loads, rows.read_text().splitlines())]
    assert told == [("fast", 7), ("fast", 8), ("arm", 7), ("fast", 9), ("fast", 10), ("arm", 8)]


def test_films_of_gear_are_of_each_in_turn(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(long_films, "row_of", made)
    rows = tmp_path / "rows.jsonl"
    long_films.main(rows, 3, ["fast"], gear=["dish", "cart"])
    told = [(row["gear"], row["number"]) for row in map(json.loads, rows.read_text().splitlines())]
    assert told == [("dish", 0), ("cart", 0), ("dish", 1)]
    model, _ = film(0, "fast", 2, "cart")
    assert model.name == "cart"


def made(kind: str, number: int, gear: str = "") -> dict[str, object]:
    return {
        "kind": kind,
        "number": number,
        "gear": gear,
        "frames": 1,
        "sure": 1,
        "unsure": 0,
        "lost": 0,
        "wrong": [],
    }


def test_sure_frames_of_a_target_that_is_not_there_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(long_films, "LENGTH", 3)
    assert long_films.row_of("fast", 0)["wrong"] == []
    monkeypatch.setattr(films, "_in_frame", lambda *_: 0.0)
    told = long_films.row_of("fast", 0)
    assert told["sure"] == 3
    wrong = told["wrong"]
    assert isinstance(wrong, list)
    assert [one["frame"] for one in wrong] == [0, 1, 2]
    assert all(one["off"] for one in wrong)
    assert wrong[0]["visible"] == 0.0
    assert wrong[0]["degrees"] < 0.5


def test_another_part_has_a_plate_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(films, "_shown", lambda rng, model, *_: iter([model]))
    part, drawn = film(3, "another", 2)
    other = next(drawn)
    assert isinstance(other, Model)
    sides = [np.ptp(model.vertices, axis=0) for model in (part, other)]
    assert np.abs(np.log(sides[0][:2] / sides[1][:2])).max() > 0.05


def test_what_is_two_degrees_off_is_beyond_one_and_not_wrong(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(long_films, "LENGTH", 2)
    turned = np.radians([0.0, 0.0, 2.0])
    monkeypatch.setattr(long_films, "is_right", lambda *_: False)
    monkeypatch.setattr(long_films, "truth", lambda _, pose: pose.stepped(np.r_[turned, 0.0, 0.0, 0.0]))
    long_films.main(tmp_path / "rows.jsonl", 2, ["fast"])
    told = json.loads(capsys.readouterr().out)
    assert (told["value"], told["sure_and_beyond_1"], told["sure"]) == (0, 2, 2)
