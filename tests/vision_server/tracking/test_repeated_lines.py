"""Lines that a model repeats are told, and count as what they are: witnesses that err together."""

import numpy as np

from benchmarks.machined_parts import drilled, surface_of
from geometry.model import Model
from numerics.arrays import Floats, Ints
from vision_server.tracking.fitting import Habits, solved
from vision_server.tracking.lines import LineFits
from vision_server.tracking.repeated_lines import repetition

ROW, ALONE = 20, 8  # lines
COMMON_PX, OWN_PX = 0.35, 0.1


def rectangle(left: float, right: float, below: float, above: float) -> Floats:
    return np.array([[left, below], [right, below], [right, above], [left, above]])


def slotted() -> Model:
    """A plate of 200 by 100 mm with five slots."""
    slots = [rectangle(x, x + 0.005, -0.03, 0.03) for x in np.arange(5) * 0.02 - 0.05]
    outline = rectangle(-0.1, 0.1, -0.05, 0.05)
    return Model.of_surface("plate", surface_of([drilled(outline, slots, 0.0, 0.02)]))


def test_the_lips_of_slots_are_rows_and_the_outline_is_of_none() -> None:
    model = slotted()
    rows, ends = repetition(model), model.vertices[model.lines]
    outline = (np.abs(ends[:, :, 0]) > 0.099).all(axis=1) | (np.abs(ends[:, :, 1]) > 0.049).all(axis=1)
    along = ends[:, 1] - ends[:, 0]
    lips = np.isclose(np.abs(along[:, 1]), 0.06)
    assert lips.sum() == 20
    assert (rows[lips] != 0).all()
    assert (rows[outline] == 0).all()
    for row in np.unique(np.abs(rows[rows != 0])):
        own = along[np.abs(rows) == row] * np.sign(rows[np.abs(rows) == row])[:, None]
        np.testing.assert_allclose(own, np.broadcast_to(own[0], own.shape), atol=1e-6)


def squared_errors(row: Ints) -> Floats:
    """Of poses, by their covariances, fitted to a row that is off as one and to lines that are off alone."""
    rng, found = np.random.default_rng(4), []
    count, habits = ROW + ALONE, Habits(0.2**2, 4.0, 0.0, 1e-6, 0.0)
    prior = np.r_[np.repeat([1.0, 4.0], 3), 100.0, 100.0, habits.radius_sd_m**-2.0]
    for _ in range(60):
        rows = rng.normal(size=(count, 2, 9)) * [300, 300, 300, 500, 500, 500, 0, 0, 0]
        rows[:ROW] = rows[0] + 0.05 * (rows[:ROW] - rows[0])
        value = rng.normal(0.0, OWN_PX, (count, 2))
        value[:ROW, 0] += COMMON_PX * rng.normal()
        lines = LineFits(value, np.full((count, 2), 0.02**2), rows, np.zeros(count), np.arange(count))
        step, covariance, _, _ = solved(lines, prior, habits, row)
        found.append(step[:6] @ np.linalg.solve(covariance[:6, :6], step[:6]))
    return np.array(found)


def test_a_row_that_is_off_as_one_makes_no_pose_too_exact() -> None:
    together = squared_errors(np.r_[np.ones(ROW, np.int64), np.zeros(ALONE, np.int64)])
    apart = squared_errors(np.zeros(ROW + ALONE, np.int64))
    assert np.mean(together < 16.81) > 0.9
    assert np.mean(apart < 16.81) < 0.75
