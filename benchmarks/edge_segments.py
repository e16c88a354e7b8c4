"""What segments are worth: those of the merged edge map beside cv2's LSD, by what the matcher makes of them.

    .venv/bin/python -m benchmarks.edge_segments [--seeds 2] [--starts 4]

Sets of three simulated images, one light each, exposed one by one so that hardly a pixel clips: three
targets, three suns, sharp and blurred. For each way to take segments: the share of the visible model lines
that lie under a segment, the share of the segments that lie on a model line, and how often the pose search
alone (no refinement) is right to 1 degree and 1 % of range from starts within 25 degrees and 40 px.
One JSON object a line.
"""

from __future__ import annotations

import argparse
import json
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from bridge.messages import Settings
from geometry.pose import RIGHT, disturbed
from geometry.visibility import visible_samples
from image_server.simulator.scenario import load_scenario, with_conditions
from image_server.simulator.simulator import Simulator
from numerics.arrays import Flags, Floats, Grey
from stack.exposure import REFERENCE, SHUTTERS_S
from vision_server.baselines.splitting import split_segments
from vision_server.channels.channel import channel_statistics
from vision_server.edges.edge_map import EdgeMap
from vision_server.edges.merging import merge_channels
from vision_server.matching import SearchRange, match_search
from vision_server.segments.extraction import extract_segments
from vision_server.segments.line_fit import Segments

TARGETS = ("cube", "fixture", "satellite")
SUNS = (0.0, 1.0, 20.0)
BLUR = {"sharp": (0.0, (0.0, 0.0)), "blurred": (3.0, (240.0, 160.0))}
ONE_LIGHT_EACH = ((7, 0, 0), (0, 7, 0), (0, 0, 7))
APERTURE = 4.0
CLIPPED_GREY, MOST_CLIPPED = 250, 0.002
LEAST_LSD_PX = 14.0  # shorter segments of LSD do the matcher harm
NEAR_PX, NEAR_RAD = 1.5, np.deg2rad(5.0)
RIGHT_DEG, RIGHT_SHARE = RIGHT


@dataclass(frozen=True)
class Exposed:
    """An image and its exposure relative to the reference."""

    image: Grey
    exposure: float


def exposed(simulator: Simulator, levels: tuple[int, ...]) -> Exposed:
    """The image under the longest shutter that hardly clips."""
    for shutter in reversed(SHUTTERS_S):
        frame = simulator.capture(Settings(lights=levels, shutter_s=shutter, aperture=APERTURE))
        image = np.asarray(frame.pixels)
        if np.mean(image >= CLIPPED_GREY) <= MOST_CLIPPED:
            break
    return Exposed(image, shutter / REFERENCE.shutter_s)


def lsd(image: Grey) -> Floats:
    """Segments of cv2's LSD that are long enough to be of use, float64 (N, 4)."""
    found = cv2.createLineSegmentDetector().detect(image)[0]
    ends = np.zeros((0, 4)) if found is None else np.asarray(found, np.float64).reshape(-1, 4)
    return ends[np.hypot(ends[:, 2] - ends[:, 0], ends[:, 3] - ends[:, 1]) >= LEAST_LSD_PX]


def merged(images: Sequence[Exposed], extract: Callable[[EdgeMap], Segments] = extract_segments) -> Floats:
    """Segments of the merged edge map."""
    channels = [channel_statistics(one.image, one.exposure) for one in images]
    return extract(merge_channels(channels)).endpoints


def ways(images: Sequence[Exposed]) -> Iterator[tuple[str, list[Floats]]]:
    """Each way to take segments of a set: one result, or one for each image."""
    singles = [lsd(one.image) for one in images]
    yield "LSD, one image", singles
    yield "LSD, three images united", [np.concatenate(singles)]
    yield "em, one image", [merged([one]) for one in images]
    yield "em, merged, splitting", [merged(images, split_segments)]
    yield "em, merged, growing", [merged(images)]


def on_lines(points: Floats, directions: Floats, ends: Floats) -> Flags:
    """Which of some oriented points lie under one of the segments."""
    found = np.zeros(len(points), np.bool_)
    for x0, y0, x1, y1 in ends:
        along = np.array([x1 - x0, y1 - y0])
        length = float(np.hypot(*along))
        along /= length
        offset = points - [x0, y0]
        place = offset @ along
        near = (place > -NEAR_PX) & (place < length + NEAR_PX)
        near &= np.abs(offset[:, 0] * along[1] - offset[:, 1] * along[0]) < NEAR_PX
        found |= near & (np.abs(directions @ along) > np.cos(NEAR_RAD))
    return found


def sampled(ends: Floats) -> tuple[Floats, Floats]:
    """Points a pixel apart on segments, and the segments' directions there."""
    points, directions = [np.zeros((0, 2))], [np.zeros((0, 2))]
    for x0, y0, x1, y1 in ends:
        length = max(float(np.hypot(x1 - x0, y1 - y0)), 1e-9)
        along = np.array([x1 - x0, y1 - y0]) / length
        t = np.arange(0.5, length)
        points.append(np.array([x0, y0]) + t[:, None] * along)
        directions.append(np.tile(along, (len(t), 1)))
    return np.concatenate(points), np.concatenate(directions)


def on_model(ends: Floats, points: Floats, directions: Floats) -> float:
    """Share of the segments' length that lies on the model's visible lines."""
    mine, along = sampled(ends)
    if not len(mine):
        return 0.0
    near = np.zeros(len(mine), np.bool_)
    for point, direction in zip(points, directions, strict=True):
        close = np.abs(mine - point).max(axis=1) < NEAR_PX
        near[close] |= np.abs(along[close] @ direction) > np.cos(NEAR_RAD)
    return float(near.mean())


def main() -> None:
    """Every set, every way, every start; then the means."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--seeds", type=int, default=2, help="poses for each target and condition")
    parser.add_argument("--starts", type=int, default=4, help="starts for each pose")
    options = parser.parse_args()
    results: dict[tuple[str, str], list[dict[str, float]]] = defaultdict(list)
    reach = SearchRange()
    for target in TARGETS:
        for condition, (defocus, motion) in BLUR.items():
            for sun in SUNS:
                scenario = with_conditions(
                    load_scenario("nominal"), sun, defocus_sigma_px=defocus, motion_px_per_s=motion
                )
                for seed in range(1, options.seeds + 1):
                    simulator = Simulator(target, scenario, seed)
                    images = [exposed(simulator, levels) for levels in ONE_LIGHT_EACH]
                    camera, model, true = simulator.camera, simulator.model, simulator.true_pose
                    samples = visible_samples(model, camera, true)
                    rng = np.random.default_rng(seed)
                    starts = [
                        disturbed(true, rng, reach.rotation_deg, reach.translation_px, camera.fx)
                        for _ in range(options.starts)
                    ]
                    for way, found in ways(images):
                        for ends in found:
                            poses = [
                                match_search(ends, model, camera, start, seed, reach) for start in starts
                            ]
                            errors = [m[0].pose.error_to(true) for m in poses if m]
                            right = sum(
                                e.rotation_deg < RIGHT_DEG and e.translation_fraction_of_range < RIGHT_SHARE
                                for e in errors
                            )
                            results[way, condition].append(
                                {
                                    "covered": float(
                                        on_lines(samples.image, samples.image_direction, ends).mean()
                                    ),
                                    "on_model": on_model(ends, samples.image, samples.image_direction),
                                    "segments": float(len(ends)),
                                    "found": right / len(starts),
                                }
                            )
    for (way, condition), rows in results.items():
        means = {key: round(float(np.mean([row[key] for row in rows])), 3) for key in rows[0]}
        print(json.dumps({"name": f"segments, {way}", "condition": condition, **means, "sets": len(rows)}))


if __name__ == "__main__":
    main()
