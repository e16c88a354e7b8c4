"""Places of a target that show something else since an image: something is in the way there.

What images show at a place is foreseen from all that they show elsewhere. Places at which that is off by far
are taken out one after another, until the rest go together; of what is seen at these nothing is known but
that it is no brighter than the brightest.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from numerics.arrays import Flags, Floats
from vision_server.prediction.places import Readings
from vision_server.prediction.prior import Prior

# Chosen by hand; benchmarks/surprises.py counts what is named.
OFF = 3.0  # standard deviations, from which on a place may be hidden
MOST_HIDDEN = 0.4  # of all places that are read since
LEAST_OWN = 0.02  # share of a reading's variance that is not of its exposure
HIDDEN = 0.15  # chance of a place to be hidden
LEAST_SUM = 1e-4  # of readings, where nothing shows anything


def hidden_places(priors: Sequence[Prior], readings: Readings, inputs: Floats, since: int) -> Flags:
    """Which readings (K, P) under inputs (K, J) are of something in the way since an image; perhaps none."""
    known = readings.known.copy()
    hidden = np.zeros(known.shape[1], dtype=np.bool_)
    seen = known[since:].any(axis=0).sum()
    while hidden.sum() < MOST_HIDDEN * seen:
        off = min((_off(prior, readings, known, inputs, since) for prior in priors), key=np.sum)
        if off.max() < OFF**2:
            break
        hidden[off.argmax()] = True
        known[since:, off.argmax()] = False
    return readings.known & ~known


def log_of_hidden(readings: Readings, hidden: Flags) -> float:
    """Log probability of hidden readings (K, P), and of just these places being hidden.

    One image of what is in the way tells what another under the same settings shows.
    """
    seen = np.where(readings.known, readings.value, 0.0).max(axis=1)[:, None]
    brightest = np.maximum(seen / readings.sd, 1.0)  # of an image without any light, as bright as its noise
    share = hidden.any(axis=0).mean()
    which = hidden.shape[1] * (share * np.log(HIDDEN) + (1.0 - share) * np.log(1.0 - HIDDEN))
    logs = 0.5 * np.log(2.0 * np.pi) - np.log(brightest)
    for image in range(1, len(hidden)):
        for same in np.flatnonzero(readings.alike[image, :image] == 1.0):
            off = (readings.value[image] - readings.value[same]) / readings.sd[image]
            own = _own_of_two(readings, image)
            again = -0.5 * off**2 / own - 0.5 * np.log(own)
            logs[image] = np.where(hidden[same], np.maximum(logs[image], again), logs[image])
    return float(which + logs[hidden].sum())


def shown_again(readings: Readings, hidden: Flags, since: int) -> bool:
    """Whether most of what images show at hidden places (K, P) differs from what it repeats, where any does.

    What is clipped both times does not.
    """
    places, differ = hidden.any(axis=0), []
    for image in range(since, len(hidden)):
        for before in np.flatnonzero(readings.alike[image, :since] == 1.0):
            own = _own_of_two(readings, image) * readings.sd[image] ** 2
            off = np.abs(readings.value[image] - readings.value[before]) > OFF * np.sqrt(own)
            differ += off[places].tolist()
    return not differ or float(np.mean(differ)) > 0.5


def _own_of_two(readings: Readings, image: int) -> Floats:
    """Variance (P,), in that of one reading, between two of one exposure: what they do not share."""
    return np.asarray(2.0 * np.maximum(1.0 - readings.shared[image], LEAST_OWN))


def foreseen(prior: Prior, readings: Readings, inputs: Floats, image: int) -> tuple[Floats, Floats]:
    """Mean and variance (P,) of the brightness of one image, as the readings that are known foresee it."""
    mean, covariance = prior.of_readings(inputs, range(inputs.shape[1]))
    use = np.flatnonzero(readings.known)
    value, sd = readings.value.ravel()[use], readings.sd.ravel()[use]
    scale = brighter_by(value, mean.ravel()[use])
    noise = readings.correlation(use) * np.outer(sd, sd)
    places = mean.shape[1]
    of_image = slice(image * places, (image + 1) * places)
    gain = np.linalg.solve(
        scale**2 * covariance[np.ix_(use, use)] + noise, scale**2 * covariance[use, of_image]
    )
    variance = scale**2 * np.diag(covariance[of_image, of_image]) - (
        gain * scale**2 * covariance[use, of_image]
    ).sum(0)
    return scale * mean[image] + (value - scale * mean.ravel()[use]) @ gain, np.maximum(variance, 0.0)


def brighter_by(value: Floats, mean: Floats) -> float:
    """How many times their mean the readings are, all together.

    Not one by one: in the shadow of a sun most show a thousandth of what the sun gives elsewhere.
    """
    return float(max(value.sum(), LEAST_SUM) / max(mean.sum(), LEAST_SUM))


def _off(prior: Prior, readings: Readings, known: Flags, inputs: Floats, since: int) -> Floats:
    """How far each place (P,) is off since then from what all else foresees, squared, in variances."""
    mean, covariance = prior.of_readings(inputs, range(inputs.shape[1]))
    use = np.flatnonzero(known)
    mean, value, sd = mean.ravel()[use], readings.value.ravel()[use], readings.sd.ravel()[use]
    scale = brighter_by(value, mean)
    noise = readings.correlation(use) * np.outer(sd, sd)
    precision = np.linalg.inv(scale**2 * covariance[np.ix_(use, use)] + noise)
    pull = precision @ (value - scale * mean)
    image, place = np.unravel_index(use, known.shape)
    out = np.zeros(known.shape[1])
    for one in np.unique(place[image >= since]):
        of = np.flatnonzero((place == one) & (image >= since))
        out[one] = pull[of] @ np.linalg.solve(precision[np.ix_(of, of)], pull[of]) / len(of)
    return out
