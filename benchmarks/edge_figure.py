"""Draw `docs/images/merged-edges.png`: three images, one light each, and what each merge makes of them.

python -m benchmarks.edge_figure [OUT.png]
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import cv2
import numpy as np
import typer

from bridge.messages import Settings
from image_server.simulator.scenario import load_scenario, with_conditions
from image_server.simulator.simulator import Simulator
from numerics.arrays import Grey
from vision_server.baselines import MERGE_RULES
from vision_server.baselines.merge_rules import comparison_edges
from vision_server.channels.channel import channel_statistics
from vision_server.edges.edge_map import EdgeMap
from vision_server.edges.merging import merge_channels
from vision_server.segments.extraction import extract_segments

DEFAULT = Path(__file__).resolve().parent.parent / "docs" / "images" / "merged-edges.png"
LIGHTS = ((7, 0, 0), (0, 7, 0), (0, 0, 7))
SHUTTER_S, APERTURE = 1 / 15, 4.0
STRONGEST = 0.05  # share of the pixels drawn: every rule gets as many
BACKGROUND, INK = 255, 30
COLUMNS = 4
SHRINK = 0.8
LIT_GREY, MARGIN_PX = 16, 12  # what belongs to the target, and the frame around it


def drawn(edges: EdgeMap) -> Grey:
    """The strongest edgels, dark on white; the darker the stronger."""
    ridge = edges.ridge
    count = int(STRONGEST * ridge.size)
    weakest = float(np.partition(ridge, -count, axis=None)[-count])
    rank = np.clip(ridge / max(3.0 * weakest, 1e-6), 0.0, 1.0)
    shade = np.where(ridge >= max(weakest, 1e-6), BACKGROUND - rank * (BACKGROUND - INK), BACKGROUND)
    return shade.astype(np.uint8)


def captioned(picture: Grey, text: str) -> Grey:
    """The picture in colour under its name."""
    colour = cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR) if picture.ndim == 2 else picture
    bar = np.full((26, colour.shape[1], 3), BACKGROUND, np.uint8)
    cv2.putText(bar, text, (4, 19), cv2.FONT_HERSHEY_SIMPLEX, 0.55, (INK, INK, INK), 1, cv2.LINE_AA)
    return np.vstack([bar, colour])


def main(out: Annotated[Path, typer.Argument(help="The picture.")] = DEFAULT) -> None:
    """Render, merge, draw."""
    scenario = with_conditions(load_scenario("nominal"), ambient_scale=0.3)
    simulator = Simulator("fixture", scenario, seed=4)
    images = [
        np.asarray(simulator.capture(Settings(lights=levels, shutter_s=SHUTTER_S, aperture=APERTURE)).pixels)
        for levels in LIGHTS
    ]
    y, x = np.nonzero(np.max(images, axis=0) > LIT_GREY)
    crop = np.s_[
        max(y.min() - MARGIN_PX, 0) : y.max() + MARGIN_PX, max(x.min() - MARGIN_PX, 0) : x.max() + MARGIN_PX
    ]
    images = [np.ascontiguousarray(image[crop]) for image in images]
    merged = merge_channels([channel_statistics(image) for image in images])
    unweighted = merge_channels([channel_statistics(image, weight_exponent=0.0) for image in images])
    lines = np.full((*images[0].shape, 3), BACKGROUND, np.uint8)
    for x0, y0, x1, y1 in np.round(8.0 * extract_segments(merged).endpoints).astype(int):
        cv2.line(lines, (x0, y0), (x1, y1), (170, 60, 0), 1, cv2.LINE_AA, 3)
    panels = [captioned(image, f"light {number}") for number, image in enumerate(images, start=1)]
    panels += [captioned(drawn(comparison_edges(images, rule)), rule) for rule in MERGE_RULES]
    panels += [captioned(drawn(unweighted), "em, unweighted"), captioned(drawn(merged), "em")]
    panels += [captioned(lines, "em: segments")]
    panels.insert(3, captioned(np.max(images, axis=0), "brightest of the three"))
    rows = [np.hstack(panels[k : k + COLUMNS]) for k in range(0, len(panels), COLUMNS)]
    sheet = cv2.resize(np.vstack(rows), None, fx=SHRINK, fy=SHRINK, interpolation=cv2.INTER_AREA)
    out.parent.mkdir(parents=True, exist_ok=True)
    if not cv2.imwrite(str(out), sheet):
        sys.exit(f"Cannot write {out}.")


if __name__ == "__main__":
    typer.run(main)
