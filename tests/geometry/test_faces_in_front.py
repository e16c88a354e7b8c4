"""The depth buffer against a ray through the middle of each pixel."""

import numpy as np
import pytest

from geometry.faces_in_front import faces_in_front
from numerics.arrays import Floats, Ints
from tests.geometry.triangles import soup

ROWS, COLUMNS, FOCAL = 48, 64, 60.0


def by_rays(corners: Floats, shown: np.ndarray) -> Ints:
    """The nearest of triangles (T, 3, 3) in the camera's frame that each pixel's ray meets, -1 for none."""
    y, x = np.mgrid[:ROWS, :COLUMNS]
    rays = np.stack([(x - COLUMNS / 2) / FOCAL, (y - ROWS / 2) / FOCAL, np.ones(x.shape)], axis=-1)
    out, nearest = np.full((ROWS, COLUMNS), -1), np.full((ROWS, COLUMNS), np.inf)
    for number in np.flatnonzero(shown):
        shares = rays @ np.linalg.inv(corners[number])  # the ray is so many times each corner
        depth = 1.0 / shares.sum(axis=-1)
        met = (shares >= 0.0).all(axis=-1) & (depth < nearest)
        out[met], nearest[met] = number, depth[met]
    return out


@pytest.mark.parametrize("seed", range(4))
def test_at_each_pixel_it_is_the_face_that_a_ray_meets_first(seed: int) -> None:
    vertices, triangles = soup(seed)
    points = vertices + np.array([0.0, 0.0, 5.0])
    shown = np.random.default_rng(seed).random(len(triangles)) < 0.8
    image = FOCAL * points[:, :2] / points[:, 2:] + [COLUMNS / 2, ROWS / 2]
    faces = np.arange(len(triangles))
    found = faces_in_front(ROWS, COLUMNS, image, 1.0 / points[:, 2], triangles, faces, shown)
    expected = by_rays(points[triangles], shown)
    assert (found == expected).all()
    assert len(np.unique(found)) > 8
