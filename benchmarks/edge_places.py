"""Where edges are: the same one under different lights, and the merged one beside the truth.

    .venv/bin/python -m benchmarks.edge_places [--seeds 3]

Simulated targets, each light alone. Between two images: how far apart their edgels on one edge lie across it,
of those that stand LEAST_SIGNAL of their own noise out of it. Of the merge: how far its edgels lie from the
visible lines of the model at the true pose, of those whose signal is about 20: of targets as they are, and of
the same ones with all faces plain. There the model's lines are the only edges; what is printed has edges of
its own, and on a narrow side these are what is found.
"""

from __future__ import annotations

import argparse
import re
import shutil
import tempfile
from collections.abc import Sequence
from itertools import combinations
from pathlib import Path

import numpy as np

from benchmarks.edge_times import APERTURE, EXPOSURE, SHUTTER_S, TARGETS
from benchmarks.lines import show
from bridge.messages import Settings
from geometry.model import find_target
from geometry.visibility import visible_samples
from image_server.simulator.simulator import Simulator
from numerics.arrays import Floats, Ints
from vision_server.channels.channel import ChannelStatistics, channel_statistics
from vision_server.edges.edge_map import EdgeMap
from vision_server.edges.merging import merge_channels

LIGHTS = ((7, 0, 0), (0, 7, 0), (0, 0, 7))
LEAST_SIGNAL = 20.0
SIGNAL = (15.0, 25.0)
REACH_PX = 1.5
LEAST_COSINE = 0.97
SPACING_PX = 2.0


def nearest(edges: EdgeMap, points: Floats, normals: Floats) -> tuple[Floats, Ints]:
    """Offsets along the normals of the edgels that lie beside the points and run as they do, and which."""
    best, which = np.full(len(points), np.inf), np.full(len(points), -1)
    x, y = np.round(points).astype(int).T
    for dy in range(-2, 3):
        for dx in range(-2, 3):
            u, v = np.clip(x + dx, 0, edges.shape[1] - 1), np.clip(y + dy, 0, edges.shape[0] - 1)
            at = edges.index[v, u]
            away = edges.points[at] - points
            offset = np.sum(away * normals, axis=1)
            along = np.abs(away[:, 0] * normals[:, 1] - away[:, 1] * normals[:, 0])
            same = np.abs(np.sum(edges.normals[at] * normals, axis=1)) > LEAST_COSINE
            good = (at >= 0) & same & (along <= 0.75) & (np.abs(offset) < np.minimum(np.abs(best), REACH_PX))
            best, which = np.where(good, offset, best), np.where(good, at, which)
    return best, which


def between(first: ChannelStatistics, second: ChannelStatistics) -> Floats:
    """Distances between the edgels that two images have on the same edges, px."""
    one, other = merge_channels([first]), merge_channels([second])
    sure = one.mass > LEAST_SIGNAL * one.floor
    offset, which = nearest(other, one.points[sure].astype(np.float64), one.normals[sure].astype(np.float64))
    seen = which >= 0
    seen[seen] = (other.mass > LEAST_SIGNAL * other.floor)[which[seen]]
    return np.abs(offset[seen])


def beside_truth(simulator: Simulator, edges: EdgeMap) -> Floats:
    """Distances (N,) of edgels of about SIGNAL from the visible lines, px."""
    samples = visible_samples(simulator.model, simulator.camera, simulator.true_pose, SPACING_PX)
    along = samples.image_direction / np.linalg.norm(samples.image_direction, axis=1, keepdims=True)
    offset, which = nearest(edges, samples.image, np.stack([-along[:, 1], along[:, 0]], axis=1))
    signal = edges.mass / edges.floor
    good = which >= 0
    good[good] = ((signal > SIGNAL[0]) & (signal < SIGNAL[1]))[which[good]]
    return np.asarray(np.abs(offset[good]))


def plain(target: str, folder: Path) -> Path:
    """A copy of a target of the project that has nothing printed on it: its model file."""
    own = find_target(target)
    model = Path(shutil.copy(own, folder))
    look = own.with_suffix(".toml").read_text(encoding="utf-8")
    model.with_suffix(".toml").write_text(
        re.sub('texture = ".*"', 'texture = "plain"', look), encoding="utf-8"
    )
    return model


def measured(target: str | Path, seeds: Sequence[int]) -> tuple[Floats, Floats]:
    """Over some views, what `between` gives of all pairs of images, and `beside_truth` of their merge."""
    apart, off = [], []
    for seed in seeds:
        simulator = Simulator(target, "nominal", seed)
        channels = []
        for levels in LIGHTS:
            settings = Settings(lights=levels, shutter_s=SHUTTER_S, aperture=APERTURE)
            image = np.asarray(simulator.capture(settings).pixels)
            channels.append(channel_statistics(image, EXPOSURE))
        apart += [between(*pair) for pair in combinations(channels, 2)]
        off.append(beside_truth(simulator, merge_channels(channels)))
    return np.concatenate(apart), np.concatenate(off)


def main() -> None:
    """Measure, and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seeds", type=int, default=3, help="views of each target (default: %(default)s)")
    seeds = range(1, parser.parse_args().seeds + 1)
    with tempfile.TemporaryDirectory() as folder:
        for name in TARGETS:
            for target, look in ((name, name), (plain(name, Path(folder)), f"{name}, plain")):
                pairs, off = measured(target, seeds)
                show(f"edge places/{look}, two lights", float(np.median(pairs)), "px", edgels=len(pairs))
                show(
                    f"edge places/{look}, merged beside the truth",
                    float(np.median(off)),
                    "px",
                    edgels=len(off),
                )


if __name__ == "__main__":
    main()
