"""What is known before any image of how lights and sun show a target's places: a Gaussian prior."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from numerics.arrays import Floats
from vision_server.prediction.places import Places

# All as shares of what Lambert's law says of a light; chosen by hand.
ALBEDO = 0.5  # of a place, under all lights alike
LIGHT_GAIN, UNKNOWN_GAIN, SUN_GAIN = 0.3, 1.0, 2.0  # of a light whose place is known, or is not; of the sun
SIDE, SUN_SIDE, PLACE = 0.5, 1.5, 0.2  # shadows and what is reflected: of a side of the target, of a place
FLOOR = 0.2  # of a light's mean: no side gets nothing
ONE_SIDE = 0.1  # of 1 - the cosine between the normals of places that are of about one side


class Prior:
    """Coefficients of all places under one scale: means, and covariances between places, of each coefficient.

    A place's albedo is common to all its coefficients, a light's gain to all places, shadows to a side. The
    sun is so many times a light.
    """

    def __init__(self, places: Places, sun: float) -> None:
        same = np.exp((places.normal @ places.normal.T - 1.0) / ONE_SIDE)
        gain = [SUN_GAIN, *np.where(places.located, LIGHT_GAIN, UNKNOWN_GAIN).tolist()]
        self.mean = places.shape.T * np.array([[sun], *[[1.0]] * len(places.located)])
        self.between = np.empty((len(self.mean), len(same), len(same)))
        for row, mean in enumerate(self.mean):
            side = SUN_SIDE if row == 0 else SIDE
            floor = (FLOOR * float(mean.mean())) ** 2
            self.between[row] = np.outer(mean, mean) * (gain[row] ** 2 + side**2 * same) + floor * same
            self.between[row] += np.diag(PLACE**2 * mean**2 + floor)

    def of_readings(self, inputs: Floats, source: Sequence[int]) -> tuple[Floats, Floats]:
        """Mean (K, P), covariance (K P, K P) under inputs (K, J), columns being of these coefficients."""
        mean = inputs @ self.mean[list(source)]
        pairs = inputs[:, None, :] * inputs[None, :, :]
        covariance = np.tensordot(pairs, self.between[list(source)], axes=(2, 0)).transpose(0, 2, 1, 3)
        places = np.arange(mean.shape[1])
        covariance = np.ascontiguousarray(covariance)
        covariance[:, places, :, places] += ALBEDO**2 * np.einsum("kp,lp->pkl", mean, mean)
        return mean, covariance.reshape(mean.size, mean.size)
