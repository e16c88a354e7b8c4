"""Quality and time of the ways to merge images into one edge map: one JSON object a line.

    python -m benchmarks.edge_quality [--data DIR] [--plot OUT.png]

DIR holds `leaf_shadows/` (real leaves, cast shadows); without it only the rendered sets are measured.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from matplotlib.figure import Figure

from benchmarks.attached_shadows import BODIES, attached_shadow_set
from benchmarks.edge_times import edge_times
from benchmarks.lines import show
from experiments.edge_metrics import EdgeQuality, edge_quality, outline_of
from numerics.arrays import Field, Grey
from vision_server.baselines import MERGE_RULES
from vision_server.baselines.merge_rules import comparison_edges
from vision_server.channels.channel import channel_statistics
from vision_server.channels.image_files import read_grey
from vision_server.channels.lighting import WEIGHT_EXPONENT
from vision_server.channels.overexposure import overexposures
from vision_server.edges.merging import merge_channels
from vision_server.kinds.kinds import edge_kinds
from vision_server.kinds.likelihoods import FIXED

Results = dict[str, dict[str, dict[str, float]]]  # set of images -> rule -> measure
METHODS = ("em", "em, fixed kinds", "em without weights", *MERGE_RULES, "lsd, first image", "lsd, united")
TRIPLES = ((1, 5, 9), (2, 6, 10), (3, 7, 11), (4, 8, 12))
SATURATED = (4.0, 12.0)  # times that an image among good ones is overexposed


def ridges(images: Sequence[Grey], method: str) -> Field:
    """Merged magnitude on its ridges; exposures are what the images show of them, as in `edges`."""
    if method.startswith("lsd"):
        return segments_drawn(images if method == "lsd, united" else images[:1])
    times = overexposures(images, [1.0] * len(images))
    if method in MERGE_RULES:
        return comparison_edges(images, method, times).ridge
    exponent = 0.0 if method == "em without weights" else WEIGHT_EXPONENT
    channels = [
        channel_statistics(image, time, weight_exponent=exponent)
        for image, time in zip(images, times, strict=True)
    ]
    if method == "em, fixed kinds":
        return edge_kinds(channels).of_kinds(FIXED).ridge
    return merge_channels(channels).ridge


def segments_drawn(images: Sequence[Grey]) -> Field:
    """LSD's segments of all images, as strong as they are unlikely by chance: -log10 of the false alarms."""
    detector = cv2.createLineSegmentDetector(cv2.LSD_REFINE_ADV)
    drawn = np.zeros(images[0].shape, np.float32)
    for image in images:
        ends, _, _, alarms = detector.detect(image)
        if ends is None:
            continue
        for at in np.argsort(alarms.ravel()):
            x0, y0, x1, y1 = (round(float(place)) for place in ends.reshape(-1, 4)[at])
            line = np.zeros_like(drawn)
            cv2.line(line, (x0, y0), (x1, y1), max(float(alarms.ravel()[at]), 1e-3), 1)
            drawn = np.maximum(drawn, line)
    return drawn


def leaf_shadows(folder: Path, results: Results) -> None:
    """Real cast shadows: three lights of twelve (four ways), and all twelve."""
    back = np.mean([read_grey(folder / f"{n}_BL.png").astype(np.float64) for n in range(1, 13)], axis=0)
    _, leaf = cv2.threshold(back.astype(np.uint8), 0, 1, cv2.THRESH_BINARY_INV | cv2.THRESH_OTSU)
    inside = leaf.astype(np.bool_)
    images = {n: read_grey(folder / f"{n}_TL.png") for n in range(1, 13)}

    def measured(chosen: Sequence[int], method: str) -> EdgeQuality:
        return edge_quality(ridges([images[n] for n in chosen], method), outline_of(inside), inside)

    for method in METHODS:
        three = [measured(triple, method) for triple in TRIPLES]
        report(results, "leaf shadows, 3 of 12 lights", method, three)
        report(results, "leaf shadows, 12 lights", method, [measured(range(1, 13), method)])
    for times in SATURATED:
        for triple in TRIPLES:
            number = triple[0] % 12 + 1
            images[-number] = np.asarray(cv2.convertScaleAbs(images[number], alpha=times), np.uint8)
        fourth = [measured((*triple, -(triple[0] % 12 + 1)), "em") for triple in TRIPLES]
        report({}, f"leaf shadows, 3 lights and one overexposed {times:.0f} times", "em", fourth)


def report(results: Results, name: str, method: str, found: Sequence[EdgeQuality]) -> None:
    """Mean over sets of images, with what each of them gave."""
    false = [q.false_at_recall_80 for q in found if q.false_at_recall_80 is not None]
    measured = {
        "best F": float(np.mean([q.best_f for q in found])),
        "false pixels at best F": float(np.mean([q.false_at_best for q in found])),
        "Pratt's figure of merit": float(np.mean([q.best_merit for q in found])),
    }
    results.setdefault(name, {})[method] = measured
    show(
        f"{name}: best F",
        measured["best F"],
        "1",
        method=method,
        each=[round(q.best_f, 4) for q in found],
        false_px_at_best=round(measured["false pixels at best F"], 1),
        false_px_at_recall_80=round(float(np.mean(false)), 1) if false else None,
        pratt=round(measured["Pratt's figure of merit"], 4),
    )


def plot(results: Results, out: Path) -> None:
    """Each measure in a panel, each set of images a group of bars, each rule a colour."""
    measures = list(next(iter(next(iter(results.values())).values())))
    figure = Figure(figsize=(11.0, 3.0 * len(measures)), layout="constrained")
    places = np.arange(len(results))
    width = 0.8 / len(METHODS)
    for axes, measure in zip(figure.subplots(len(measures), 1, sharex=True), measures, strict=True):
        for number, method in enumerate(METHODS):
            heights = [of_set[method][measure] for of_set in results.values()]
            axes.bar(places + (number - 0.5 * (len(METHODS) - 1)) * width, heights, width, label=method)
        axes.set_ylabel(measure)
        if measure.startswith("false"):
            axes.set_yscale("symlog", linthresh=10)
        else:
            lowest = min(m[measure] for of_set in results.values() for m in of_set.values())
            axes.set_ylim(max(0.0, lowest - 0.05), 1.005)
    axes.set_xticks(places, [name.replace(", ", "\n") for name in results], fontsize=8)
    figure.legend(
        *axes.get_legend_handles_labels(),
        ncols=(len(METHODS) + 1) // 2,
        loc="outside upper center",
        fontsize=8,
    )
    out.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(out, dpi=100)


def attached_shadows(results: Results) -> None:
    """Rendered attached shadows."""
    nothing = np.zeros((240, 320), np.bool_)
    for body in BODIES:
        for lights in (12, 4):
            images, edges = attached_shadow_set(body, lights)
            for method in METHODS:
                quality = edge_quality(ridges(images, method), edges, nothing)
                report(results, f"attached shadows, {body}, {lights} lights", method, [quality])


def main() -> None:
    """Measure everything there is data for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    here = Path(__file__).resolve().parent.parent
    parser.add_argument(
        "--data", type=Path, default=here.parent / "shared" / "data", help="folder of leaf_shadows/"
    )
    parser.add_argument("--plot", type=Path, help="draw what was measured into this file")
    options = parser.parse_args()
    results: Results = {}
    folder = options.data / "leaf_shadows"
    if folder.is_dir():
        leaf_shadows(folder, results)
        real = [cv2.resize(read_grey(folder / f"{n}_TL.png"), (640, 480)) for n in (1, 4, 7, 10)]
        edge_times(show, "leaves", [np.asarray(image, np.uint8) for image in real])
    else:
        print(
            json.dumps({"name": "leaf shadows", "value": None, "unit": "1", "skipped": f"no {folder.name}"})
        )
    attached_shadows(results)
    if options.plot is not None:
        plot(results, options.plot)


if __name__ == "__main__":
    main()
