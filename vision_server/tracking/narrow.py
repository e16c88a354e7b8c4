"""Lines whose edges may be those of the lines across a face that is seen narrow.

Where such a face is as dark as what is behind it, one edge is seen instead of two, and it may be either's: an
outline sits on a crease, or on the far edge of a thin plate. Points and residuals are as good there as on the
right one, and the pose is held, some degrees off, by lines that say nothing of that. Whatever pose is
taken of a frame, by following or by a search, is therefore looked at from aside before it is told.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import RIGHT, Pose
from numerics.arrays import Floats, Ints
from numerics.kernels import kernel
from vision_server.pose.steps import moved, turning_point
from vision_server.tracking.acceptance import EXACT_WITHIN, SURE, is_exact
from vision_server.tracking.fitting import Habits
from vision_server.tracking.following import MOST_CLIMBS, Found, Sight, looked_again
from vision_server.tracking.motion import about
from vision_server.trust.probability import RIVAL_NATS
from vision_server.trust.ranking import ONE_BASIN

NARROW_PX = 5.0  # width of a face across a line, as far as edges are looked for around the line (by hand)
ANOTHER_BEYOND = RIGHT  # of two poses farther apart one is wrong
# Of 108 looks aside (a thin card, a nut's plate, a ring with petals) none that the first step brought back
# so far ended elsewhere than at the pose.
CAME_BACK = ONE_BASIN
# By hand, in units of EXACT_WITHIN: poses are looked for so far aside; what other lines leave open by more,
# one sd, they say nothing of.
ASIDE_TIMES, MOST_OPEN_SD = (-1.0, 1.0), 4.0
# Of other fits the covariance is several times too wide. One that hangs on lines beside narrow faces may have
# some of them on the wrong edge, and is off by what it states: it has to state what is right.
HELD_WITHIN = RIGHT


def firmest(found: Found, sight: Sight, habits: Habits) -> tuple[Found, bool]:
    """Of the poses that narrow faces leave open, the one that a frame supports best; and whether it is clear.

    Where a pose is not exact without the lines beside narrow faces, another is looked for aside, in the
    direction in which other lines tell least; it has to be believed, as print may explain a wrong one better.
    What is held by the lines beside such faces is clear only where these hold it within HELD_WITHIN.
    """
    second, open_by = -math.inf, 0.0
    for _ in range(MOST_CLIMBS):
        more_px2 = narrow_px2(sight.model, sight.camera, found.pose)
        spread = found.fit.covariance_with(more_px2) if more_px2.any() else found.covariance
        if not more_px2.any() or is_exact(found.pose, spread):
            open_by = 0.0
            break
        centre = turning_point(sight.model, found.pose)
        open_by, step = _weakest(centre, spread)
        starts = (moved(found.pose, size * step, centre) for size in ASIDE_TIMES)
        seen = (looked_again(found, start, habits, CAME_BACK) for start in starts)
        looked = [one for one in seen if one is not None]
        others = [one for one in looked if not found.pose.error_to(one.pose).within(*ANOTHER_BEYOND)]
        best = max(others, key=lambda one: one.evidence, default=None)
        if best is None:
            break
        if best.evidence <= found.evidence or best.belief(0.0) < SURE:
            second = max(second, best.evidence)
            break
        second, found = max(second, found.evidence), best
    held = open_by == 0.0 or is_exact(found.pose, found.covariance, HELD_WITHIN)
    return found, held and open_by < MOST_OPEN_SD and second < found.evidence - RIVAL_NATS


def _weakest(centre: Floats, covariance: Floats) -> tuple[float, Floats]:
    """Largest standard deviation, in EXACT_WITHIN, and a step (6,) about a centre (3,) that is one long."""
    unit = np.repeat([np.radians(EXACT_WITHIN[0]), EXACT_WITHIN[1] * float(np.linalg.norm(centre))], 3)
    value, axis = np.linalg.eigh(about(centre, covariance) / np.outer(unit, unit))
    return float(np.sqrt(value[-1])), axis[:, -1] * unit


def narrow_px2(model: Model, camera: Camera, pose: Pose) -> Floats:
    """Variance of each line (L,) if its edge is that across a narrow face, px^2; 0 beside none."""
    if not model.faces:
        return np.zeros(len(model.lines))
    across, focal = _across(model) @ pose.matrix.T, np.array([camera.fx, camera.fy])
    return _narrow_px2(pose.apply(model.vertices), model.lines, across, focal)


@kernel()
def _narrow_px2(points: Floats, lines: Ints, across: Floats, focal: Floats) -> Floats:
    """Of lines between points (V, 3), with what is `_across` them, both in the camera frame."""
    out = np.zeros(len(lines))
    for i in range(len(lines)):
        one, two = points[lines[i, 0]], points[lines[i, 1]]
        if one[2] <= 0.0 or two[2] <= 0.0:
            continue
        middle = 0.5 * (one + two)
        along = focal * (two[:2] / two[2] - one[:2] / one[2])
        for side in range(2):
            far = middle + across[side, i]
            whole = focal[1] * math.sqrt((across[side, i] ** 2).sum()) / middle[2]
            if whole > 0.0 and far[2] > 0.0:
                off = focal * (far[:2] / far[2] - middle[:2] / middle[2])
                area = abs(along[0] * off[1] - along[1] * off[0])
                if area < NARROW_PX * math.sqrt((along**2).sum()):
                    out[i] = max(out[i], min(whole, NARROW_PX) ** 2)
    return out


@lru_cache(maxsize=8)
def _across(model: Model) -> Floats:
    """From each line at a right angle to the farthest corner of its two faces, (2, L, 3) m, model frame.

    0 without a face, and of lines of curved surfaces, whose faces are no flat ones.
    """
    out = np.zeros((2, len(model.lines), 3))
    for line, (start, end) in enumerate(model.vertices[model.lines]):
        along = (end - start) / np.linalg.norm(end - start)
        for side, face in enumerate(model.line_faces[line]):
            if face >= 0 and not model.smooth[line]:
                off = model.vertices[model.faces[face]] - start
                off = off - np.outer(off @ along, along)
                out[side, line] = off[np.argmax((off**2).sum(axis=1))]
    return out
