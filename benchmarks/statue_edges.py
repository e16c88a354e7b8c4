"""Outlines of statues by each rule, from 4 and from 12 images, under looks that vary: one JSON object a line.

    python -m benchmarks.statue_edges [--look NAME ...] [--statues N] [--seed N]

True is the silhouette's contour; false is what lies within it, true creases as well: so what `--kind outline`
gives is compared, too. Thresholds have hysteresis, the low one 0.4 of the high one.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import cv2
import numpy as np
import typer

from benchmarks.lines import show
from benchmarks.statues import LOOKS, statue
from numerics.arrays import Field, Flags, Grey
from vision_server.baselines import MERGE_RULES
from vision_server.baselines.merge_rules import comparison_edges
from vision_server.channels.channel import channel_statistics
from vision_server.channels.overexposure import overexposures
from vision_server.edges.merging import merge_channels
from vision_server.kinds.kinds import edge_kinds
from vision_server.kinds.likelihoods import FIXED, OUTLINE

Ridge = Field
TOLERANCE_PX, INSIDE_PX = 2.5, 6.0
LOW_OF_HIGH = 0.4
PERCENTILES = (30, 40, 50, 60, 65, 70, 75, 80, 84, 88, 91, 94, 96, 98, 99)
RECALL = 0.8
COUNTS = (4, 12)  # of images


class Score(NamedTuple):
    """The best F over thresholds, and the fewest false pixels where `RECALL` of the contour is found."""

    best_f: float
    false_px: int | None


def score(ridge: Ridge, mask: Flags) -> Score:
    """How well a magnitude (H, W) shows the contour of ``mask`` and nothing inside it."""
    true = np.zeros(mask.shape, np.uint8)
    contours, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    cv2.drawContours(true, contours, -1, 255, 1)
    distance = cv2.distanceTransform((true == 0).astype(np.uint8), cv2.DIST_L2, 5)
    inside = mask & (distance > INSIDE_PX)
    top = float(ridge.max())
    highs = [
        *np.percentile(ridge[ridge > 0], PERCENTILES).tolist(),
        *np.geomspace(top / 200, 0.95 * top, 24).tolist(),
    ]
    found = []
    for high in highs:
        edges = _hysteresis(ridge, high)
        near = cv2.distanceTransform((~edges).astype(np.uint8), cv2.DIST_L2, 5)
        recall = float((near[true > 0] <= TOLERANCE_PX).mean())
        false, right = int((edges & inside).sum()), int((edges & (distance <= TOLERANCE_PX)).sum())
        precision = right / max(1, right + false)
        found.append((2 * precision * recall / max(1e-9, precision + recall), recall, false))
    false_px = min((false for _, recall, false in found if recall >= RECALL), default=None)
    return Score(max(f for f, _, _ in found), false_px)


def _hysteresis(ridge: Ridge, high: float) -> Flags:
    count, pieces = cv2.connectedComponents((ridge > LOW_OF_HIGH * high).astype(np.uint8), connectivity=8)
    kept = np.zeros(count, np.bool_)
    kept[np.unique(pieces[ridge > high])] = True
    kept[0] = False
    return np.asarray(kept[pieces])


def ridges(images: list[Grey]) -> dict[str, Ridge]:
    """What each rule makes of a set of images."""
    times = overexposures(images, [1.0] * len(images))
    channels = [channel_statistics(image, time) for image, time in zip(images, times, strict=True)]
    kinds = edge_kinds(channels)
    return {
        "fixed kinds": kinds.of_kinds(FIXED).ridge,
        "outline": kinds.of_kinds([OUTLINE]).ridge,
        "em": merge_channels(channels).ridge,
        **{rule: comparison_edges(images, rule, times).ridge for rule in MERGE_RULES},
    }


def main(
    look: Annotated[list[str] | None, typer.Option(help="Names of looks; all where none is given.")] = None,
    statues: Annotated[int, typer.Option(help="Of each look.")] = 3,
    seed: Annotated[int, typer.Option(help="Of the first statue.")] = 100,
) -> None:
    """Print the mean best F and false pixels of each rule, with those of each statue."""
    for name in look or LOOKS:
        drawn = [statue(number, LOOKS[name]) for number in range(seed, seed + statues)]
        for count in COUNTS:
            found: dict[str, list[Score]] = {}
            for images, mask in drawn:
                for rule, ridge in ridges(images[:: len(images) // count]).items():
                    found.setdefault(rule, []).append(score(ridge, mask))
            for rule, each in found.items():
                show(
                    "statue_edges",
                    float(np.mean([one.best_f for one in each])),
                    "1",
                    look=name,
                    images=count,
                    rule=rule,
                    each=[round(one.best_f, 3) for one in each],
                    false_px_at_recall_80=[one.false_px for one in each],
                )


if __name__ == "__main__":
    typer.run(main)
