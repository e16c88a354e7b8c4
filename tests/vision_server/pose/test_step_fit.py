"""The blurred step's fit against SciPy's least squares and against its own scatter."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.special import ndtr

from vision_server.pose.step_fit import FIT, fit_step

Floats = NDArray[np.float64]
TRUE = np.array([40.0, 3.0, 90.0, -8.0, 0.15, 0.05, 0.8])  # A, H, u at the middle and their changes; blur


def profile(place: Floats, share: Floats, fit: Floats) -> Floats:
    """The same equation in plain NumPy."""
    step = ndtr((place - fit[4] - share * fit[5]) / fit[6])
    return np.asarray(fit[0] + share * fit[1] + (fit[2] + share * fit[3]) * step)


def pixels(seed: int, noise: float, slope: float = 0.0) -> tuple[Floats, Floats, Floats, int]:
    """Places, nearest first, shares and values of the pixels beside a line; how many are near."""
    rng = np.random.default_rng(seed)
    place, share = rng.uniform(-12.0, 12.0, 900), rng.uniform(-1.0, 1.0, 900)
    order = np.argsort(np.abs(place))
    place, share = place[order], share[order]
    value = profile(place, share, TRUE) + slope * np.abs(place) + rng.normal(0.0, noise, 900)
    return place, share, value, int((np.abs(place) <= 4.0).sum())


def fitted(seed: int, noise: float, slope: float = 0.0) -> tuple[Floats, Floats, tuple[float, float, float]]:
    place, share, value, near = pixels(seed, noise, slope)
    fit, inverse = np.zeros(FIT), np.zeros((FIT, FIT))
    said = fit_step(place, share, value, np.full(900, noise**2), near, 1.0, fit, inverse)
    return fit, inverse, said


def test_it_is_the_least_squares_fit() -> None:
    fit, inverse, (misfit, _, _) = fitted(0, 4.0)
    place, share, value, _ = pixels(0, 4.0)
    plain = least_squares(lambda x: (profile(place, share, x) - value) / 4.0, TRUE, xtol=1e-12)
    assert np.abs(fit[4:6] - plain.x[4:6]).max() < 1e-3
    assert np.abs(fit[:4] - plain.x[:4]).max() < 0.05
    assert misfit == pytest.approx(2.0 * plain.cost / (900 - FIT), rel=1e-3)
    covariance = np.linalg.inv(plain.jac.T @ plain.jac)
    assert np.diag(inverse)[:6] == pytest.approx(np.diag(covariance)[:6], rel=0.02)


def test_the_stated_noise_is_the_scatter() -> None:
    found = [fitted(seed, 6.0) for seed in range(200)]
    normalised = [(fit[4] - TRUE[4]) / np.sqrt(inverse[4, 4]) for fit, inverse, _ in found]
    assert np.mean(normalised) == pytest.approx(0.0, abs=0.25)
    assert np.std(normalised) == pytest.approx(1.0, abs=0.15)


def test_slopes_across_the_sides_are_told() -> None:
    """By how much the place moves once they are allowed, in units of the noise of that."""
    plain = [said[1] / said[2] for _, _, said in (fitted(seed, 2.0) for seed in range(30))]
    shaded = [said[1] / said[2] for _, _, said in (fitted(seed, 2.0, 0.5) for seed in range(30))]
    assert np.std(plain) < 1.4
    assert np.abs(shaded).min() > 3.0


def test_no_step_is_refused() -> None:
    fit, inverse = np.zeros(FIT), np.zeros((FIT, FIT))
    place, share = np.linspace(0.1, 8.0, 100), np.zeros(100)
    misfit, _, _ = fit_step(place, share, np.full(100, 50.0), np.ones(100), 50, 1.0, fit, inverse)
    assert misfit == np.inf
