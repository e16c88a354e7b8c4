"""Whether a target that moved is said to have moved, and none that did not: sets of images of statues.

python -m benchmarks.movement [--statues N] [--seed N]

A statue under one light, and under three others, and then under another light: as it is, and shifted by 6 to
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
from vision_server.edges.moved import moved_since, sure_edgels

ELEVATIONS_DEG = (15.0, 35.0)  # of the lights: low, where opposite ones leave no edge in common, and high
EARLIER = (1, 3)  # images
NEAREST_PX, FARTHEST_PX = 6.0, 32.0
RIGHT_PX = 5.0  # off the true shift


def main(
    statues: Annotated[
        int, typer.Option(help="Of each kind: matt and painted, under low and high light.")
    ] = 4,
    seed: Annotated[int, typer.Option(help="Of the first statue.")] = 100,
) -> None:
    """Print how many sets are said to have moved, of those that did and of those that did not."""
    rng = np.random.default_rng(seed)
    for elevation_deg in ELEVATIONS_DEG:
        for painted in (False, True):
            # for each number of earlier images: sets, said where nothing moved, where it did, by its shift
            counts = np.zeros((len(EARLIER), 4), np.int64)
            for number in range(seed, seed + statues):
                counts += of_a_statue(rng, number, painted, elevation_deg)
            for earlier, (sets, *said) in zip(EARLIER, counts.tolist(), strict=True):
                of = {"elevation_deg": elevation_deg, "painted": painted, "earlier": earlier, "sets": sets}
                for name, count in zip(("false", "said", "said_right"), said, strict=True):
                    show(f"movement_{name}", 100 * count / sets, "%", **of)


def of_a_statue(
    rng: np.random.Generator, seed: int, painted: bool, elevation_deg: float
) -> list[tuple[int, int, int, int]]:
    """By the number of earlier images: sets; of how many movement is told where nothing moved, where it did,
    and by the right shift."""
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
    counts = []
    for earlier in EARLIER:
        false = said = right = 0
        pairs = list(permutations(range(len(images)), 2))
        for first, last in pairs:
            others = [n for n in range(len(images)) if n not in (first, last)]
            before = [still[n] for n in (first, *rng.permutation(others)[: earlier - 1])]
            false += moved_since(before, still[last]) is not None
            found = moved_since(before, shifted[last])
            said += found is not None
            right += found is not None and bool(np.hypot(*(found.shift_px - shifts[last])) <= RIGHT_PX)
        counts.append((len(pairs), false, said, right))
    return counts


if __name__ == "__main__":
    typer.run(main)
