"""Draw `docs/images/story.png`: four images, none to be trusted alone, their merged edges, and their pose.

python -m benchmarks.story_figure [OUT.png]
"""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path
from typing import Annotated

import cv2
import numpy as np
import typer

from benchmarks.edge_figure import LIT_GREY, Picture, captioned, drawn
from bridge.door import Prolog
from bridge.messages import Settings
from image_server.simulator.scenario import load_scenario
from image_server.simulator.simulator import Simulator
from report.overlay import draw_overlay
from stack.exposure import relative_exposure
from vision_server.image_set import ImageSet
from vision_server.judgement import Estimate
from vision_server.pipeline import estimate_pose

ROOT = Path(__file__).resolve().parent.parent
DEFAULT = ROOT / "docs" / "images" / "story.png"
MERIT = ROOT / "domain" / "reasoning" / "merit.pl"
TARGET, SCENARIO, SEED = "satellite", "harsh", 2
SETTINGS = (
    Settings(lights=(0, 0, 0), shutter_s=1 / 240, aperture=5.6),
    Settings(lights=(0, 7, 0), shutter_s=1 / 240, aperture=5.6),
    Settings(lights=(0, 0, 7), shutter_s=1 / 15, aperture=4.0),
    Settings(lights=(4, 0, 0), shutter_s=1 / 120, aperture=5.6),
)
MARGIN_PX = 20
PANEL_PX = 256  # width of a small panel; a large one has two


@cache
def controller() -> Prolog:
    """What the controller knows of merit (docs/trust.md)."""
    door = Prolog()
    door.use_module(MERIT)
    return door


def merit_px(estimate: Estimate) -> float:
    """What decides whether a pose is trusted, px."""
    quality = f"quality({estimate.rms_px}, {estimate.uncertainty}, 0, {estimate.score}, {estimate.ambiguity})"
    answer = controller().first(f"merit(fix(none, none, {quality}, []), Merit)")
    assert answer is not None
    return float(answer["Merit"])


def said(estimate: Estimate) -> str:
    """Whether it is trusted, in words."""
    if estimate.pose is None:
        return "alone: no pose"
    merit = merit_px(estimate)
    trusted = controller().holds(f"default_threshold(Threshold), {merit} =< Threshold")
    return f"alone: merit {merit:.1f} px, {'trusted' if trusted else 'not trusted'}"


def panel(picture: Picture, text: str, width: int) -> Picture:
    """A picture of this width under its words."""
    height = round(picture.shape[0] * width / picture.shape[1])
    shrunk = cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA)
    return captioned(np.asarray(shrunk, np.uint8), text)


def main(out: Annotated[Path, typer.Argument(help="The picture.")] = DEFAULT) -> None:
    """Take the images, estimate from each and from all, draw."""
    simulator = Simulator(TARGET, load_scenario(SCENARIO), SEED)
    about = simulator.describe()
    assert about.camera is not None and simulator.seed_pose is not None
    images = ImageSet(about.camera.width, about.camera.height)
    for number, settings in enumerate(SETTINGS, start=1):
        exposure = relative_exposure(settings.shutter_s, settings.aperture, about.reference)
        images.add(f"i{number}", simulator.capture(settings).pixels, exposure, about.camera.gamma)
    names = list(images.images)

    seed_pose = simulator.seed_pose

    def estimate(chosen: list[str]) -> Estimate:
        return estimate_pose(images, chosen, simulator.model, simulator.camera, seed_pose)

    together = estimate(names)
    assert together.pose is not None
    error = together.pose.error_to(simulator.true_pose)
    y, x = np.nonzero(images.images["i1"].pixels > LIT_GREY)
    top, left = max(y.min() - MARGIN_PX, 0), max(x.min() - MARGIN_PX, 0)
    crop = np.s_[top : y.max() + MARGIN_PX, left : x.max() + MARGIN_PX]
    small = [panel(images.images[name].pixels[crop], said(estimate([name])), PANEL_PX) for name in names]
    overlay = draw_overlay(images.images["i2"].pixels, simulator.model, simulator.camera, together.pose)
    large = [
        panel(drawn(images.edge_map(names))[crop], "together: merged edges", 2 * PANEL_PX),
        panel(
            overlay[crop],
            f"together: merit {merit_px(together):.1f} px; off by {error.rotation_deg:.2f} deg,"
            f" {1000 * error.translation_m:.1f} mm at {simulator.true_pose.translation[2]:.2f} m",
            2 * PANEL_PX,
        ),
    ]
    sheet = np.vstack([np.hstack(small), np.hstack(large)])
    out.parent.mkdir(parents=True, exist_ok=True)
    if not cv2.imwrite(str(out), sheet, [cv2.IMWRITE_PNG_COMPRESSION, 9]):
        sys.exit(f"Cannot write {out}.")


if __name__ == "__main__":
    typer.run(main)
