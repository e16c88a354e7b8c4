"""Time of an edge map beside cv2.Canny and cv2's LSD on the same images, and of the N-th channel."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from benchmarks.lines import Show
from bridge.messages import Settings
from image_server.simulator.simulator import Simulator
from numerics.arrays import Grey
from vision_server.channels.channel import channel_statistics
from vision_server.edges.merging import ImageSetStatistics, merge_channels
from vision_server.edges.suppression import edgel_thresholds, hysteresis
from vision_server.kinds.kinds import edge_kinds
from vision_server.kinds.likelihoods import FIXED
from vision_server.segments.extraction import extract_segments

ROUNDS = 25
CANNY_THRESHOLDS = (50, 150)
EXPOSURE = 2.0
TARGETS = ("cube", "fixture", "satellite")
ONE_LIGHT_EACH_AND_ALL = ((7, 0, 0), (0, 7, 0), (0, 0, 7), (4, 4, 4))
SHUTTER_S, APERTURE = 1 / 60, 4.0


@dataclass(frozen=True)
class Taken:
    """Time of one run, ms: on the wall, and of the processor, which other work hardly changes."""

    wall: float
    cpu: float


def timed(work: Callable[[], object]) -> Taken:
    """Time of one run."""
    wall, cpu = time.perf_counter(), time.process_time()
    work()
    return Taken(1e3 * (time.perf_counter() - wall), 1e3 * (time.process_time() - cpu))


def alternately(*measures: Callable[[], Taken]) -> list[Taken]:
    """Shortest times that each measure gives when they take turns, after a round that does not count."""
    rounds = [[measure() for measure in measures] for _ in range(ROUNDS + 1)]
    return [
        Taken(min(taken.wall for taken in times), min(taken.cpu for taken in times))
        for times in zip(*rounds[1:], strict=True)
    ]


def simulated(target: str) -> list[Grey]:
    """Four images of one scene, 640 x 480: each light alone, and all together."""
    simulator = Simulator(target, "nominal", 1)
    return [
        np.asarray(simulator.capture(Settings(lights=levels, shutter_s=SHUTTER_S, aperture=APERTURE)).pixels)
        for levels in ONE_LIGHT_EACH_AND_ALL
    ]


def edge_times(show: Show, name: str, images: Sequence[Grey], exposure: float = 1.0) -> None:
    """Edge map, hysteresis, kinds and segments of all images, beside the peers on the same images."""

    def whole() -> None:
        edges = merge_channels([channel_statistics(image, exposure) for image in images])
        hysteresis(edges, *edgel_thresholds(edges))

    def with_kinds() -> None:
        edges = edge_kinds([channel_statistics(image, exposure) for image in images]).of_kinds(FIXED)
        hysteresis(edges, *edgel_thresholds(edges))

    detector = cv2.createLineSegmentDetector()
    edges = merge_channels([channel_statistics(image, exposure) for image in images])
    ours, kinds, grouping, canny, lsd = alternately(
        lambda: timed(whole),
        lambda: timed(with_kinds),
        lambda: timed(lambda: extract_segments(edges)),
        lambda: timed(lambda: [cv2.Canny(image, *CANNY_THRESHOLDS) for image in images]),
        lambda: timed(lambda: [detector.detect(image) for image in images]),
    )
    show(
        f"edges/{len(images)} channels, {name}", ours.wall, "ms",
        canny_ms=canny.wall, ratio=ours.wall / canny.wall, cpu_ratio=ours.cpu / canny.cpu,
        kinds_ms=kinds.wall, kinds_cpu_ratio=kinds.cpu / canny.cpu,
        segments_ms=grouping.wall, lsd_ms=lsd.wall, cpu_ratio_to_lsd=(ours.cpu + grouping.cpu) / lsd.cpu,
    )  # fmt: skip


def nth_channel(show: Show, name: str, images: Sequence[Grey], exposure: float = 1.0) -> None:
    """An image added to a merged set and the set merged again: the second, the twelfth; one taken out."""
    channels = [channel_statistics(image, exposure) for image in images] * 3

    def of_set(present: int) -> ImageSetStatistics:
        image_set = ImageSetStatistics()
        for number, channel in enumerate(channels[:present]):
            image_set.add(str(number), channel)
        image_set.merge()
        return image_set

    def adding(present: int) -> Taken:
        image_set = of_set(present)
        image = images[present % len(images)]

        def add_and_merge() -> None:
            image_set.add("last", channel_statistics(image, exposure))
            image_set.merge()

        return timed(add_and_merge)

    def removing(present: int) -> Taken:
        image_set = of_set(present)

        def remove_and_merge() -> None:
            image_set.remove("0")
            image_set.merge()

        return timed(remove_and_merge)

    second, twelfth, fewer = alternately(lambda: adding(1), lambda: adding(11), lambda: removing(12))
    show(
        f"edges/12th channel, {name}", twelfth.wall, "ms",
        second_ms=second.wall, cpu_ratio=twelfth.cpu / second.cpu, removing_from_12_ms=fewer.wall,
    )  # fmt: skip


def all_edge_times(show: Show) -> None:
    """Everything here, on simulated images of each target."""
    for target in TARGETS:
        images = simulated(target)
        edge_times(show, target, images, EXPOSURE)
        nth_channel(show, target, images, EXPOSURE)
