"""The edge of a curved line is seen on its inner side: blur draws it towards the centre of curvature.

Along a step whose border bends by k (1/px), blurred by s, the derivative is largest k s^2 / 2 beside the
border, on the side to which it bends. Rims and holes would all seem smaller, and round parts farther away.
Facets that are long beside the blur are straight: they are drawn in near their ends alone.
"""

from __future__ import annotations

import numpy as np

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from geometry.visibility import Samples
from numerics.arrays import Floats
from numerics.kernels import kernel

# Blur of the image at an edge over what its line's softness is taken for: of a good lens, 0.6 px, and of the
# pixel's own area, 0.29, together, where the softness is 1 px.
BLUR_OVER_SOFTNESS = 0.7
BEND_REACH_PX = 12.0  # chosen by hand: a bend is measured so far to either side, past a facet of most rims
# In the middle of a facet of length l of a polygon, blur draws the edge in by 4 r times the sum over j of
# h((j + 1/2) r) of what it does to a curve, r = l / s and h(x) = phi(x) - x Phi(-x): exp(-(r / 3)^2) to 0.05.
LONG_FACET_BLURS = 3.0


def drawn_in(samples: Samples, facets: Floats, softness: Floats, filter_px: Floats) -> Floats:
    """How far along the normal each edge is seen beside its line, (C, N) px.

    Parameters
    ----------
    samples
        N, on the visible lines.
    facets
        (N,), px, how long the facet is on which each of them is, see `facet_lengths`.
    softness, filter_px
        (C, N), px, what its line is taken for in each of C channels, and the filter that looks there.
    """
    square = filter_px**2 + (BLUR_OVER_SOFTNESS * softness) ** 2
    curved = np.exp(-((facets / LONG_FACET_BLURS) ** 2) / square)
    return np.asarray(0.5 * square * curved * bend(samples))


def facet_lengths(model: Model, camera: Camera, pose: Pose, samples: Samples) -> Floats:
    """How long the lines of the mesh are on which the samples are, (N,) px."""
    own, of = np.unique(samples.own, return_inverse=True)
    ends = camera.project(pose.apply(model.vertices[model.lines[own].ravel()])).reshape(-1, 2, 2)
    return np.asarray(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)[of])


@kernel()
def bend(samples: Samples) -> Floats:
    """How each line bends at its samples, (N,) 1/px, greater than 0 towards the normal.

    That of the circle through the sample and those BEND_REACH_PX to either side, or as far as there are some.
    """
    line, image, direction = samples.line, samples.image, samples.image_direction
    count = len(line)
    out = np.zeros(count)
    first = 0
    while first < count:
        last = first
        while last + 1 < count and line[last + 1] == line[first]:
            last += 1
        for i in range(first, last + 1):
            reach = min(max(1, int(BEND_REACH_PX / max(samples.px[i], 1e-9))), (last - first) // 2)
            if reach == 0:
                continue
            middle = min(max(i, first + reach), last - reach)
            ax = image[middle, 0] - image[middle - reach, 0]
            ay = image[middle, 1] - image[middle - reach, 1]
            bx = image[middle + reach, 0] - image[middle, 0]
            by = image[middle + reach, 1] - image[middle, 1]
            sides = (ax * ax + ay * ay) * (bx * bx + by * by) * ((ax + bx) ** 2 + (ay + by) ** 2)
            if sides > 0.0:
                near, far = max(first, i - 1), min(last, i + 1)
                ahead = direction[i, 0] * (image[far, 0] - image[near, 0])
                ahead += direction[i, 1] * (image[far, 1] - image[near, 1])
                out[i] = np.copysign(1.0, ahead) * 2.0 * (ax * by - ay * bx) / np.sqrt(sides)
        first = last + 1
    return out
