"""What else than a line its edge may be: print, the far side of a rounded edge, a shadow running beside it.

Where the true edge has little contrast the other one is taken for it, and its points are as straight and as
many as those of a true one; nothing in them says what they are. That there are two says that the line may be
off by what is between them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geometry.pose import Pose
from geometry.visibility import Samples
from numerics.arrays import Floats, Ints
from numerics.kernels import kernel
from vision_server.channels.gradients import Normals
from vision_server.pose.association import associate
from vision_server.pose.edge_points import search
from vision_server.pose.observation import PoseProblem
from vision_server.pose.sampling import sparse_samples

# By hand. Edges are looked for so far to either side, as print farther away is seldom mistaken for an edge
# that is followed; nearer than the second, an edge is the line's own.
PRINT_REACH_PX, ANOTHER_EDGE_PX = 6.0, 1.0
# Where parallels to the line run: one has an edge where so many samples have an edge point so near to it.
BESIDE_PARALLELS_PX = np.arange(-PRINT_REACH_PX, PRINT_REACH_PX + 0.25, 0.5)
BESIDE_PARALLELS_PX = BESIDE_PARALLELS_PX[np.abs(BESIDE_PARALLELS_PX) >= ANOTHER_EDGE_PX]
LEAST_ON_PARALLEL, ON_PARALLEL_PX = 0.5, 0.75
TAKEN_CHANCE = 0.03  # that another edge along a whole line is taken for the line's own: read off films


class Beside(NamedTuple):
    """Edge points around the visible ones of L lines; N samples.

    Attributes
    ----------
    offset : (C, N, K), px along the normal, NaN for none, those that are nearer to another line left out.
    """

    samples: Samples
    offset: Floats
    lines: int

    def share_at(self, parallels_px: Floats, sign: Floats, width_px: float) -> Floats:
        """Share (L, M) of each line's samples with an edge on parallels (M,) px along ``sign`` * normal."""
        return _shares(self.samples.line, self.lines, self.offset, parallels_px, sign, width_px)

    @property
    def variance_px2(self) -> Floats:
        """Of each line for the edge that runs beside its own, (L,); 0 without any."""
        share = self.share_at(BESIDE_PARALLELS_PX, np.ones(len(self.samples.line)), ON_PARALLEL_PX)
        share[share < LEAST_ON_PARALLEL] = 0.0
        return np.asarray((TAKEN_CHANCE * share * BESIDE_PARALLELS_PX**2).max(axis=1))


@kernel()
def _shares(line: Ints, lines: int, offset: Floats, parallels: Floats, sign: Floats, width: float) -> Floats:
    """See `Beside.share_at`."""
    out, count = np.zeros((lines, len(parallels))), np.zeros(lines)
    for i in range(len(line)):
        count[line[i]] += 1.0
        for m in range(len(parallels)):
            out[line[i], m] += _is_near(offset[:, i], sign[i], parallels[m], width)
    for index in range(lines):
        out[index] /= max(count[index], 1.0)
    return out


@kernel()
def _is_near(offset: Floats, sign: float, parallel: float, width: float) -> bool:
    """Whether one of a sample's edge points (C, K) is on a parallel."""
    for c in range(len(offset)):
        for k in range(offset.shape[1]):
            if abs(sign * offset[c, k] - parallel) <= width:
                return True
    return False


def beside(problem: PoseProblem, pose: Pose) -> Beside:
    """Look around the visible lines of a pose that is within a pixel or two of the right one."""
    lines = len(problem.model.lines)
    samples = sparse_samples(problem.model, problem.camera, pose)
    reach = np.full(len(samples.line), PRINT_REACH_PX)
    scale = np.take(problem.scale, samples.line, axis=1)
    points = search(problem.channels, scale, Normals(samples.image, samples.normal, reach))
    associate(samples, points.offset)
    return Beside(samples, points.offset, lines)
