"""Quality and time of the ways to merge images into one edge map: one JSON object a line.

    python -m benchmarks.edge_quality [--data DIR]

DIR holds `leaf_shadows/` (real leaves, cast shadows); without it only the rendered sets are measured.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.attached_shadows import BODIES, attached_shadow_set
from benchmarks.edge_metrics import EdgeQuality, edge_quality, outline_of
from vision_server.channel import channel_statistics
from vision_server.comparison_edges import comparison_edges
from vision_server.edges import ImageSetStatistics, merge_channels
from vision_server.image_files import read_grey
from vision_server.segments import extract_segments

Image = NDArray[np.uint8]
COMPARED = ("mean", "max-image", "max-gradient", "di-zenzo", "mertens")
METHODS = ("em", "em without weights", *COMPARED)
TRIPLES = ((1, 5, 9), (2, 6, 10), (3, 7, 11), (4, 8, 12))
REPEATS = 7
CANNY_THRESHOLDS = (50, 150)


def say(name: str, value: float, unit: str, **more: object) -> None:
    """One result."""
    print(json.dumps({"name": name, "value": round(value, 4), "unit": unit, **more}), flush=True)


def ridges(images: Sequence[Image], method: str) -> NDArray[np.float32]:
    """Merged magnitude on its ridges."""
    if method == "em":
        return merge_channels([channel_statistics(image) for image in images]).ridge
    if method == "em without weights":
        return merge_channels([channel_statistics(image, weight_exponent=0.0) for image in images]).ridge
    return comparison_edges(images, method).ridge  # type: ignore[arg-type]


def leaf_shadows(folder: Path) -> None:
    """Real cast shadows: three lights of twelve (four ways), and all twelve."""
    back = np.mean([read_grey(folder / f"{n}_BL.png").astype(np.float64) for n in range(1, 13)], axis=0)
    _, leaf = cv2.threshold(back.astype(np.uint8), 0, 1, cv2.THRESH_BINARY_INV | cv2.THRESH_OTSU)
    inside = leaf.astype(np.bool_)
    images = {n: read_grey(folder / f"{n}_TL.png") for n in range(1, 13)}

    def measured(chosen: Sequence[int], method: str) -> EdgeQuality:
        return edge_quality(ridges([images[n] for n in chosen], method), outline_of(inside), inside)

    for method in METHODS:
        three = [measured(triple, method) for triple in TRIPLES]
        report("leaf shadows, 3 of 12 lights", method, three)
        report("leaf shadows, 12 lights", method, [measured(range(1, 13), method)])


def report(name: str, method: str, found: Sequence[EdgeQuality]) -> None:
    """Mean over sets of images, with what each of them gave."""
    false = [q.false_at_recall_80 for q in found if q.false_at_recall_80 is not None]
    say(
        f"{name}: best F",
        float(np.mean([q.best_f for q in found])),
        "1",
        method=method,
        each=[round(q.best_f, 4) for q in found],
        false_px_at_best=round(float(np.mean([q.false_at_best for q in found])), 1),
        false_px_at_recall_80=round(float(np.mean(false)), 1) if false else None,
    )


def attached_shadows() -> None:
    """Rendered attached shadows."""
    nothing = np.zeros((240, 320), np.bool_)
    for body in BODIES:
        for lights in (12, 4):
            images, edges = attached_shadow_set(body, lights)
            for method in METHODS:
                quality = edge_quality(ridges(images, method), edges, nothing)
                report(f"attached shadows, {body}, {lights} lights", method, [quality])


def fastest(work: Callable[[], object]) -> float:
    """Shortest of some runs, ms, after one to warm up."""
    work()
    times = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        work()
        times.append(time.perf_counter() - began)
    return 1e3 * min(times)


def seconds(images: Sequence[Image], name: str) -> None:
    """Time of an edge map of four images beside cv2.Canny and cv2's LSD on the same four."""

    def whole() -> None:
        merge_channels([channel_statistics(image) for image in images])

    canny = fastest(lambda: [cv2.Canny(image, *CANNY_THRESHOLDS) for image in images])
    detector = cv2.createLineSegmentDetector()
    lsd = fastest(lambda: [detector.detect(image) for image in images])
    total = fastest(whole)
    say(f"4 channels to an edge map, {name}", total, "ms", canny_ms=canny, ratio=round(total / canny, 2))
    edges = merge_channels([channel_statistics(image) for image in images])
    segments = fastest(lambda: extract_segments(edges))
    say(
        f"4 channels to segments, {name}",
        total + segments,
        "ms",
        lsd_ms=lsd,
        ratio=round((total + segments) / lsd, 2),
    )
    channels = [channel_statistics(image) for image in images] * 3
    for count in (2, 12):
        image_set = ImageSetStatistics()
        for number in range(count):
            image_set.add(str(number), channels[number])
        again = [channel_statistics(images[0])]

        def last(image_set: ImageSetStatistics = image_set, again: list = again) -> None:  # type: ignore[type-arg]
            again[0] = channel_statistics(images[0])
            image_set.add(f"another {len(image_set.channels)}", again[0])

        say(f"adding a channel to {count}, {name}", fastest(last), "ms")
        say(f"merge of {count} channels, {name}", fastest(image_set.merge), "ms")


def main() -> None:
    """Measure everything there is data for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    here = Path(__file__).resolve().parent.parent
    parser.add_argument(
        "--data", type=Path, default=here.parent / "shared" / "data", help="folder of leaf_shadows/"
    )
    folder = parser.parse_args().data / "leaf_shadows"
    if folder.is_dir():
        leaf_shadows(folder)
        real = [cv2.resize(read_grey(folder / f"{n}_TL.png"), (640, 480)) for n in (1, 4, 7, 10)]
        seconds([np.asarray(image, np.uint8) for image in real], "leaves 640x480")
    else:
        print(
            json.dumps({"name": "leaf shadows", "value": None, "unit": "1", "skipped": f"no {folder.name}"})
        )
    attached_shadows()
    rendered, _ = attached_shadow_set("folded sheet", 4)
    seconds(
        [np.asarray(cv2.resize(image, (640, 480)), np.uint8) for image in rendered], "folded sheet 640x480"
    )


if __name__ == "__main__":
    main()
