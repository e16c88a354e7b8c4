"""Whether a target that moved is said to have moved, and none that did not: every pair of images of statues.

python -m benchmarks.movement [--statues N] [--seed N]

The first of each pair shows a statue under one light, the second under another: as it is, and shifted by 6 to
32 px. One JSON object a line.
"""

from __future__ import annotations

from itertools import permutations
from typing import Annotated

import numpy as np
import typer

from benchmarks.lines import show
from benchmarks.statues import Look, statue
from vision_server.channels.channel import channel_statistics
from vision_server.edges.moved import movement, sure_edgels

ELEVATIONS_DEG = (15.0, 35.0)  # of the lights: low, where opposite ones leave no edge in common, and high
NEAREST_PX, FARTHEST_PX = 6.0, 32.0
RIGHT_PX = 5.0  # off the true shift


def main(
    statues: Annotated[
        int, typer.Option(help="Of each kind: matt and painted, under low and high light.")
    ] = 4,
    seed: Annotated[int, typer.Option(help="Of the first statue.")] = 100,
) -> None:
    """Print how many pairs are said to have moved, of those that did and of those that did not."""
    rng = np.random.default_rng(seed)
    for elevation_deg in ELEVATIONS_DEG:
        for painted in (False, True):
            counts = np.zeros(
                4, np.int64
            )  # pairs, said of none that moved, of shifted ones, by the right shift
            for number in range(seed, seed + statues):
                counts += of_a_statue(rng, number, painted, elevation_deg)
            pairs, *said = (int(count) for count in counts)
            of = {"elevation_deg": elevation_deg, "painted": painted, "pairs": pairs}
            for name, count in zip(("false", "said", "said_right"), said, strict=True):
                show(f"movement_{name}", 100 * count / pairs, "%", **of)


def of_a_statue(
    rng: np.random.Generator, seed: int, painted: bool, elevation_deg: float
) -> tuple[int, int, int, int]:
    """Pairs; of how many movement is told: where nothing moved, where it did, and that by the right shift."""
    images = statue(seed, Look(painted, elevation_deg)).images
    still = [sure_edgels(channel_statistics(image)) for image in images]
    angles, lengths = (
        rng.uniform(0, 2 * np.pi, len(images)),
        rng.uniform(NEAREST_PX, FARTHEST_PX, len(images)),
    )
    shifts = np.rint(lengths[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)).astype(int)
    shifted = [
        sure_edgels(channel_statistics(np.roll(image, (y, x), axis=(0, 1))))
        for image, (x, y) in zip(images, shifts, strict=True)
    ]
    pairs = list(permutations(range(len(images)), 2))
    false = sum(movement(still[first], still[second]) is not None for first, second in pairs)
    found = [(second, movement(still[first], shifted[second])) for first, second in pairs]
    said = [(second, one) for second, one in found if one is not None]
    right = sum(bool(np.hypot(*(one.shift_px - shifts[second])) <= RIGHT_PX) for second, one in said)
    return len(pairs), false, len(said), right


if __name__ == "__main__":
    typer.run(main)
