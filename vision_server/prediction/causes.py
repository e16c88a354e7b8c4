"""What has happened before an image that is not as foreseen: a light dead, two swapped, another sun, an arm.

Light adds up, wherever one looks: a place of the target has the linear brightness e (a_0 + sum_l a_l x_l) in
an image of relative exposure e and light outputs x_l, to a hundredth. Each cause says how inputs and outputs
went together since an image: x_l is 0, x_l and x_m are exchanged, a_0 is another or so many times itself,
some places show something else (`hidden`). The coefficients are integrated out under a Gaussian prior that
all places share (`Prior`), so that few images say as much as they can and no more; the evidence of a cause is
held against that of nothing having happened (Bayesian model selection: MacKay, Information Theory, Inference,
and Learning Algorithms, chapter 28).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from numerics.arrays import Floats
from vision_server.prediction.hidden import brighter_by, foreseen, hidden_places, log_of_hidden, shown_again
from vision_server.prediction.places import Places, Readings
from vision_server.prediction.prior import Prior

SUNS = (0.03, 1.0, 6.0, 36.0)  # the sun beside a light: next to nothing, or about so many times it
STRENGTHS = (0.0, 0.1, 0.22, 0.47, 2.1, 4.6, 10.0)  # of the same sun, times what it was
SCALES = np.exp(np.linspace(-1.6, 1.6, 9))  # of all brightness, about what the readings say
NOISES = np.array([1.0, 1.5, 2.2, 3.3, 5.0, 7.5])  # by so much readings may scatter more: wrong tone curves
CLIPPED_SHARE = 0.05  # standard deviation of what is clipped, of what it is at least
LEAST_CHANCE = 1e-15  # that it is so bright, where it is foreseen darker
# How they were chosen: benchmarks/surprises.py counts what is named, and false alarms.
DOUBT_NATS = 4.5  # log odds against nothing from which on a cause is doubted; is sure, and against others,
SURE_NATS, CLEAR_NATS = 16.0, 12.0  # where an image was taken that tests it,
SURE_AT_ONCE_NATS, CLEAR_AT_ONCE_NATS = 40.0, 20.0  # and where none was: the prior weighs more then
NEVER_UNTESTED = "sun_changed", "in_the_way"  # a dead light, or one image's new shadows, look so, too
LEAST_READINGS = 8  # from fewer nothing is said, but that an image is clipped which was not to be:
CLEARLY_DARK = 3.0  # standard deviations below that
MOST_IMAGES = 6  # that are looked back on
MOST_SINCE = 2  # something may have happened before so many of the last, or of those before what is doubted
MOST_PAIRS = 28  # of lights that may have been swapped: all of eight; of more only neighbours are asked for


class Cause(NamedTuple):
    """What may have happened, to which lights, before which image; its log odds against nothing.

    It is ``tested`` where images since then would look otherwise if it were not so, whatever light gives: two
    that differ in the dead light alone, one of two swapped lights without the other, settings of one before.
    """

    name: str
    lights: tuple[int, ...]
    since: int
    nats: float
    tested: bool = False


def verdict(causes: Sequence[Cause]) -> tuple[Cause | None, Cause | None]:
    """What has surely happened, and what is doubted where nothing is sure, of causes, likeliest first.

    Doubted is the likeliest of those that no image has tested and that are not far behind.
    """
    if not causes or causes[0].nats < DOUBT_NATS:
        return None, None
    best = causes[0]
    others = (cause for cause in causes if (cause.name, cause.lights) != (best.name, best.lights))
    rival = next(others, Cause("nothing", (), best.since, 0.0, True))
    most = SURE_NATS if best.tested else SURE_AT_ONCE_NATS
    apart = CLEAR_NATS if best.tested and rival.tested else CLEAR_AT_ONCE_NATS
    sure = best.nats >= most and best.nats - rival.nats >= apart
    sure &= best.tested or best.name not in NEVER_UNTESTED
    near = (one for one in causes if one.nats > best.nats - CLEAR_AT_ONCE_NATS and not one.tested)
    return (best, None) if sure else (None, next(near, best))


def likely_causes(
    places: Places, readings: Readings, lights: Floats, doubted: int | None = None
) -> list[Cause]:
    """All that may have happened before the last image, or one not long before it, likeliest first.

    Parameters
    ----------
    lights
        (K, L), outputs of the lights as they were asked for, in order of time.
    doubted
        Before which image something may have happened, where that was doubted before.
    """
    last = slice(max(0, len(lights) - MOST_IMAGES), None)
    earlier, lights = last.start, lights[last]
    readings = readings.last(len(lights))
    if len(lights) < 2:
        return []
    priors = [Prior(places, sun) for sun in SUNS]
    sun = np.ones((len(lights), 1))
    usual = range(1 + lights.shape[1])

    all_seen = Seen(readings)

    def evidence(inputs: Floats, source: Sequence[int] = usual, seen: Seen = all_seen) -> float:
        return _log_mean(np.concatenate([_logs(prior, seen, inputs, source) for prior in priors]))

    as_asked = np.hstack([sun, lights])
    if readings.known[-1].sum() < LEAST_READINGS:
        glare = all(_foreseen_dark(prior, readings, as_asked) for prior in priors)
        return [Cause("sun_changed", (), earlier + len(lights) - 1, DOUBT_NATS)] if glare else []
    nothing = evidence(as_asked)
    found = []
    oldest = max(1, (len(lights) if doubted is None else doubted - earlier) - MOST_SINCE)
    for since in range(oldest, len(lights)):
        for name, which, changed, tested in _happened(lights, since):
            nats = evidence(np.hstack([sun, changed])) - nothing
            found.append(Cause(name, which, earlier + since, nats, tested))
        before = _before(len(lights), since)
        nats = evidence(np.hstack([before, lights, 1.0 - before]), [*usual, 0]) - nothing
        found.append(Cause("sun_changed", (), earlier + since, nats, _again(lights, since)))
        hidden = hidden_places(priors, readings, as_asked, since)
        if hidden.any() and shown_again(readings, hidden, since):
            rest = readings._replace(known=readings.known & ~hidden)
            nats = evidence(as_asked, seen=Seen(rest)) + log_of_hidden(readings, hidden) - nothing
            exposed = np.column_stack([lights, readings.most])
            found.append(Cause("in_the_way", (), earlier + since, nats, _again(exposed, since)))
    if max(cause.nats for cause in found) >= DOUBT_NATS or (readings.least > 0.0).any():
        for k, cause in enumerate(found):
            if cause.name == "sun_changed":
                before = _before(len(lights), cause.since - earlier)
                same = [evidence(np.hstack([before + x * (1.0 - before), lights])) for x in STRENGTHS]
                nats = _log_mean(np.array([cause.nats + nothing, _log_mean(np.array(same))])) - nothing
                found[k] = cause._replace(nats=nats)
    return sorted(found, key=lambda cause: -cause.nats)


def _before(images: int, since: int) -> Floats:
    """1 for images before this one, 0 for others, (K, 1)."""
    return (np.arange(images) < since)[:, None].astype(np.float64)


def _again(asked: Floats, since: int) -> bool:
    """Whether lights, or lights and exposures, (K, J) were asked for since then as before."""
    return bool((asked[since:, None] == asked[None, :since]).all(axis=2).any())


def _happened(lights: Floats, since: int) -> Iterator[tuple[str, tuple[int, ...], Floats, bool]]:
    """What can have become of the lights since an image, where that makes a difference.

    The cause, which lights, what was their output then, and whether that was tested.
    """
    after = lights[since:]
    lit = after > 0.0
    for light in np.flatnonzero(lit.any(axis=0)).tolist():
        changed = lights.copy()
        changed[since:, light] = 0.0
        others = np.delete(after, light, axis=1)
        alike = (others[lit[:, light], None] == others[None, ~lit[:, light]]).all(axis=2)
        yield "light_dead", (light,), changed, bool(alike.any())
    pairs = list(combinations(range(lights.shape[1]), 2))
    if len(pairs) > MOST_PAIRS:
        pairs = [(one, other) for one, other in pairs if other == one + 1]
    for one, other in pairs:
        if (after[:, one] != after[:, other]).any():
            changed = lights.copy()
            changed[since:, [one, other]] = after[:, [other, one]]
            apart = bool((lit[:, one] != lit[:, other]).any() and len(after) > 1)
            as_before = (changed[since:, None] == lights[None, :since]).all(axis=2) & (changed != lights)[
                since:
            ].any(axis=1)[:, None]
            yield "lights_swapped", (one, other), changed, apart or bool(as_before.any())


def _foreseen_dark(prior: Prior, readings: Readings, inputs: Floats) -> bool:
    """Whether the last image was to show most places that others do, none of them clipped."""
    before = readings._replace(known=np.vstack([readings.known[:-1], np.zeros_like(readings.known[-1:])]))
    if before.known.any(axis=0).sum() < LEAST_READINGS:
        return False
    mean, variance = foreseen(prior, before, inputs, len(inputs) - 1)
    clear = mean + CLEARLY_DARK * np.sqrt(variance) < readings.most[-1]
    return bool(clear[before.known.any(axis=0)].mean() > 0.5)


def _log_mean(logs: Floats) -> float:
    """Of what these are the logarithms of."""
    return float(logs.max() + np.log(np.exp(logs - logs.max()).mean()))


class Seen:
    """The readings that are known, in units of their noise: ``white`` (n, n) makes that of all n alike.

    ``clipped`` are those that others tell of, ``least`` (K, P) what they are at least.
    """

    def __init__(self, readings: Readings) -> None:
        self.use = np.flatnonzero(readings.known)
        self.clipped = np.flatnonzero((readings.least > 0.0) & readings.known.any(axis=0))
        self.least = readings.least
        self.value = readings.value.ravel()[self.use]
        lower = np.linalg.cholesky(readings.correlation(self.use))
        self.white = np.linalg.inv(lower) / readings.sd.ravel()[self.use]
        self.log_scale = float(np.log(np.diag(lower)).sum())

    def log_of_clipped(self, mean: Floats, variance: Floats) -> float:
        """Of the clipped readings (c,) being what they are at least, as the others foresee them.

        Those of an image go together: its median speaks, and the image that is least as foreseen.
        """
        image, place = np.unravel_index(self.clipped, self.least.shape)
        least = self.least[image, place]
        over = (mean - least) / np.sqrt(np.maximum(variance, 0.0) + (CLIPPED_SHARE * least) ** 2)
        worst = min(float(np.median(over[image == one])) for one in np.unique(image))
        return math.log(max(math.erfc(-worst / math.sqrt(2.0)) / 2.0, LEAST_CHANCE))


def _logs(prior: Prior, seen: Seen, inputs: Floats, source: Sequence[int]) -> Floats:
    expected, covariance = prior.of_readings(inputs, source)
    use, white, value, mean = seen.use, seen.white, seen.value, expected.ravel()[seen.use]
    scale = brighter_by(value, mean)
    variance, axes = np.linalg.eigh(white @ covariance[np.ix_(use, use)] @ white.T)
    squares = ((scale * SCALES) ** 2)[:, None, None]
    spread = NOISES[:, None] ** 2 + squares * np.maximum(variance, 0.0)
    misfit = (white @ value) @ axes - np.sqrt(squares) * ((white @ mean) @ axes)
    logs = -0.5 * (misfit**2 / spread + np.log(spread)).sum(axis=2)
    if len(seen.clipped):
        one, other = np.unravel_index(logs.argmax(), logs.shape)
        square = float(squares[one, 0, 0])
        together = square * covariance[np.ix_(seen.clipped, use)] @ white.T @ axes
        mean = np.sqrt(square) * expected.ravel()[seen.clipped] + together @ (misfit / spread)[one, other]
        own = square * covariance[seen.clipped, seen.clipped] - (together**2 / spread[one, other]).sum(axis=1)
        logs += seen.log_of_clipped(mean, own)
    return np.asarray(logs.ravel() - seen.log_scale)
