"""Edgels with their kinds as a table for other programs, and as a picture for people."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from numerics.arrays import Floats, Grey
from vision_server.edges.suppression import edgel_thresholds, hysteresis
from vision_server.kinds.kinds import EdgeKinds
from vision_server.kinds.likelihoods import HIGHLIGHT, KINDS, NOISE, SHADOW

COLOURS = ((255, 255, 255), (70, 220, 90), (60, 170, 255), (255, 90, 60), (255, 225, 60), (0, 0, 0))
"""Of each kind, RGB: outline white, crease green, print blue, shadow red, highlight yellow; noise: none."""
SPEAKING = 3.0  # standard deviations: a channel whose step is larger speaks for its edgel


def place_sd(kinds: EdgeKinds) -> Floats:
    """Standard deviation of each edgel's place across the edge from sensor noise, px (N,).

    The ridge is where the response h exp(-x^2 / 2 t^2) of the Gaussian derivative, with t^2 = s^2 + blur^2,
    has no slope; the noise of its slope is sqrt(3/2) / s times its own, if that of the pixels is white.
    """
    edges = kinds.edges
    scale = float(np.mean([channel.sigma_px for channel in edges.channels]))
    spread_squared = scale**2 + edges.blur_px**2
    noise = np.maximum(edges.floor.astype(np.float64), 1e-9)
    strength = np.maximum(edges.mass.astype(np.float64), noise)
    return np.asarray(np.sqrt(1.5) / scale * spread_squared * noise / strength)


def kinds_table(kinds: EdgeKinds) -> dict[str, NDArray[Any]]:
    """Columns of all edgels.

    Returns
    -------
    ``names`` of the K kinds; ``share`` (K,), how frequent they are; ``channels`` (C,), numbers of the images
    that they are told by; ``levels``, whether those of the lights were told, learnt or unknown; and of N
    edgels in C channels: ``points``
    (N, 2), x and y, px; ``axis_rad`` (N,), direction across the edge; ``place_sd_px`` (N,); ``kind`` (N,),
    number of the likeliest; ``probability`` (N, K); ``step`` (N, C), intensity ahead less behind, grey at
    reference exposure; ``significance`` (N, C), the step in standard deviations; ``speaks`` (N, C), which
    channels show the edge.
    """
    edges, sides = kinds.edges, kinds.sides
    step = (sides.near[:, 1] - sides.near[:, 0]).T
    significance = step / (np.sqrt(np.float32(2.0)) * sides.noise.T)
    return {
        "names": np.array(KINDS),
        "share": kinds.share.round(4),
        "channels": np.array(kinds.used),
        "levels": np.array(kinds.levels),
        "points": edges.points.astype(np.float64).round(3),
        "axis_rad": edges.axis.astype(np.float64).round(4),
        "place_sd_px": place_sd(kinds).round(4),
        "kind": kinds.probability.argmax(axis=0),
        "probability": kinds.probability.T.round(4),
        "step": step.astype(np.float64).round(2),
        "significance": significance.astype(np.float64).round(1),
        "speaks": (np.abs(significance) >= SPEAKING) & sides.known.T,
    }


def kinds_picture(kinds: EdgeKinds) -> Grey:
    """Edgels that survive hysteresis in the colour of their likeliest kind, uint8 (H, W, 3), BGR."""
    fixed = [kind for kind in range(len(KINDS)) if kind not in (SHADOW, HIGHLIGHT, NOISE)]
    picture = np.zeros((*kinds.edges.shape, 3), np.uint8)
    colours = np.array(COLOURS, np.uint8)[kinds.probability.argmax(axis=0)][:, ::-1]
    for group in (fixed, [SHADOW], [HIGHLIGHT]):
        edges = kinds.of_kinds(group)
        kept = hysteresis(edges, *edgel_thresholds(edges))
        kept &= np.isin(kinds.probability.argmax(axis=0), group)
        picture.reshape(-1, 3)[edges.places[kept]] = colours[kept]
    return picture
