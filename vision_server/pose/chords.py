"""How far the lines of a round part lie outside of the chords that its model has for them, in the image."""

from __future__ import annotations

import numpy as np

from geometry.facets import beyond_mesh
from geometry.model import Model
from geometry.pose import Pose
from geometry.visibility import Samples
from numerics.arrays import Floats


def beyond_chords(model: Model, pose: Pose, samples: Samples, jacobian: Floats) -> Floats:
    """How far along their normals lines are, px per roundness (0 is as the mesh, 1 smooth).

    Parameters
    ----------
    jacobian
        (N, 6), px per unit of a step, of the samples, see `steps.step_jacobian`.

    Returns
    -------
    (N, 1); (N, 0) where nothing is round.
    """
    beyond = beyond_mesh(model, pose, samples)
    if beyond is None:
        return np.empty((len(samples.line), 0))
    return np.asarray((jacobian[:, 3:] * (beyond @ pose.matrix.T)).sum(axis=1, keepdims=True))
