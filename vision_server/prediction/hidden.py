"""Places of a target that show something else since an image: something is in the way there.

What images show at a place is foreseen from all that they show elsewhere. Places at which that is off by far
are taken out one after another, until the rest go together; of what is seen at these nothing is known but
that it is no brighter than the brightest.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from vision_server.prediction.places import Readings
from vision_server.prediction.prior import Prior

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

# Chosen by hand; benchmarks/surprises.py counts what is named.
OFF = 3.0  # standard deviations, from which on a place may be hidden
MOST_HIDDEN = 0.4  # of all places
HIDDEN = 0.15  # chance of a place to be hidden


def hidden_places(priors: Sequence[Prior], readings: Readings, inputs: Floats, since: int) -> Flags:
    """Which readings (K, P) under inputs (K, J) are of something in the way since an image; perhaps none."""
    known = readings.known.copy()
    hidden = np.zeros(known.shape[1], dtype=np.bool_)
    while hidden.sum() < MOST_HIDDEN * len(hidden):
        off = min((_off(prior, readings, known, inputs, since) for prior in priors), key=np.sum)
        if off.max() < OFF**2:
            break
        hidden[off.argmax()] = True
        known[since:, off.argmax()] = False
    return readings.known & ~known


def log_of_hidden(readings: Readings, hidden: Flags) -> float:
    """Log probability of hidden readings (K, P), and of just these places being hidden."""
    seen = np.where(readings.known, readings.value, 0.0).max(axis=1)[:, None]
    brightest = np.maximum(seen / readings.sd, 1.0)  # of an image without any light, as bright as its noise
    share = hidden.any(axis=0).mean()
    which = hidden.shape[1] * (share * np.log(HIDDEN) + (1.0 - share) * np.log(1.0 - HIDDEN))
    return float(which + (0.5 * np.log(2.0 * np.pi) - np.log(brightest[hidden])).sum())


def _off(prior: Prior, readings: Readings, known: Flags, inputs: Floats, since: int) -> Floats:
    """How far each place (P,) is off since then from what all else foresees, squared, in variances."""
    mean, covariance = prior.of_readings(inputs, range(inputs.shape[1]))
    use = np.flatnonzero(known)
    mean, value, sd = mean.ravel()[use], readings.value.ravel()[use], readings.sd.ravel()[use]
    scale = np.exp(np.median(np.log(np.maximum(value, 1e-4)) - np.log(np.maximum(mean, 1e-4))))
    precision = np.linalg.inv(scale**2 * covariance[np.ix_(use, use)] + np.diag(sd**2))
    pull = precision @ (value - scale * mean)
    image, place = np.unravel_index(use, known.shape)
    out = np.zeros(known.shape[1])
    for one in np.unique(place[image >= since]):
        of = np.flatnonzero((place == one) & (image >= since))
        out[one] = pull[of] @ np.linalg.solve(precision[np.ix_(of, of)], pull[of]) / len(of)
    return out
