"""The mixture of orientations: its definition, and the quick form on histograms against it."""

from __future__ import annotations

import numpy as np
import pytest

from numerics.arrays import Field, Floats
from numerics.kernels import kernel
from vision_server.edges.mixture import (
    BACKGROUND_SD_RAD,
    BINS,
    MAIN_SD_RAD,
    MOST_SHARE,
    axial_density,
    axial_difference,
    fit_mixture,
    fit_mixtures,
)

BATCH = 8


@kernel()
def fitted(histograms: Field) -> Field:
    """`fit_mixtures` with room to work in."""
    out = np.empty((3, histograms.shape[1]), np.float32)
    fit_mixtures(histograms, out, np.empty_like(histograms), np.empty((4, histograms.shape[1]), np.float32))
    return out


def window(share: float, mean: float, seed: int) -> tuple[Floats, Floats]:
    """Orientations of a true edge among others of any direction, and their weights."""
    rng = np.random.default_rng(seed)
    count = 400
    main = rng.random(count) < share
    angles = np.where(main, mean + 0.1 * rng.standard_normal(count), np.pi * rng.random(count))
    return angles % np.pi, rng.uniform(0.5, 1.5, count)


@pytest.mark.parametrize("sd_rad", [MAIN_SD_RAD, BACKGROUND_SD_RAD])
def test_the_densities_are_densities(sd_rad: float) -> None:
    difference = (np.arange(1000) + 0.5) / 1000 * np.pi - 0.5 * np.pi
    assert axial_density(difference, sd_rad).mean() * np.pi == pytest.approx(1.0, rel=1e-3)


def test_the_main_density_is_nearly_the_gaussian_of_its_spread() -> None:
    gaussian = np.exp(-0.5 * (0.2 / MAIN_SD_RAD) ** 2) / (np.sqrt(2 * np.pi) * MAIN_SD_RAD)
    assert float(axial_density(0.2, MAIN_SD_RAD)) == pytest.approx(gaussian, rel=0.05)


@pytest.mark.parametrize("share", [0.5, 0.7, 0.9])
def test_the_definition_finds_the_edge_among_shadows(share: float) -> None:
    found, axis = fit_mixture(*window(share, 0.9, 1))
    assert found == pytest.approx(share, abs=0.2)
    assert axial_difference(axis, 0.9) < 0.05


def test_one_orientation_is_all_main() -> None:
    assert fit_mixture(np.full(5, 1.2), np.ones(5)) == (
        pytest.approx(MOST_SHARE, abs=0.01),
        pytest.approx(1.2),
    )


def test_histograms_are_the_definition_on_their_bins() -> None:
    centres = np.pi * np.arange(BINS) / BINS
    histograms = np.empty((BINS, BATCH), np.float32)
    for j in range(BATCH):
        angles, weights = window(0.3 + 0.08 * j, 0.4 * j, j)
        histograms[:, j] = np.bincount(np.round(angles / np.pi * BINS).astype(int) % BINS, weights, BINS)
    share, c, s = fitted(histograms)
    for j in range(BATCH):
        expected, axis = fit_mixture(centres, histograms[:, j].astype(np.float64))
        assert share[j] == pytest.approx(expected, abs=0.01)
        assert axial_difference(0.5 * float(np.arctan2(s[j], c[j])), axis) < 0.005
