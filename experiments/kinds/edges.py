"""Edge maps: three images, one light each, merged by a rule; how well the target's outline stands out."""

from __future__ import annotations

import cv2
import numpy as np

from bridge.messages import Settings
from experiments.edge_metrics import edge_quality, outline_of
from experiments.kinds import Row
from experiments.plan import Cell
from experiments.worker import Worker
from image_server.simulator.simulator import Simulator
from numerics.arrays import Flags, Grey
from vision_server.baselines.merge_rules import comparison_edges
from vision_server.channels.channel import channel_statistics
from vision_server.edges.merging import merge_channels

CLIPPED_GREY, MOST_CLIPPED = 250, 0.002  # of an image that is well exposed; chosen by hand
SUBPIXEL_BITS = 4  # of cv2's coordinates


def run(cell: Cell, worker: Worker) -> Row:
    """Quality of the edges outside and on the outline; those within it are neither right nor wrong."""
    simulator = worker.device(cell)
    assert isinstance(simulator, Simulator)
    lights = simulator.describe().lights
    taken = []
    for number in range(len(lights)):
        levels = tuple(light.levels - 1 if i == number else 0 for i, light in enumerate(lights))
        taken.append(_well_exposed(simulator, levels))
    images, exposures = [image for image, _ in taken], [exposure for _, exposure in taken]
    rule = cell.controller_source
    if rule in ("em", "em-unweighted"):
        options = {} if rule == "em" else {"weight_exponent": 0.0}
        channels = [channel_statistics(i, e, **options) for i, e in zip(images, exposures, strict=True)]
        ridge = merge_channels(channels).ridge
    else:
        ridge = comparison_edges(images, rule, exposures).ridge  # type: ignore[arg-type]
    inside = silhouette(simulator)
    found = edge_quality(ridge, outline_of(inside), inside)
    return {
        "status": "merged",
        "images": len(images),
        "kept": len(images),
        "best_f": found.best_f,
        "false_at_best": float(found.false_at_best),
        "false_at_recall_80": None if found.false_at_recall_80 is None else float(found.false_at_recall_80),
    }


def _well_exposed(simulator: Simulator, levels: tuple[int, ...]) -> tuple[Grey, float]:
    """The image under the longest shutter that hardly clips, and its exposure relative to the reference."""
    device = simulator.describe()
    aperture = device.reference.aperture
    for shutter in sorted(device.shutters_s, reverse=True):
        settings = Settings(lights=levels, shutter_s=shutter, aperture=aperture)
        image = simulator.capture(settings).pixels
        if np.mean(image >= CLIPPED_GREY) <= MOST_CLIPPED:
            break
    return image, shutter / device.reference.shutter_s


def silhouette(simulator: Simulator) -> Flags:
    """Pixels (H, W) that the target covers."""
    camera, model = simulator.camera, simulator.model
    corners = camera.project(simulator.true_pose.apply(model.vertices))
    mask = np.zeros((camera.height, camera.width), np.uint8)
    fixed = np.round(corners * (1 << SUBPIXEL_BITS)).astype(np.int32)
    for triangle in model.triangles:
        cv2.fillConvexPoly(mask, fixed[triangle], 1, shift=SUBPIXEL_BITS)
    return mask > 0
