"""The fit of the trust finds what decides, and says how well it is calibrated."""

import json
from pathlib import Path

import numpy as np
from typer.testing import CliRunner

from benchmarks.trust_fit import app, fitted


def rows(count: int) -> list[dict[str, object]]:
    """Estimates that are right the more often, the more lines confirm them."""
    rng = np.random.default_rng(3)
    confirmed = rng.uniform(0.0, 60.0, count)
    right = rng.random(count) < 1.0 / (1.0 + np.exp(-0.2 * (confirmed - 30.0)))
    return [
        {"scene": f"s{k % 20}", "model": "true", "empty": False, "pose": True, "within": bool(right[k]),
         "right": bool(right[k]), "confirmed": float(confirmed[k]), "missing": float(rng.uniform(0.0, 0.5)),
         "uncertainty": 0.001, "ambiguity": 0.0, "gain": 0.0, "significance": 0.0}
        for k in range(count)
    ]  # fmt: skip


def test_what_confirms_counts_and_noise_does_not() -> None:
    of, constants = fitted(rows(400))
    assert constants[1] > 1.0
    assert abs(constants[2]) < 0.5
    chance = of([{**rows(1)[0], "confirmed": 55.0}, {**rows(1)[0], "confirmed": 5.0}])
    assert chance[0] > 0.85
    assert chance[1] < 0.15


def test_the_command_prints_constants_and_calibration(tmp_path: Path) -> None:
    file, plot = tmp_path / "rows.jsonl", tmp_path / "plot.png"
    file.write_text("".join(json.dumps(row) + "\n" for row in rows(400)))
    ran = CliRunner().invoke(app, ["fit", str(file), "--plot", str(plot)])
    assert ran.exit_code == 0, ran.output
    told = [json.loads(line) for line in ran.output.splitlines()]
    assert told[0]["estimates"] == 400
    assert told[-1]["value"] < 0.1
    assert plot.stat().st_size > 0
