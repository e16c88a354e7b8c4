"""Where edges are: the same one under different lights, and the merged one beside the truth.

    .venv/bin/python -m benchmarks.edge_places [--seeds 3]

Simulated targets, each light alone. Between two images: how far apart their edgels on one edge lie across it,
of those that stand LEAST_SIGNAL of their own noise out of it. Of the merge: how far its edgels lie from the
visible lines of the model at the true pose, of those whose signal is about 20; and of these, on lines that
have no other visible line beside them: what is printed on a narrow side moves both of its edges.
"""

from __future__ import annotations

import argparse
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from benchmarks.edge_times import APERTURE, EXPOSURE, SHUTTER_S, TARGETS
from benchmarks.lines import show
from bridge.messages import Settings
from geometry.visibility import visible_samples
from image_server.simulator import Simulator
from vision_server.channels.channel import ChannelStatistics, channel_statistics
from vision_server.edges.edge_map import EdgeMap
from vision_server.edges.merging import merge_channels

Floats = NDArray[np.float64]

LIGHTS = ((7, 0, 0), (0, 7, 0), (0, 0, 7))
LEAST_SIGNAL = 20.0
SIGNAL = (15.0, 25.0)
REACH_PX = 1.5
LEAST_COSINE = 0.97
SPACING_PX = 2.0
ALONE_PX = 6.0  # to the nearest line that runs alike: nearer ones are the edges of one narrow side


def nearest(edges: EdgeMap, points: Floats, normals: Floats) -> tuple[Floats, NDArray[np.int64]]:
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


def alone(points: Floats, along: Floats, line: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which samples (N, 2) of lines have no sample of another line that runs alike beside them, bool (N,)."""
    free = np.ones(len(points), np.bool_)
    for i, direction in enumerate(along):
        away = points - points[i]
        beside = (line != line[i]) & (np.abs(along @ direction) > LEAST_COSINE)
        beside &= np.abs(away @ direction) < SPACING_PX
        across = away[beside] @ np.array([-direction[1], direction[0]])
        free[i] = not (np.abs(across) < ALONE_PX).any()
    return free


def beside_truth(simulator: Simulator, edges: EdgeMap) -> tuple[Floats, NDArray[np.bool_]]:
    """Distances (N,) of edgels of about SIGNAL from the visible lines, signed, px; which are `alone`."""
    samples = visible_samples(simulator.model, simulator.camera, simulator.true_pose, SPACING_PX)
    along = samples.image_direction / np.linalg.norm(samples.image_direction, axis=1, keepdims=True)
    normals = np.stack([-along[:, 1], along[:, 0]], axis=1)
    offset, which = nearest(edges, samples.image, normals)
    signal = edges.mass / edges.floor
    good = which >= 0
    good[good] = ((signal > SIGNAL[0]) & (signal < SIGNAL[1]))[which[good]]
    return np.asarray(offset[good]), alone(samples.image, along, samples.line)[good]


def main() -> None:
    """Measure, and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seeds", type=int, default=3, help="views of each target (default: %(default)s)")
    seeds = range(1, parser.parse_args().seeds + 1)
    for target in TARGETS:
        apart, off, free = [], [], []
        for seed in seeds:
            simulator = Simulator(target, "nominal", seed)
            channels = []
            for levels in LIGHTS:
                settings = Settings(lights=levels, shutter_s=SHUTTER_S, aperture=APERTURE)
                image = np.asarray(simulator.capture(settings).pixels)
                channels.append(channel_statistics(image, EXPOSURE))
            apart += [between(*pair) for pair in combinations(channels, 2)]
            of_view, alone_there = beside_truth(simulator, merge_channels(channels))
            off.append(of_view)
            free.append(alone_there)
        pairs, errors, lone = np.concatenate(apart), np.concatenate(off), np.concatenate(free)
        show(f"edge places/{target}, two lights", float(np.median(pairs)), "px", edgels=len(pairs))
        show(
            f"edge places/{target}, merged beside the truth", float(np.median(np.abs(errors))), "px",
            mean_px=float(np.mean(errors)), edgels=len(errors),
            alone_px=float(np.median(np.abs(errors[lone]))), edgels_alone=int(lone.sum()),
        )  # fmt: skip


if __name__ == "__main__":
    main()
