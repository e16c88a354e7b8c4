"""The usual merges, kept for comparison."""

from __future__ import annotations

import numpy as np
import pytest

from tests.vision_server.edge_scenes import polygon_with_shadows, step
from vision_server.baselines.merge_rules import comparison_edges

METHODS = ["mean", "max-image", "max-gradient", "di-zenzo", "mertens"]


@pytest.mark.parametrize("method", METHODS)
def test_every_rule_finds_the_edge_that_all_images_share(method: str) -> None:
    images = [step(0.6, 0.0, 60, 160, noise=1.0, seed=seed) for seed in range(3)]
    edges = comparison_edges(images, method)  # type: ignore[arg-type]
    y, x = np.argwhere(edges.ridge > 0.7 * edges.ridge[10:-10, 10:-10].max()).T
    across = (x - 63.5) * np.cos(0.6) + (y - 47.5) * np.sin(0.6)
    inner = (y > 8) & (y < 88) & (x > 8) & (x < 120)
    assert inner.sum() > 60
    assert np.quantile(np.abs(across[inner]), 0.95) < 1.0


@pytest.mark.parametrize("method", METHODS[:4])
def test_one_image_is_its_own_merge(method: str) -> None:
    image = step(0.3, 0.0, 60, 160)
    alone, mean = comparison_edges([image], method), comparison_edges([image], "mean")  # type: ignore[arg-type]
    np.testing.assert_allclose(alone.ridge, mean.ridge, rtol=1e-3, atol=1e-2)


def test_di_zenzo_is_the_largest_eigenvalue_of_the_summed_tensor() -> None:
    images = polygon_with_shadows(3)
    edges = comparison_edges(images, "di-zenzo")
    singles = [comparison_edges([image], "mean") for image in images]
    shared = [place for place in edges.places if all(single.index.ravel()[place] >= 0 for single in singles)]
    place = max(shared, key=lambda place: edges.strength[edges.index.ravel()[place]])
    tensor = np.zeros((2, 2))
    for single in singles:
        at = single.index.ravel()[place]
        gradient = single.strength[at] * single.normals[at].astype(np.float64)
        tensor += np.outer(gradient, gradient) / len(singles)
    strongest = edges.strength[edges.index.ravel()[place]]
    assert strongest == pytest.approx(np.sqrt(np.linalg.eigvalsh(tensor)[-1]), rel=1e-3)


def test_exposures_are_divided_out() -> None:
    image = step(0.3, 0.0, 40, 100)
    double = (image * 2).astype(np.uint8)
    same = comparison_edges([image, double], "max-image", [1.0, 2.0])
    alone = comparison_edges([image], "mean")
    strong = alone.ridge > 20.0
    np.testing.assert_allclose(same.ridge[strong], alone.ridge[strong], rtol=0.02)
