"""The commands behind the simulator's pages: pictures of scenarios, POV-Ray beside it, measured curves."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks import photon_transfer, povray, simulator_times, validation
from benchmarks.lines import show
from benchmarks.scenario_pictures import CLIPPED_GREY, picture

pytestmark = pytest.mark.slow


def test_a_picture_of_a_scenario_is_well_exposed() -> None:
    pixels = picture("eclipse", "cube")
    lit = pixels[pixels > 20]
    assert len(lit) > 5000
    assert np.mean(lit >= CLIPPED_GREY) < 0.05
    assert np.median(lit) > 40


def test_without_pov_ray_the_comparison_says_so(root: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks.validation"],
        cwd=root, env={"PATH": "/nowhere"}, capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert done.returncode == 0
    assert "POV-Ray is not installed" in done.stderr
    assert done.stdout == ""


@pytest.mark.skipif(not povray.available(), reason="POV-Ray (Debian package povray) is not installed")
def test_a_comparison_draws_and_tells(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    case = validation.CASES[0]
    monkeypatch.setattr(validation, "CASES", (replace(case, samples=1),))
    validation.main(tmp_path, case.name)
    table = capsys.readouterr().out.splitlines()
    assert any("faces in the light" in row for row in table)
    assert (tmp_path / f"{case.name}.png").stat().st_size > 10000


def test_the_lights_that_stand_for_the_sun_lie_evenly_on_its_disc() -> None:
    disc = validation.sun_disc(4.0)
    assert len(disc) == validation.DISC_LIGHTS
    angles = np.degrees(np.arccos(np.clip(disc @ validation.SUN, -1, 1)))
    assert angles.max() < 2.0
    assert np.mean(angles**2) == pytest.approx(2.0**2 / 2, rel=0.03)  # as over an even disc
    assert disc.mean(axis=0) == pytest.approx(validation.SUN, abs=1e-3)


def test_errors_are_told_by_region() -> None:
    case = validation.CASES[0]
    other = np.full((4, 4), 0.5, np.float32)
    mine = other.copy()
    mine[0] += 0.01
    masks = {"top": np.arange(16).reshape(4, 4) < 4, "none": np.zeros((4, 4), bool)}
    (row,) = validation.rows(case, mine, other, masks)
    assert "| top | 4 | +2.000 | 2.000 | 2.000 |" in row


def test_measured_curves_are_drawn(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(photon_transfer, "GAINS", (2.0,))
    monkeypatch.setattr(photon_transfer, "FRAMES", 1)
    file = tmp_path / "curves.png"
    photon_transfer.main(file)
    assert "| 2 | 2.00e-04 |" in capsys.readouterr().out
    assert file.stat().st_size > 5000


def test_measurements_are_printed_as_json_lines(capsys: pytest.CaptureFixture[str]) -> None:
    simulator_times.line(show, "first_frame", (1.23456, 2.0), which="nominal,cube", ratio=3.0)
    assert json.loads(capsys.readouterr().out) == {
        "name": "simulator/first_frame", "value": 1.2346, "unit": "ms",
        "processor_ms": 2.0, "which": "nominal,cube", "ratio": 3.0,
    }  # fmt: skip
