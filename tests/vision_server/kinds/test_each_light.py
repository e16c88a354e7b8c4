"""The kernels of what each light does, and of scatters, beside the same equations in NumPy."""

from __future__ import annotations

import math

import numpy as np
import pytest

from numerics.arrays import Floats
from tests.vision_server.level_samples import edgels_of
from vision_server.kinds import each_light, scatter
from vision_server.kinds.blocked import FLAT_SD
from vision_server.kinds.densities import logarithms
from vision_server.kinds.sides import Sides


def some_sides(channels: int, count: int = 400) -> Sides:
    random = np.random.default_rng(channels)
    near = random.gamma(1.5, 40.0, (channels, 2, count))
    near[:, 1] = np.where(random.random((channels, count)) < 0.8, near[:, 0], near[:, 1])  # many are alike
    near *= random.random(near.shape) < 0.8  # and some are nothing
    near = near.astype(np.float32)
    noise = random.uniform(0.5, 2.0, (channels, count)).astype(np.float32)
    known = random.random((channels, count)) < 0.9
    brightest = near * np.float32(1.2)
    return edgels_of(near, 1.0)._replace(brightest=brightest, noise=noise, known=known)


def log_normal(x: Floats, variance: Floats | float) -> Floats:
    return np.asarray(-0.5 * (x**2 / variance + np.log(2.0 * np.pi * variance)))


def about_a_mean(x: Floats, variance: Floats, sd: float) -> Floats:
    """Density of a Gaussian of covariance diag(variance) + sd^2 of all pairs."""
    found = []
    for values, variances in zip(x.T, variance.T, strict=True):
        covariance = np.diag(variances) + sd**2
        _, log_det = np.linalg.slogdet(2.0 * np.pi * covariance)
        found.append(-0.5 * (values @ np.linalg.solve(covariance, values) + log_det))
    return np.array(found)


def less_crease(parts: Sides, at_end: Floats, behind: Floats) -> list[Floats]:
    """As the head of `each_light` says it, kind after kind."""
    e, count = each_light, len(parts.noise)
    logs, noise = (value.astype(np.float64) for value in logarithms(parts))
    ratio, near = logs[:, 0] - logs[:, 1], parts.near.astype(np.float64)
    darker = near.min(axis=1)
    dim = parts.noise.astype(np.float64) ** 2 + (e.DARK_SHARE * near.max(axis=(0, 1))) ** 2
    nothing = log_normal(darker, dim) + np.log(0.5 * (darker + parts.dark))
    turned = log_normal(ratio, noise + e.TURNED_SD**2)
    crease = np.logaddexp(turned + math.log(1.0 - e.FACES_AWAY), nothing + math.log(e.FACES_AWAY))
    alike = log_normal(ratio, noise + e.FLAT_SD**2)
    sure_alike, sure_nothing, sure_turned = (
        np.clip(value - crease, -e.SUREST, e.SUREST).astype(np.float64) for value in (alike, nothing, turned)
    )
    base, gone, turns = (
        sure_alike.sum(axis=0), np.exp(sure_nothing - sure_alike), np.exp(sure_turned - sure_alike)
    )  # fmt: skip
    end = (1.0 - float(e.IN_PART)) * at_end * gone + float(e.IN_PART) * turns
    two = sum(end[i] * end[k] for i in range(count) for k in range(i)) / max(count * (count - 1) / 2, 1.0)
    one = (at_end * gone).sum(axis=0) / count
    printed, glare = [], []
    for light in range(count):
        others = np.delete(np.arange(count), light)
        of_others = [
            about_a_mean(ratio[others], noise[others] + e.FLAT_SD**2, sd) - crease[others].sum(axis=0)
            for sd in (e.SHADED_PRINT_SD, e.GLARING_PRINT_SD)
        ]
        printed.append((nothing - crease)[light] + np.log(at_end[light]) + of_others[0])
        glare.append(sure_turned[light] + of_others[1])
    clear = base + np.log((1.0 - float(e.ON_PRINT)) * ((1.0 - e.TWO_ENDS) * one + e.TWO_ENDS * two))
    on_print = np.logaddexp.reduce(printed) - math.log(count) + math.log(e.ON_PRINT)
    share, share_any = float(e.BEHIND), float(e.BEHIND_ANY)
    before_alike = np.prod(1.0 - share + share * behind * gone, axis=0) - (1.0 - share) ** count
    darker_back = near[:, 0] < near[:, 1]
    of_side = [
        np.prod((1.0 - share_any) * turns + 2.0 * share_any * behind * gone * side, axis=0)
        for side in (darker_back, ~darker_back)
    ]
    before_any = 0.5 * math.exp(-e.RARER_ANY) * (of_side[0] + of_side[1])
    return [
        np.logaddexp(clear, on_print),
        base + np.log(before_alike + before_any),
        base + np.log(turns.sum(axis=0) / count),
        np.logaddexp.reduce(glare) - math.log(count),
        crease.sum(axis=0),
    ]


@pytest.mark.parametrize("lights", [2, 4, 9])
def test_what_else_than_a_crease_is_as_stated(lights: int) -> None:
    parts = some_sides(lights)._replace(known=np.ones((lights, 400), bool))
    random = np.random.default_rng(1)
    dark_side = tuple(random.uniform(0.1, 2.0, (lights, 400)).astype(np.float32) for _ in range(2))
    found = each_light.less_crease(parts, dark_side)
    expected = less_crease(parts, *(side.astype(np.float64) for side in dark_side))
    for value, right in zip(found, expected, strict=True):
        likely = right > -20.0  # beside a crease: less is lost among the kinds
        assert likely.sum() > 20
        # float32 loses some where the one that is not alike is much less likely than all others are
        np.testing.assert_allclose(value[likely], right[likely], atol=0.05, rtol=1e-3)


@pytest.mark.parametrize("channels", [2, 4, 12])
def test_scatters_are_gaussians_about_means_of_their_own(channels: int) -> None:
    sides, dark = some_sides(channels), 2.0
    logs, noise = (value.astype(np.float64) for value in logarithms(sides))
    ratio, surface = logs[:, 0] - logs[:, 1], noise + scatter.SURFACE_SD**2
    lit = sides.brightest.max(axis=0)
    darker = np.where(lit[0] < lit[1], sides.brightest[:, 0], sides.brightest[:, 1])
    darkness = np.log((darker + sides.dark) / (dark + sides.dark)).astype(np.float64)
    brighter = sides.near.max(axis=1).astype(np.float64)
    dim = np.maximum(sides.near.min(axis=1), math.exp(-scatter.DEEPEST_PRINT) * brighter)
    shorter = sides.dark / (dim + sides.dark) - sides.dark / (brighter + sides.dark)
    flat = noise + FLAT_SD**2 + np.square(scatter.SHORTER * shorter)
    uneven = noise + scatter.UNEVEN_SD**2
    behind = [
        about_a_mean(darkness, noise + sd**2, scatter.BACKGROUND_SD)
        for sd in (scatter.SURFACE_SD, scatter.EVEN_SD)
    ]
    none = [about_a_mean(ratio, flat, scatter.FAINT_SD), about_a_mean(ratio, uneven, scatter.UNEVEN_SD)]
    expected = [
        np.logaddexp(*behind) - math.log(2.0),
        about_a_mean(ratio, surface + scatter.CREASE_SD**2, scatter.PRINT_SD),
        about_a_mean(ratio, flat, scatter.PRINT_SD),
        np.logaddexp(*none) - math.log(2.0),
    ]
    np.testing.assert_allclose(scatter.scatter(sides, dark), expected, atol=5e-3, rtol=1e-3)
