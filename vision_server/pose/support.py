"""How well the images support a pose: per-line errors, and an RMS that losing lines cannot lower."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from vision_server.channels.gradients import SCALES_PX, GradientChannel
from vision_server.pose.observation import Measurement, measure
from vision_server.pose.sampling import spacing_for
from vision_server.pose.weights import line_trust

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

CAP_PX = 4.0  # distance that a part of a visible line without support counts with
SUPPORT_PX = 1.0  # a part has support when its edge point is this close (times sqrt of the filter's scale)
LEAST_TRUST = 0.02  # of a line in a channel, for its edge points to be support
NORMAL_FLOOR_PX = 0.1  # RMS below this says nothing more


@dataclass(frozen=True)
class LineEvidence:
    """What the images say about one visible model line.

    Attributes
    ----------
    line
        Index into the model's lines.
    visible_px
        Length of its visible parts in the image.
    support
        Share of that length with an edge close to it, 0..1.
    rms_px
        Root mean square distance to the edges; parts without support count CAP_PX.
    image
        The channel that supports it most, None without support.
    """

    line: int
    visible_px: float
    support: float
    rms_px: float
    image: str | None


@dataclass(frozen=True, eq=False)
class Support:
    """Which edge points support the visible lines; N samples, C channels of these names, L model lines.

    Attributes
    ----------
    distance
        (N,) px, from the nearest edge point of any channel, at most CAP_PX.
    supports
        (C, N), whether a channel's edge point supports the sample.
    trust
        (C, L), see `line_trust`.
    """

    names: Sequence[str]
    distance: Floats
    supports: Flags
    trust: Floats


@dataclass(frozen=True, eq=False)
class Evidence:
    """Support of a whole pose.

    Attributes
    ----------
    rms_px
        Over the visible length of all lines, parts without support at CAP_PX.
    residual_rms_px
        Of the supported parts alone.
    supported_fraction
        Share of the visible length that is supported.
    strength
        Mean over the visible length of (1 - d / CAP_PX), from 0 to 1.
    clipped_fraction
        Share of the visible length that only edges beside saturated pixels support.
    snr
        Median signal-to-noise ratio of the supporting edge points.
    visible_px
        Visible length of all lines.
    support
        What each line's evidence follows from.
    measurement
        What it was computed from.
    """

    rms_px: float
    residual_rms_px: float
    supported_fraction: float
    strength: float
    clipped_fraction: float
    snr: float
    visible_px: float
    support: Support
    measurement: Measurement

    @cached_property
    def lines(self) -> tuple[LineEvidence, ...]:
        """Evidence of each visible line; of the many poses that are looked at, few are asked for it."""
        return _line_evidence(self.measurement.samples.line, self.measurement.samples.px, self.support)


def gather_evidence(
    channels: Sequence[GradientChannel],
    model: Model,
    camera: Camera,
    pose: Pose,
    scale: Ints,
    spacing_px: float | None = None,
) -> Evidence | None:
    """Measure the support of a pose; None when no line of the model is visible from it."""
    spacing = spacing_for(model, camera, pose) if spacing_px is None else spacing_px
    measurement = measure(channels, model, camera, pose, CAP_PX, scale, spacing)
    if len(measurement) == 0:
        return None
    return evidence_of(measurement, [channel.name for channel in channels], len(model.lines))


def evidence_of(measurement: Measurement, names: Sequence[str], lines: int) -> Evidence:
    """The support that a measurement speaks of; ``names`` of its channels."""
    line, px = measurement.samples.line, measurement.samples.px
    trust = line_trust(measurement, lines)
    sigma = np.array(SCALES_PX)[measurement.scale]
    near = np.abs(measurement.offset)
    usable = np.isfinite(near) & (trust[:, line] >= LEAST_TRUST)
    near = np.where(usable, np.minimum(near, CAP_PX), CAP_PX)
    distance = near.min(axis=0)
    best = near.argmin(axis=0)
    limit = SUPPORT_PX * np.sqrt(sigma[:, line])
    supports = usable & (near <= limit)
    supported = supports.any(axis=0)
    clean = (supports & (measurement.nuisance[:, :, 1] == 0.0)).any(axis=0)
    total = float(px.sum())
    part = px * supported
    residual = float(np.sqrt((part @ distance**2) / part.sum())) if part.sum() > 0 else CAP_PX
    snr = measurement.snr[best, np.arange(len(line))][supported]
    return Evidence(
        rms_px=float(np.sqrt((px @ distance**2) / total)),
        residual_rms_px=residual,
        supported_fraction=min(1.0, float(part.sum()) / total),
        strength=float(px @ (1.0 - distance / CAP_PX)) / total,
        clipped_fraction=float((px * (supported & ~clean)).sum()) / total,
        snr=float(np.median(snr)) if len(snr) else 0.0,
        visible_px=total,
        support=Support(names, distance, supports, trust),
        measurement=measurement,
    )


def _line_evidence(line: Ints, px: Floats, support: Support) -> tuple[LineEvidence, ...]:
    """Evidence of each visible line; line, px (N,)."""
    lines = support.trust.shape[1]
    visible = np.bincount(line, px, lines)
    supported = np.bincount(line, px * support.supports.any(axis=0), lines)
    squares = np.bincount(line, px * support.distance**2, lines)
    by_channel = np.stack([np.bincount(line, px * seen, lines) for seen in support.supports])
    most = np.argmax(by_channel * support.trust, axis=0)
    return tuple(
        LineEvidence(
            line=index,
            visible_px=float(visible[index]),
            support=min(1.0, float(supported[index] / visible[index])),
            rms_px=math.sqrt(squares[index] / visible[index]),
            image=support.names[most[index]] if by_channel[most[index], index] > 0 else None,
        )
        for index in np.flatnonzero(visible).tolist()
    )
