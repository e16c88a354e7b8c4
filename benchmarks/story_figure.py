"""Draw `docs/images/story.png`: four images, none to be trusted alone, their merged edges, and their pose.

python -m benchmarks.story_figure [OUT.png]
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated

import cv2
import numpy as np
import typer
from msgspec.structs import replace

from benchmarks.edge_figure import LIT_GREY, captioned, drawn
from bridge.door import Prolog
from bridge.messages import Settings
from image_server.simulator.scenario import load_scenario
from image_server.simulator.scenario_tables import Light, Scenario
from image_server.simulator.simulator import Simulator
from numerics.arrays import Grey
from report.overlay import draw_overlay
from stack.exposure import relative_exposure
from vision_server.image_set import ImageSet
from vision_server.pipeline import estimate_pose
from vision_server.trust.judgement import Estimate

ROOT = Path(__file__).resolve().parent.parent
DEFAULT = ROOT / "docs" / "images" / "story.png"
MERIT = ROOT / "domain" / "reasoning" / "merit.pl"
TARGET, SCENARIO, SEED = "satellite", "back-lit", 1
SUN_DEG = (140.0, 160.0)  # from the camera's direction: the faces that are seen are all black
LAMPS_M, AIM_M, AHEAD_M, BEAM_DEG = 0.35, 0.14, 0.75, 3.0  # places and aims aside of the lens; half intensity
LAMPS = {
    "left": (-1, 0),
    "right": (1, 0),
    "top": (0, -0.7),
    "bottom": (0, 0.7),
}  # where each is aimed, of AIM_M
SHUTTER_S, APERTURE = 1 / 15, 2.8
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


def panel(picture: Grey, text: str, width: int) -> Grey:
    """A picture of this width under its words."""
    height = round(picture.shape[0] * width / picture.shape[1])
    shrunk = cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA)
    return captioned(np.asarray(shrunk, np.uint8), text)


def scenario() -> Scenario:
    """The sun behind the target, and lamps with beams so narrow that each lights a part."""
    back_lit = load_scenario(SCENARIO)
    lamps = []
    for name, (x, y) in LAMPS.items():
        place = (LAMPS_M * np.sign(x), LAMPS_M * np.sign(y), 0.0)
        aim = (AIM_M * x - place[0], AIM_M * y - place[1], AHEAD_M)
        lamps.append(Light(name=name, position=place, aim=aim, half_intensity_deg=BEAM_DEG))
    sun = replace(back_lit.sun, angle_deg=SUN_DEG, earthshine=0.0)
    return replace(back_lit, sun=sun, lights=tuple(lamps))


@dataclass(frozen=True)
class Story:
    """The images, each under one lamp, and what is estimated from each alone and from all together."""

    simulator: Simulator
    images: ImageSet
    alone: list[Estimate]
    together: Estimate


def told(seed: int = SEED) -> Story:
    """Take the images, and estimate."""
    simulator = Simulator(TARGET, scenario(), seed)
    about, seed_pose = simulator.describe(), simulator.seed_pose
    assert about.camera is not None and seed_pose is not None
    images = ImageSet(about.camera.width, about.camera.height)
    exposure = relative_exposure(SHUTTER_S, APERTURE, about.reference)
    for number, light in enumerate(about.lights):
        levels = tuple(one.levels - 1 if one == light else 0 for one in about.lights)
        frame = simulator.capture(Settings(lights=levels, shutter_s=SHUTTER_S, aperture=APERTURE))
        images.add(f"i{number + 1}", frame.pixels, exposure, about.camera.gamma)
    names = list(images.images)
    sets = [*([name] for name in names), names]
    estimates = [estimate_pose(images, one, simulator.model, simulator.camera, seed_pose) for one in sets]
    return Story(simulator, images, estimates[:-1], estimates[-1])


def main(out: Annotated[Path, typer.Argument(help="The picture.")] = DEFAULT) -> None:
    """Take the images, estimate from each and from all, draw."""
    story = told()
    simulator, images, together = story.simulator, story.images, story.together
    assert together.pose is not None
    error = together.pose.error_to(simulator.true_pose)
    pixels = [image.pixels for image in images.images.values()]
    brightest = np.maximum.reduce(pixels)
    y, x = np.nonzero(brightest > LIT_GREY)
    top, left = max(y.min() - MARGIN_PX, 0), max(x.min() - MARGIN_PX, 0)
    crop = np.s_[top : y.max() + MARGIN_PX, left : x.max() + MARGIN_PX]
    small = [panel(one[crop], said(alone), PANEL_PX) for one, alone in zip(pixels, story.alone, strict=True)]
    overlay = draw_overlay(brightest, simulator.model, simulator.camera, together.pose)
    large = [
        panel(drawn(images.edge_map(list(images.images)))[crop], "together: merged edges", 2 * PANEL_PX),
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
