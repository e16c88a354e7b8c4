"""Which face of a model is in front at each pixel of a view: a depth buffer."""

import math

import numpy as np
from numpy.typing import NDArray

from numerics.arrays import Flags, Floats, Ints
from numerics.kernels import kernel


@kernel()
def faces_in_front(
    rows: int, columns: int, image: Floats, nearness: Floats, triangles: Ints, faces: Ints, shown: Flags
) -> NDArray[np.int32]:
    """The face in front at the middle of each pixel, (rows, columns), -1 for none.

    Parameters
    ----------
    image : (V, 2), px, where the vertices are seen.
    nearness : (V,), one over their depths, all positive: it is linear across a plane's image.
    triangles, faces : (T, 3) vertices and (T,) face of each triangle.
    shown : (F,), which faces count.
    """
    out = np.full((rows, columns), -1, np.int32)
    nearest = np.zeros((rows, columns))
    for t in range(len(triangles)):
        if not shown[faces[t]]:
            continue
        a, b, c = triangles[t]
        ax, ay, bx, by, cx, cy = image[a, 0], image[a, 1], image[b, 0], image[b, 1], image[c, 0], image[c, 1]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if area == 0.0:
            continue
        left, right = max(0.0, min(ax, bx, cx)), min(columns - 1.0, max(ax, bx, cx))
        top, bottom = max(0.0, min(ay, by, cy)), min(rows - 1.0, max(ay, by, cy))
        for y in range(math.ceil(top), math.floor(bottom) + 1):
            for x in range(math.ceil(left), math.floor(right) + 1):
                of_a = ((bx - x) * (cy - y) - (by - y) * (cx - x)) / area
                of_b = ((cx - x) * (ay - y) - (cy - y) * (ax - x)) / area
                of_c = 1.0 - of_a - of_b
                near = of_a * nearness[a] + of_b * nearness[b] + of_c * nearness[c]
                if min(of_a, of_b, of_c) >= 0.0 and near > nearest[y, x]:
                    out[y, x], nearest[y, x] = faces[t], near
    return out
