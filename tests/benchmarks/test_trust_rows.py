"""Rows for the trust: one model of three is true, scenes are of their number, strata as drawn."""

import numpy as np
import pytest

from benchmarks import trust_rows
from benchmarks.trust_rows import apart_px, models, rows_of, simulated, strata_of
from geometry.model import find_target, load_model
from vision_server.trust.judgement import Estimate
from vision_server.trust.stretch import stretched


def test_one_model_of_three_is_true() -> None:
    model = load_model(find_target("fixture"))
    for seed in range(8):
        told = dict(models(model, np.random.default_rng(seed)))
        assert len(told) == 3
        assert told.pop("true") is model
        for wrong in told.values():
            same = wrong.vertices.shape == model.vertices.shape
            assert not (same and np.allclose(wrong.vertices, model.vertices))


def test_a_simulated_scene_is_of_its_number() -> None:
    (name, studio, empty), (_, again, _) = simulated(1, 5), simulated(1, 5)
    assert name == "simulated textured+blur bus-1 5"
    assert not empty
    assert studio.true.error_to(again.true).within(1e-9, 1e-9)
    np.testing.assert_array_equal(studio.model.vertices, again.model.vertices)
    shots = [studio.photograph(studio.middle)]
    assert "blurred" in strata_of(name, shots, studio.model)
    assert "hidden" not in strata_of(name, shots, studio.model)
    assert strata_of("stacks/wheel-4", shots, studio.model)[-3:] == ["blurred", "hidden", "symmetric"]
    assert not {"blurred", "hidden"} & set(strata_of("stacks/part-2", shots, studio.model))


def test_lines_of_a_model_are_so_far_from_the_true_ones_as_it_is() -> None:
    _, studio, _ = simulated(0, 5)
    assert apart_px(studio, studio.model, Estimate(pose=studio.true)) == 0.0
    longer = apart_px(studio, stretched(studio.model, np.array([0.1, 0.0, 0.0])), Estimate(pose=studio.true))
    assert longer is not None
    assert longer > 3.0


@pytest.mark.slow
def test_rows_say_whether_a_pose_is_right(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trust_rows, "SETS", trust_rows.SETS[:2])
    name, studio, empty = simulated(0, 5)
    rows = rows_of(name, studio, empty, 5)
    assert len(rows) == 6
    right = [row for row in rows if row["model"] == "true"]
    assert all(row["within"] and row["score"] > 0.9 for row in right)
    assert right[0]["normalised"] < 30.0
