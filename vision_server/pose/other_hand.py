"""Is the model the right way round? Where most of it is out of sight, a mirrored or turned one is tried.

A model that is mirrored, or lies upside down, shows its plain back where the part shows its front: few lines,
all of them seen, and nothing of its own speaks against them. The same model the other way round explains what
these few lines leave.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from geometry.model import Model
from geometry.pose import Pose
from geometry.surface import face_normals
from vision_server.pose.observation import PoseProblem
from vision_server.pose.ranking import Refined, best_first
from vision_server.pose.trust import odds

Floats = NDArray[np.float64]

HIDDEN_SHARE = 0.5  # of a model's lines: when fewer are out of sight, those in sight tell (by hand); ...
IN_SIGHT = 9  # ... and so do more than the lines that a plain box shows
UNLIKELY_NATS = 10.0  # of evidence, that a model is the right way round, as for turns (chosen by hand)
LOOKED_AT = 2  # hypotheses of each other way
WAYS = tuple(np.diag(signs) for signs in np.array(
    [[-1, 1, 1], [1, -1, 1], [1, 1, -1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=np.float64
))  # fmt: skip


def changed(model: Model, change: Floats) -> Model:
    """The model with what is beside its middle multiplied by a matrix (3, 3)."""
    vertices = model.middle + (model.vertices - model.middle) @ change.T
    faces, triangles = model.faces, model.triangles
    if np.linalg.det(change) < 0.0:
        faces, triangles = tuple(face[::-1] for face in faces), triangles[:, ::-1]
    return replace(
        model, vertices=vertices, faces=faces, triangles=triangles, face_normals=face_normals(vertices, faces)
    )


def the_other_way(best: Refined, match: Callable[[Model], Sequence[Pose]]) -> float:
    """Chance that the model is mirrored or turned by half over that it is not, at most 1.

    Parameters
    ----------
    match
        Hypotheses for another model from the same segments and seed pose, best first.
    """
    model = best.problem.model
    if len(best.support.lines) > min(IN_SIGHT, (1.0 - HIDDEN_SHARE) * len(model.lines)):
        return 0.0
    most = 0.0
    for way in WAYS:
        other = changed(model, way)
        own = best.problem
        problem = PoseProblem.at_scale(
            own.channels, other, own.camera, tone_sd_px=own.tone_sd_px, tolerance_m=own.tolerance_m
        )
        for found in best_first(problem, match(other), LOOKED_AT):
            most = max(most, odds(best.support, found.support, UNLIKELY_NATS))
    return most
