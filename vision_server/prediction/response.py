"""How bright both sides of each model line are under each light, learnt from the images that were taken.

Light adds up: with relative exposure e and light outputs x_l, a place of the scene has the linear brightness
y = e (a_0 + sum_l a_l x_l), saturation being 1. Its coefficients are found from the images by Bayesian linear
regression, one place at a time; before anything is seen of a light, Lambert's law on the target's faces says
what to expect of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from geometry.model import Model
from geometry.pose import Pose
from geometry.visibility import Samples
from numerics.arrays import Field, Flags, Floats, Ints

# Chosen by hand; tests hold predicted against seen contrasts.
AVERAGED_PX = 1.5  # standard deviation of the patch that is a place's brightness
BESIDE_PX, BESIDE_BLURS, MOST_BESIDE_PX = 2.5, 1.5, 10.0  # a place is so far from its line
PRIOR_SHARE = 1.0  # standard deviation of what Lambert's law says, as a share of it: albedo and shadows
PRIOR_FLOOR = 0.3  # and as a share of the light's mean over the target
BACKGROUND_SHARE = 0.2  # of a light's mean over the target that reaches what is behind it
READING_SHARE = 0.05  # standard deviation of a reading, as a share: the patch is not the edge's own side
READING_FLOOR = 0.01  # and as a share of full scale
CLIPPED, CLIPPED_SHARE = 0.95, 0.5  # readings above this are "at least": so uncertain
LEAST_SHARE = 0.02  # of a light, beside the mean of all, in the mean over the target
POOL_TRUST = 0.02  # weight of "all lights alike" beside an image's 1, in the mean over the target


@dataclass(frozen=True, eq=False)
class LitImage:
    """An image of the set as readings: linear (H, W) 0..1 at its exposure, light outputs (L,), blur px."""

    linear: Field
    exposure: float
    lights: Floats
    blur_px: float

    @cached_property
    def smooth(self) -> Field:
        """Every place's brightness; kept, for an image is read again with each image that joins it."""
        return np.asarray(cv2.GaussianBlur(self.linear, (0, 0), AVERAGED_PX))


@dataclass(frozen=True, eq=False)
class Response:
    """Coefficients (a_0, a_1 .. a_L) of both sides of N samples, and of the mean over all of them.

    Attributes
    ----------
    mean
        (2, N, 1 + L), of each place.
    prior, told
        Their covariance is diag(prior) - told' told, of each place, with prior (2, N, 1 + L) and told
        (2, N, K, 1 + L) from K images: of many lights, few images tell.
    pooled, pooled_covariance
        (1 + L,) and (1 + L, 1 + L), of the mean over all places.
    """

    mean: Floats
    prior: Floats
    told: Floats
    pooled: Floats
    pooled_covariance: Floats

    def uncertainty(self, lights: Floats) -> Floats:
        """Relative variance (M,) of the target's mean brightness under light outputs (M, L)."""
        inputs = np.hstack([np.ones((len(lights), 1)), lights])
        variance = np.einsum("ma,ab,mb->m", inputs, self.pooled_covariance, inputs)
        return np.asarray(variance / (inputs @ self.pooled) ** 2)

    def brightness(self, exposure: Floats, lights: Floats) -> tuple[Floats, Floats]:
        """Mean and variance (M, 2, N) under M settings: exposures (M,), light outputs (M, L)."""
        inputs = np.hstack([np.ones((len(lights), 1)), lights])
        mean = np.tensordot(inputs, self.mean, axes=(1, 2)) * exposure[:, None, None]
        variance = np.tensordot(inputs**2, self.prior, axes=(1, 2))
        for told in np.moveaxis(self.told, 2, 0):
            variance -= np.tensordot(inputs, told, axes=(1, 2)) ** 2
        return mean, np.maximum(variance, 0.0) * (exposure**2)[:, None, None]


def learn_response(
    samples: Samples,
    model: Model,
    pose: Pose,
    images: Sequence[LitImage],
    positions: Sequence[Floats | None],
) -> Response:
    """Coefficients of the places beside the samples, from images (not empty) and the lights' positions.

    ``positions`` are (3,) m in the camera's frame, or None where one is not known.
    """
    readings, sd, clipped = read_beside(samples, images)
    inputs = np.array([[1.0, *image.lights] for image in images])
    pooled, pooled_covariance = _pooled(readings, np.isfinite(sd), clipped, inputs)
    shape = _expected_shape(samples, model, pose, positions)
    mean = shape * pooled
    prior = np.maximum(PRIOR_SHARE * mean, PRIOR_FLOOR * pooled) ** 2
    misfit = readings - np.tensordot(inputs, mean, axes=(1, 2))
    known = np.isfinite(sd) & ~(clipped & (misfit < 0.0))  # a clipped reading says "at least"
    root = np.moveaxis(np.where(known, 1.0 / sd, 0.0), 0, -1)  # (2, N, K)
    gain = root[..., None] * inputs * prior[..., None, :]  # of each image on each coefficient
    spread = (gain @ inputs.T) * root[..., None, :] + np.eye(len(images))
    lower = np.linalg.cholesky(spread)
    told = np.linalg.solve(lower, gain)
    news = np.linalg.solve(lower, (root * np.moveaxis(np.where(known, misfit, 0.0), 0, -1))[..., None])
    step = (np.swapaxes(told, -1, -2) @ news)[..., 0]
    return Response(np.maximum(mean + step, 0.0), prior, told, pooled, pooled_covariance)


def read_beside(samples: Samples, images: Sequence[LitImage]) -> tuple[Floats, Floats, Flags]:
    """Brightness at exposure 1 beside each sample, its standard deviation (inf: unseen), and what is clipped.

    Each (K, 2, N).
    """
    values = np.zeros((len(images), 2, len(samples.line)))
    sd = np.full(values.shape, np.inf)
    clipped = np.zeros(values.shape, dtype=np.bool_)
    for k, image in enumerate(images):
        reach = min(BESIDE_PX + BESIDE_BLURS * image.blur_px, MOST_BESIDE_PX)
        places = samples.image + np.array([[[-reach]], [[reach]]]) * samples.normal
        height, width = image.linear.shape
        inside = ((places >= 0.0) & (places <= [width - 1, height - 1])).all(axis=-1)
        at = np.asarray(places, dtype=np.float32)
        seen = cv2.remap(
            image.smooth, at[..., 0], at[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
        )
        clipped[k] = seen > CLIPPED
        share = np.where(clipped[k], CLIPPED_SHARE, READING_SHARE)
        values[k] = seen / image.exposure
        sd[k] = np.where(inside, np.hypot(share * seen, READING_FLOOR) / image.exposure, np.inf)
    return values, sd, clipped


def _pooled(readings: Floats, seen: Flags, clipped: Flags, inputs: Floats) -> tuple[Floats, Floats]:
    """Coefficients (1 + L,) of the mean over the target and their covariance, towards "all lights alike".

    Images of which half and more is clipped count only where there are no others.
    """
    mean = (readings * seen).sum(axis=(1, 2)) / np.maximum(seen.sum(axis=(1, 2)), 1)
    mean = np.maximum(mean, 1e-6)
    good = clipped.mean(axis=(1, 2)) < 0.5
    if good.any():
        mean, inputs = mean[good], inputs[good]
    alike = float(np.exp(np.mean(np.log(mean / inputs.sum(axis=1)))))
    scaled = inputs * (alike / mean[:, None])
    normal = scaled.T @ scaled + POOL_TRUST * np.eye(inputs.shape[1])
    found = np.linalg.solve(normal, scaled.T @ np.ones(len(mean)) + POOL_TRUST)
    covariance = alike**2 * POOL_TRUST * np.linalg.inv(normal)  # of the prior alone: as uncertain as large
    return np.asarray(alike * np.maximum(found, LEAST_SHARE)), np.asarray(covariance)


def _expected_shape(samples: Samples, model: Model, pose: Pose, positions: Sequence[Floats | None]) -> Floats:
    """What each side gets of each coefficient, as a share of the target's mean, (2, N, 1 + L).

    A model without faces says nothing of it: all sides alike.
    """
    if not model.faces:
        return np.ones((2, len(samples.line), 1 + len(positions)))
    face = _face_beside(samples, model, pose)
    shape = np.ones((*face.shape, 1 + len(positions)))
    points = pose.apply(samples.points)
    normals = towards_camera(model.face_normals[np.maximum(face, 0)] @ pose.matrix.T, points)
    for light, position in enumerate(positions):
        if position is None:
            continue
        lit = np.where(face >= 0, lambert(points, normals, position), np.nan)
        mean = np.nanmean(lit) if (face >= 0).any() else np.nan
        if mean > 0.0:
            shape[..., 1 + light] = np.where(face >= 0, lit / mean, BACKGROUND_SHARE)
    return shape


def towards_camera(normals: Floats, points: Floats) -> Floats:
    """Normals (..., 3) in the camera's frame of what is seen at points (..., 3): that side of it."""
    return np.where((normals * points).sum(axis=-1, keepdims=True) > 0.0, -normals, normals)


def lambert(points: Floats, normals: Floats, position: Floats) -> Floats:
    """What a light gives to surfaces (..., 3), by Lambert's law and the square of the distance (...)."""
    towards = position - points
    distance = np.linalg.norm(towards, axis=-1)
    return np.asarray(np.maximum((normals * towards).sum(axis=-1) / distance, 0.0) / distance**2)


def _face_beside(samples: Samples, model: Model, pose: Pose) -> Ints:
    """Face seen on the side against and along each sample's normal, (2, N), -1 for what is behind."""
    middles = np.array([model.vertices[polygon].mean(axis=0) for polygon in model.faces])
    camera_in_target = pose.inverse().translation
    out = np.full((2, len(samples.line)), -1, dtype=np.int64)
    across = np.column_stack([samples.normal, np.zeros(len(samples.line))]) @ pose.matrix
    for faces in model.line_faces[samples.line].T:
        known = np.maximum(faces, 0)
        inward = middles[known] - samples.points
        inward -= (inward * samples.direction).sum(axis=1, keepdims=True) * samples.direction
        facing = (model.face_normals[known] * (camera_in_target - samples.points)).sum(axis=1) > 0.0
        use = (faces >= 0) & (facing | model.two_sided[known])
        side = ((inward * across).sum(axis=1) > 0.0).astype(np.int64)
        rows = np.flatnonzero(use)
        out[side[rows], rows] = faces[rows]
    return out
