"""How far lines of a part are off its model's, where nobody has told.

The covariance allows for what is usual. Whether the pose does, too, the lines tell: those of a part that is
its model lie where the pose has them, as nearly as what lies beside them lets them; those of many a real one
are off by more. The likelihood of what they are off, with a variance of the part's own beside that of each
line and without, decides (a random-effects model, as of DerSimonian and Laird 1986; here of Student's t).
"""

from __future__ import annotations

import numpy as np

from numerics.arrays import Floats
from vision_server.pose.courses import TURN_SPREAD_RATIO, Courses
from vision_server.trust.tails import Held

# Of what is usual, how much is tried; and by how many nats lines must ask for one of these. What bends a part
# moves lines near each other alike: among themselves they are off by less than in all (docs/pose.md).
TRIED, ASKED_NATS = (0.25, 0.5, 1.0, 2.0), 1.0


def are_off(courses: Courses, step: Floats, usual_m: float, freedom: float) -> bool:
    """Whether lines ask for a tolerance by what unknowns (K,) leave them off.

    Parameters
    ----------
    usual_m
        How far a line of such a part may be off: one standard deviation, m.
    freedom
        Degrees of freedom of Student's t.
    """
    off = courses.place - courses.motion @ step
    without = _nats(courses, off, freedom)
    told = (with_tolerance(courses, share * usual_m) for share in TRIED)
    return any(without - _nats(one, off, freedom) > ASKED_NATS for one in told)


def with_tolerance(courses: Courses, tolerance_m: float) -> Courses:
    """The courses of a part each of whose lines may be off by so much: one standard deviation, m."""
    return courses._replace(spread=np.hypot(courses.spread, tolerance_m * _px_per_m(courses)))


def of_lines_off(held: Held, step: Floats, courses: Courses, tolerance_m: float) -> Floats:
    """Covariance (6, 6) of a pose by a part each of whose lines may be off by so much.

    Parameters
    ----------
    held, step
        What holds the pose, and the likeliest unknowns (J,); ``courses`` are the same, px.
    tolerance_m
        One standard deviation. All channels show the same line.
    """
    squares = held.squares(step)
    normal, _ = held.equations(squares)
    weight = held.weights(squares) * _px_per_m(courses)
    white = np.linalg.inv(np.linalg.cholesky(courses.variance))
    pulls = np.einsum("m,mik,mij->mkj", weight, held.motion, white)
    lines, of_line = np.unique(courses.line, return_inverse=True)
    moved = np.zeros((len(lines), *pulls.shape[1:]))
    np.add.at(moved, of_line, pulls)
    moved = np.linalg.solve(normal, moved)[:, :6] * (tolerance_m * np.array([1.0, TURN_SPREAD_RATIO]))
    return np.asarray(np.einsum("lij,lkj->ik", moved, moved))


def _px_per_m(courses: Courses) -> Floats:
    return np.asarray(np.sqrt((courses.motion[:, 0, 3:6] ** 2).sum(axis=1)))


def _nats(courses: Courses, off: Floats, freedom: float) -> float:
    """-ln of the likelihood that places are ``off`` (M, 2) px, but for what is the same for every spread."""
    variance = courses.variance
    a, b, d = variance[:, 0, 0], variance[:, 0, 1], variance[:, 1, 1]
    determinant = a * d - b * b
    u, v = off.T
    squares = (d * u * u - 2.0 * b * u * v + a * v * v) / determinant
    return 0.5 * float(courses.share @ ((freedom + 2.0) * np.log1p(squares / freedom) + np.log(determinant)))
