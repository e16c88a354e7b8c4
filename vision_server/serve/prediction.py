"""What settings would add to a task's best pose: the set's images and the device put into numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import msgspec
import numpy as np

from bridge.errors import BadInput
from bridge.messages import CameraDescription, Settings
from bridge.vision_messages import FoundSettings, Gain, PredictArgs, PredictResult
from geometry.pose import Pose
from numerics.arrays import Floats, Ints
from stack.exposure import light_powers
from vision_server.pose.observation import PoseProblem, observe
from vision_server.prediction.information import Candidates, Forecast, Sensor, View, blur_inputs
from vision_server.prediction.response import LitImage
from vision_server.prediction.search import climb
from vision_server.prediction.straying import line_scatter
from vision_server.serve.task import PoseTask
from vision_server.trust.support import CAP_PX, support_of

SPACING_PX = 3.0  # of samples: a third of what an estimate looks at
LIGHT_STEPS = 1 / 4, 1 / 8  # of a light's levels, that search turns it by; chosen by hand


def predict(task: PoseTask, args: PredictArgs) -> PredictResult:
    """Answer the operation `predict`."""
    images = args.images or tuple(task.images.images)
    task.images.check(images)
    found = task.estimate_of(images) if images else None
    known = None if found is None or found.pose is None else forecast(task, images, found.pose)
    task.expect(found)
    if known is None:
        return PredictResult(gains=None)
    bits, lines = known.gains(numbers(task, args.settings))
    gains = tuple(Gain(bits=b, line=max(n, 0)) for b, n in zip(bits.tolist(), lines.tolist(), strict=True))
    more: tuple[FoundSettings, ...] = ()
    if args.search:
        more = _searched(task, known, args.settings, int(np.argmax(bits)))[: args.search]
    return PredictResult(gains=gains, found=more)


def forecast(task: PoseTask, images: Sequence[str], pose: Pose) -> Forecast:
    """What these images (not none) tell of images to come."""
    taken, lit = lit_images(task, images)
    describe = task.describe
    camera = describe.camera or CameraDescription(width=1, height=1, fx=1.0, fy=1.0, cx=0.0, cy=0.0)
    sensor = Sensor(camera.full_well_e / task.gain, camera.read_noise_e, task.gamma)
    positions = [None if light.position is None else np.array(light.position) for light in describe.lights]
    view = View(task.model, task.camera, pose, *_lines_seen(task, images, pose))
    return Forecast(view, lit, taken, positions, sensor, old=_under_another_sun(task, images))


def lit_images(task: PoseTask, images: Sequence[str]) -> tuple[Candidates, list[LitImage]]:
    """What images of the scene were taken under, and they as readings of brightness, lights as `outputs`."""
    taken = numbers(task, [task.applied[name] for name in images], images)
    lit = [
        replace(task.reading(name), lights=lights) for name, lights in zip(images, taken.lights, strict=True)
    ]
    return taken, lit


def _searched(
    task: PoseTask, known: Forecast, given: Sequence[Settings], best: int
) -> tuple[FoundSettings, ...]:
    """What search finds from the best of the given settings; a light that is off in all of them stays off."""
    describe, start = task.describe, given[best]
    shutters, apertures = sorted(describe.shutters_s), sorted(describe.apertures)
    lit = [any(levels) for levels in zip(*(one.lights for one in given), strict=True)]
    counts = [light.levels for light in describe.lights]
    steps = [_steps(count) if on else () for count, on in zip(counts, lit, strict=True)]

    def settings(knobs: Ints) -> Settings:
        *levels, shutter, aperture = knobs.tolist()
        return msgspec.structs.replace(
            start, lights=tuple(levels), shutter_s=shutters[shutter], aperture=apertures[aperture]
        )

    def bits(knobs: Ints) -> Floats:
        return known.gains(numbers(task, [settings(row) for row in knobs]))[0]

    here = (_nearest(shutters, start.shutter_s), _nearest(apertures, start.aperture))
    tops = [*(count - 1 for count in counts), len(shutters) - 1, len(apertures) - 1]
    looked, _ = climb(bits, np.array([*start.lights, *here]), tops, [*steps, (-1, 1), (-1, 1)])
    found = [settings(row) for row in looked]
    gains, lines = known.gains(numbers(task, found))
    return tuple(
        FoundSettings(settings=one, bits=b, line=max(n, 0))
        for one, b, n in zip(found, gains.tolist(), lines.tolist(), strict=True)
    )


def _steps(levels: int) -> tuple[int, ...]:
    sizes = {max(1, round(share * levels)) for share in LIGHT_STEPS}
    return tuple(sorted({sign * size for size in sizes for sign in (-1, 1)})) if levels > 1 else ()


def _nearest(offered: Sequence[float], value: float) -> int:
    return int(np.argmin(np.abs(np.array(offered) - value)))


def _lines_seen(task: PoseTask, images: Sequence[str], pose: Pose) -> tuple[Floats, Floats]:
    """Share of each model line that the images show at a pose, (L,), and how far its edges stray, (K, L)."""
    problem = PoseProblem.at_scale(task.images.gradients(images), task.model, task.camera)
    seen = observe(problem, pose, CAP_PX, SPACING_PX, pulls=False)
    support = np.zeros(len(task.model.lines))
    if len(seen.samples.line):
        for line in support_of(seen, images).lines:
            support[line.line] = line.support
    return support, line_scatter(seen)


def _under_another_sun(task: PoseTask, images: Sequence[str]) -> int:
    """How many of the images, but for the last, tell nothing of the sun of now, or of what is in its way."""
    suns = [one.before for one in task.happened if one.cause in ("sun_changed", "in_the_way")]
    return min(sum(any(image in before for before in suns) for image in images), len(images) - 1)


def outputs(task: PoseTask, settings: Settings, image: str | None = None) -> Floats:
    """Light outputs (L,) that settings gave in an image, or give now, by what has happened to the lights."""
    powers = np.array(light_powers(task.describe.lights, settings.lights))
    for one in task.happened:
        if image in one.before:
            continue
        if one.cause == "light_dead":
            powers[list(one.lights)] = 0.0
        elif one.cause == "lights_swapped":
            powers[list(one.lights)] = powers[list(one.lights[::-1])]
    return powers


def numbers(task: PoseTask, settings: Sequence[Settings], images: Sequence[str] = ()) -> Candidates:
    """Settings as exposures, light outputs and what blurs on a task's device, of images to come or these.

    Raises
    ------
    BadInput
        Other than one level for each of its lights.
    """
    describe = task.describe
    for one in settings:
        if len(one.lights) != len(describe.lights):
            raise BadInput(
                f"Settings give {len(one.lights)} light levels,"
                f" and {len(describe.lights)} lights are described.",
                "Give one level per light."
                if describe.lights
                else "Lights are known from an image server alone. Without: lights = [], in `add`, too.",
            )
    shutter = np.array([one.shutter_s for one in settings])
    aperture = np.array([one.aperture for one in settings])
    names = images or (None,) * len(settings)
    lights = [outputs(task, one, name) for one, name in zip(settings, names, strict=True)]
    return Candidates(
        exposure=np.array([task.exposure(one) for one in settings]),
        lights=np.array(lights).reshape(len(settings), len(describe.lights)),
        blur=blur_inputs(shutter, aperture, min(describe.apertures), describe.reference.shutter_s),
    )
