"""The fit of the trust finds what decides, and says how well it is calibrated."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from benchmarks.photographs import Studio
from benchmarks.trust_fit import OF_LAST_STEP, app, chance, fitted, inputs
from benchmarks.trust_rows import row_of
from geometry.model import Model
from image_server.simulator.simulator import Simulator
from tests.vision_server.synthetic import CAMERA, POSE, cuboid, linear_picture, one_image, photographed
from vision_server.pipeline import estimate_pose
from vision_server.trust.probability import FAR_ASTRAY, FITTED, RIGHT_OF_WRONG_MODEL, SETTLED_ODDS_POWER


def rows(count: int) -> list[dict[str, object]]:
    """Estimates that are right the more often, the more of their lines agree."""
    rng = np.random.default_rng(3)
    agreeing = rng.uniform(0.2, 1.0, count)
    right = rng.random(count) < 1.0 / (1.0 + np.exp(-15.0 * (agreeing - 0.6)))
    return [
        {"scene": f"s{k % 20}", "model": "true", "empty": False, "pose": True, "within": bool(right[k]),
         "right": bool(right[k]), "confirmed": 30.0, "missing": 0.1, "agreeing": float(agreeing[k]),
         "scatter": 0.3, "astray": 0.02, "contested": 0.0,
         "uncertainty": 0.001, "ambiguity": 0.0, "otherwise": 0.0, "surely_wrong": False, "gain": 0.0,
         "borne_out": 1.0, "significance": float(rng.uniform(0.0, 4.0)), "strata": ["mild"],
         "normalised": 6.0, "score": 0.5}
        for k in range(count)
    ]  # fmt: skip


def test_what_agrees_counts_and_noise_does_not() -> None:
    found = fitted(rows(400))
    assert found.agreeing > 1.0
    assert abs(found.log2_stretch) < 0.5
    likely, unlikely = chance(found, inputs([{**rows(1)[0], "agreeing": share} for share in (0.95, 0.3)]))
    assert likely > 0.85
    assert unlikely < 0.15


def product_of(probability: float) -> float:
    """The product of the factors that a probability is made of."""
    return float(1.0 / (1.0 + (1.0 / probability - 1.0) ** (1.0 / SETTLED_ODDS_POWER)))


def test_a_model_that_is_likelier_the_other_way_round_is_hardly_believed() -> None:
    one = rows(1)[0]
    told = [one, {**one, "otherwise": 99.0}]
    likely, mirrored = chance(FITTED, inputs(told))
    assert mirrored == pytest.approx(likely / 100.0)


def test_a_model_that_is_surely_wrong_is_believed_less() -> None:
    one = rows(1)[0]
    told = [one, {**one, "surely_wrong": True}]
    likely, wrong = chance(FITTED, inputs(told))
    assert product_of(wrong) == pytest.approx(RIGHT_OF_WRONG_MODEL * product_of(likely))


def test_a_pose_that_its_last_step_leaves_is_believed_less() -> None:
    one = rows(1)[0]
    told = [{**one, "astray": far} for far in (0.0, FAR_ASTRAY, 0.6, 1.0)]
    only_one, alike, doubted, left = chance(FITTED, inputs(told))
    assert only_one == alike > 2.0 * doubted > 4.0 * left


def test_the_command_prints_constants_and_calibration(tmp_path: Path) -> None:
    file, plot = tmp_path / "rows.jsonl", tmp_path / "plot.png"
    file.write_text("".join(json.dumps(row) + "\n" for row in rows(400)))
    ran = CliRunner().invoke(app, ["fit", str(file), "--plot", str(plot)])
    assert ran.exit_code == 0, ran.output
    told = [json.loads(line) for line in ran.output.splitlines()]
    assert told[0]["estimates"] == 400
    used = FITTED._asdict()
    changed = {name for name, value in used.items() if told[0][name] != pytest.approx(value)}
    assert changed == set(OF_LAST_STEP)  # tracking believes poses by the others
    strata = {one["name"]: one for one in told if "calibration error" in one}
    assert list(strata) == ["stratum all", "stratum true models", "stratum mild", "of all models, mild"]
    assert strata["stratum mild"]["calibration error"] < 0.1
    assert strata["stratum mild"]["normalised error, mean"] == 6.0
    assert plot.stat().st_size > 0


def test_the_formula_of_the_fit_is_that_of_the_pipeline(tmp_path: Path) -> None:
    model: Model = cuboid(tmp_path)
    picture = photographed(linear_picture(model, CAMERA, POSE))
    found = estimate_pose(one_image(picture), ["i1"], model, CAMERA, POSE)
    row = row_of(Studio("one", Simulator(), CAMERA, model, POSE), found)
    assert chance(FITTED, inputs([row]))[0] == pytest.approx(found.score, abs=1e-9)


def test_the_constants_in_use_are_judged_without_a_fit(tmp_path: Path) -> None:
    file = tmp_path / "rows.jsonl"
    file.write_text("".join(json.dumps(row) + "\n" for row in rows(400)))
    ran = CliRunner().invoke(app, ["fit", str(file), "--today"])
    assert ran.exit_code == 0, ran.output
    told = {one["name"]: one for one in map(json.loads, ran.output.splitlines())}
    assert "trust coefficients" not in told
    said = chance(FITTED, inputs(rows(400))).mean()
    assert told["stratum all"]["mean probability"] == pytest.approx(said, abs=1e-3)
