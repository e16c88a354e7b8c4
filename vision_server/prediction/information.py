"""What an image under other settings would add to a pose: the expected gain of its information, in bits.

Each sample of a visible line gets, in each image, the variance with which its edge would be placed there
(the Cramer-Rao bound of a blurred step in the sensor's noise, and what is not noise); the set's images and
the new one together fix the pose with the precision L = sum_i J_i J_i' / variance_i. The gain is log2 det L
of both over that of the set, and what the lines that would be shown for the first time speak for the pose
(`belief`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from geometry.visibility import Samples, visible_samples
from numerics.arrays import Floats, Ints
from vision_server.channels.depth import ROUNDING_SD
from vision_server.pose.sampling import thinned
from vision_server.pose.steps import step_jacobian, turning_point
from vision_server.prediction.belief import Belief
from vision_server.prediction.response import LitImage, Response, learn_response
from vision_server.prediction.straying import expected_straying, straying_share

MOST_SAMPLES, LEAST_OF_LINE = 200, 2  # of all visible lines together: more change no choice; chosen by hand
# As in the controller's prediction of whole images (domain/reasoning/prediction.pl), which explains them.
EDGE_CONTRAST = 0.4
SAFE_HIGHLIGHT, OVERSHOOT_POWER = 0.9, 4
BLUR_PRIOR_PX2, BLUR_TRUST = np.array([1.0, 3.0, 3.0]), np.array([2.0, 0.002, 0.002])
LEAST_BLUR_PX2 = 0.25
UNPLACED_PX = 4.0  # a line that would be placed no better is not found: as far as its support is looked for
DETECTED_SNR = 3.0  # a step under so many standard deviations of the noise is mostly not found; by hand
SEARCH_SD = 0.17, 0.1  # of a pose before any image: rad, share of the range; about the search's own range


class Sensor(NamedTuple):
    """Noise of a camera: electrons at full scale, of read noise; gamma of its grey values."""

    full_scale_e: float
    read_noise_e: float
    gamma: float

    def variance(self, level: Floats) -> Floats:
        """Of linear brightness 0..1: shot noise, read noise, rounding to whole greys."""
        seen = np.clip(level, 1e-4, 1.0)
        rounding = ROUNDING_SD / 255.0 * self.gamma * seen ** (1.0 - 1.0 / self.gamma)
        read = self.read_noise_e / self.full_scale_e
        return np.asarray(seen / self.full_scale_e + read**2 + rounding**2)


class Candidates(NamedTuple):
    """M settings: relative exposure (M,), light outputs (M, L), what blurs (M, 3), see `blur_inputs`."""

    exposure: Floats
    lights: Floats
    blur: Floats


def blur_inputs(shutter: Floats, aperture: Floats, widest: float, reference_s: float) -> Floats:
    """Terms of the squared blur, (M, 3): the lens, defocus with the aperture, motion with the shutter."""
    return np.stack([np.ones_like(shutter), (widest / aperture) ** 2, (shutter / reference_s) ** 2], axis=1)


class View(NamedTuple):
    """A target before a camera, and what a set of K images shows there of its L model lines.

    Attributes
    ----------
    support
        (L,), share of each line that has an edge close to it.
    scatter
        (K, L), px^2, how far the edges stray, see `line_scatter`.
    """

    model: Model
    camera: Camera
    pose: Pose
    support: Floats
    scatter: Floats


class Known:
    """What K images say of N samples together.

    Noise averages out between images; what is not noise does not. So a sample counts as it does in the best
    image, its noise averaged with that of those which are as sharp: an image more takes nothing away.
    """

    def __init__(self, precision: Floats, shared: Floats) -> None:
        """Precision (K, N), 1/px^2, that noise leaves samples; other variance (K,), px^2, of each image."""
        self._precision, self._shared = precision, shared
        self._as_sharp = (shared[:, None] >= shared) @ precision
        self.weight = _counted(self._as_sharp, shared[:, None]).max(axis=0)

    def with_one_more(self, precision: Floats, shared: Floats) -> Floats:
        """The weight of the samples, (M, N), with each of M other images; arguments as above."""
        own = precision + (shared[:, None] >= self._shared) @ self._precision
        best = _counted(own, shared[:, None])
        for before, other in zip(self._as_sharp, self._shared.tolist(), strict=True):
            together = before + np.where((shared <= other)[:, None], precision, 0.0)
            best = np.maximum(best, _counted(together, other))
        return np.asarray(best)


class Forecast:
    """What the lines of a target would show under settings to come, learnt from a set of images.

    Parameters
    ----------
    images, taken
        The set, not empty, and the settings it was taken under.
    positions
        (3,) m of each light, camera frame, or None where it is not known.
    old
        So many of the images, the first ones, were taken under another sun.

    Attributes
    ----------
    samples
        Of the visible lines, perhaps none.
    response
        Brightness beside them.
    """

    def __init__(
        self,
        view: View,
        images: Sequence[LitImage],
        taken: Candidates,
        positions: Sequence[Floats | None],
        sensor: Sensor,
        old: int = 0,
    ) -> None:
        model, camera, pose, support, scatter = view
        self.view, self.taken, self.sensor = view, taken, sensor
        self.samples = spread_samples(model, camera, pose)
        if len(self.samples.line) == 0:
            return
        self.response = learn_response(self.samples, model, pose, images[old:], positions)
        self._blur = _blur_coefficients(taken.blur, np.array([image.blur_px for image in images]))
        self._on_line = self.samples.line[:, None] == np.arange(len(support))  # (N, L)
        self._seen = support[self.samples.line]
        precision, expected, self._shown = self._placing(taken)
        noise = 1.0 / np.maximum(self._by_line(precision), 1e-12)
        self._strays = straying_share(scatter, noise, expected)
        shared = self._strays * expected
        self._belief = Belief(self.samples, self._seen)
        self._known = Known(precision * self._seen, shared)
        self._weight = self.samples.px * self._known.weight
        centre = turning_point(model, pose)
        jacobian = step_jacobian(camera, pose.apply(self.samples.points), self.samples.normal, centre)
        self._outer = (jacobian[:, :, None] * jacobian[:, None, :]).reshape(len(jacobian), 36)
        range_m = float(np.linalg.norm(pose.translation))
        self._prior = np.diag(np.repeat([1.0 / SEARCH_SD[0] ** 2, 1.0 / (SEARCH_SD[1] * range_m) ** 2], 3))
        self._before = self._log_det(self._weight)

    def gains(self, candidates: Candidates) -> tuple[Floats, Ints]:
        """Bits that each candidate adds, (M,), and the model line that gains most by it, (M,), or -1."""
        if len(self.samples.line) == 0:
            return np.zeros(len(candidates.exposure)), np.full(len(candidates.exposure), -1)
        precision, expected, shown = self._placing(candidates)
        # under light not seen yet the exposure is a guess, and light like the set's shows nothing new
        guess = 1.0 / (1.0 + self.response.uncertainty(candidates.lights))[:, None] ** 2
        likely = guess * (1.0 - self._absent(candidates) * (1.0 - self._seen))
        weights = self.samples.px * self._known.with_one_more(precision * likely, self._strays * expected)
        by_line = (weights - self._weight) @ self._on_line
        bits = (self._log_det(weights) - self._before) / math.log(2.0) + self._belief.gains(shown * likely)
        return np.asarray(bits), np.argmax(by_line, axis=1)

    def line_sd(self, candidates: Candidates) -> Floats:
        """Standard deviation, px, with which each line's edge would be placed anywhere along it, (M, L).

        Infinite where a line is not visible, or would not be found.
        """
        precision, expected, _ = self._placing(candidates)
        mean = self._by_line(1.0 / np.maximum(precision, 1e-12) + self._strays * expected[:, None])
        return np.where((mean > 0.0) & (mean < UNPLACED_PX**2), np.sqrt(mean), np.inf)

    def _absent(self, candidates: Candidates) -> Floats:
        """How sure a line that the set has not shown will not be shown by these either, 0..1, (M, N).

        As sure as an image of the set had light like theirs and should have shown it.
        """
        alike = _likeness(self.response, self.taken, candidates)
        return np.asarray(np.max(alike[:, :, None] * self._shown[None], axis=1))

    def _placing(self, settings: Candidates) -> tuple[Floats, Floats, Floats]:
        """Of images and samples: the precision that noise leaves, 1/px^2, (M, N), the variance that is
        expected of what is not noise, px^2, (M,), and the probability that they are shown, (M, N).
        """
        blur = np.sqrt(np.maximum(settings.blur @ self._blur, LEAST_BLUR_PX2))
        mean, variance = self.response.brightness(settings.exposure, settings.lights)
        precision, shown = _placing(mean, variance, blur, self.sensor)
        return precision, expected_straying(blur), shown

    def _by_line(self, amount: Floats) -> Floats:
        """Mean of an amount (M, N) over the samples of each line, (M, L); 0 where the line is not visible."""
        length = self._on_line * self.samples.px[:, None]
        return np.asarray((amount @ length) / np.maximum(length.sum(axis=0), 1e-12))

    def _log_det(self, weights: Floats) -> Floats:
        precision = (weights @ self._outer).reshape(*weights.shape[:-1], 6, 6) + self._prior
        return np.asarray(np.linalg.slogdet(precision)[1])


def spread_samples(model: Model, camera: Camera, pose: Pose) -> Samples:
    """Samples of all visible lines, evenly along each, about MOST_SAMPLES together."""
    samples = visible_samples(model, camera, pose, 1.0)
    lines = max(1, len(np.unique(samples.line)))
    return thinned(samples, max(LEAST_OF_LINE, MOST_SAMPLES // lines))


def _likeness(response: Response, taken: Candidates, candidates: Candidates) -> Floats:
    """How like the light of each candidate is to that of each image of the set, 0..1, (M, K).

    The squared cosine between the contributions of sun and lights to the mean brightness of the target.
    """
    directions = []
    for lights in (taken.lights, candidates.lights):
        light = np.hstack([np.ones((len(lights), 1)), lights]) * response.pooled
        directions.append(light / np.maximum(np.linalg.norm(light, axis=1, keepdims=True), 1e-12))
    return np.asarray((directions[1] @ directions[0].T) ** 2)


def _counted(precision: Floats, shared: Floats | float) -> Floats:
    """The inverse of all variance, of noise and of what is no noise."""
    return np.asarray(precision / (1.0 + precision * shared))


def _placing(mean: Floats, variance: Floats, blur: Floats, sensor: Sensor) -> tuple[Floats, Floats]:
    """Precision, 1/px^2, that noise leaves each sample's edge, and the probability that it is shown.

    (M, N) each; inputs (M, 2, N).
    """
    seen = np.minimum(mean, 1.0)
    # two sides of which nothing is known, each uncertain by its brightness, differ by EDGE_CONTRAST of it
    unknown2 = 0.5 * EDGE_CONTRAST**2 * variance.sum(axis=1) * (mean < 1.0).all(axis=1)
    height2 = (seen[:, 0] - seen[:, 1]) ** 2 + unknown2
    noise2 = sensor.variance(seen.mean(axis=1))
    width = blur[:, None]
    place2 = 2.0 * math.sqrt(math.pi) * width * noise2 / np.maximum(height2, 1e-12)
    overshoot = np.maximum(1.0, mean.max(axis=1) / SAFE_HIGHLIGHT) ** OVERSHOOT_POWER
    detected = 1.0 - np.exp(-height2 / (DETECTED_SNR**2 * noise2))
    shown = np.asarray(detected / overshoot)
    return shown / place2, shown


def _blur_coefficients(inputs: Floats, blur_px: Floats) -> Floats:
    """Coefficients (3,) of the squared blur: least squares, relative, towards the prior; none negative."""
    seen = blur_px > 0.0
    rows = inputs[seen] / np.maximum(blur_px[seen, None] ** 2, LEAST_BLUR_PX2)
    trust = BLUR_TRUST / BLUR_PRIOR_PX2**2
    found = np.linalg.solve(rows.T @ rows + np.diag(trust), rows.sum(axis=0) + trust * BLUR_PRIOR_PX2)
    return np.asarray(np.maximum(found, 0.0))
