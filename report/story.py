"""The session iteration by iteration, as what the page shows of each step."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

from markupsafe import Markup

from bridge.result_file import SettingsRecord, StepRecord
from numerics.arrays import Grey
from report.lights import lights_svg
from report.scene import LightRecord
from report.strokes import Strokes
from report.words import angle, aperture, length, percent, pixels, shutter

MOST_SEGMENTS = 16  # of a light's bar; more are drawn as one
MOST_BARS = 8  # of lights, each with one of its own
FASTEST_S, SLOWEST_S = 1 / 1000, 1.0  # ends of the shutter's bar


@dataclass(frozen=True, eq=False)
class Picture:
    """An image of the session, or why there is none.

    Attributes
    ----------
    name : the image's id.
    pixels : grey, or None.
    edges : edge map of the set with this image, or None.
    problem : what is wrong, in a sentence; empty when the image is there.
    """

    name: str
    pixels: Grey | None
    problem: str = ""
    edges: Grey | None = None


@dataclass(frozen=True)
class LightBar:
    """A light's level: `fill` of `segments` lit, or a share of an unbroken bar where levels are many."""

    name: str
    text: str
    segments: int
    fill: int
    share: float


@dataclass(frozen=True)
class StepView:
    """What the page shows of one step."""

    number: int
    picture: Picture
    decision: str
    settings: str
    bars: tuple[LightBar, ...]
    shutter: str
    shutter_share: float
    aperture: str
    iris: float
    qualitative: str
    reason: str
    numbers: tuple[tuple[str, str], ...]
    strokes: Strokes | None
    has_pose: bool
    hold: int | None
    rig: Markup


def step_view(
    step: StepRecord,
    number: int,
    picture: Picture,
    strokes: Strokes | None,
    lights: Sequence[LightRecord],
    steps: Sequence[StepRecord],
) -> StepView:
    """What the page shows of a step; `steps` are all of them, for the scales of its bars."""
    settings = step.settings or SettingsRecord()
    widest = min((s.settings.aperture for s in steps if s.settings and s.settings.aperture), default=None)
    iris = widest / settings.aperture if widest and settings.aperture else 0.0
    return StepView(
        number=step.iteration or number,
        picture=picture,
        decision=step.decision or "",
        settings=step.settings_words or "settings not recorded",
        bars=_bars(settings, lights, steps),
        shutter=shutter(settings.shutter_s) if settings.shutter_s else "",
        shutter_share=_shutter_share(settings.shutter_s),
        aperture=aperture(settings.aperture) if settings.aperture else "",
        iris=iris,
        qualitative=step.qualitative or "",
        reason=step.reason or "",
        numbers=tuple(_numbers(step)),
        strokes=strokes,
        has_pose=step.pose is not None,
        hold=step.hold,
        rig=Markup(lights_svg(step.settings, lights)),
    )


def _numbers(step: StepRecord) -> list[tuple[str, str]]:
    rows = [("RMS error", pixels(step.rms_px))]
    if step.merit is not None and step.pose is not None:  # without a pose it is only "worst"
        rows.append(("Merit", pixels(step.merit)))
    if step.supported_fraction is not None:
        rows.append(("Lines supported", percent(step.supported_fraction)))
    if step.set_size is not None:
        rows.append(("Images in the set", str(step.set_size)))
    if step.error is not None:
        off = f"{length(step.error.translation_m)}, {angle(step.error.rotation_deg)}"
        rows.append(("Off the true pose", off))
    return rows


def _bars(
    settings: SettingsRecord, lights: Sequence[LightRecord], steps: Sequence[StepRecord]
) -> tuple[LightBar, ...]:
    seen = max((level for s in steps if s.settings for level in s.settings.lights), default=1.0)
    bars = []
    for number, level in enumerate(settings.lights):
        levels = lights[number].levels if number < len(lights) else None
        if levels == 1:  # it cannot be switched
            bars.append(LightBar(_light_name(number, lights), "on", 1, 1, 1.0))
            continue
        top = levels - 1 if levels is not None else max(1.0, seen)
        text = f"{level:g}/{top:g}" if levels is not None else f"{level:g}"
        segments = int(top) if top <= MOST_SEGMENTS and level == int(level) else 0
        share = min(1.0, max(0.0, level / top))
        bars.append(LightBar(_light_name(number, lights), text, segments, int(level), share))
    return tuple(bars) if len(bars) <= MOST_BARS else _grouped(bars)


def _grouped(bars: Sequence[LightBar]) -> tuple[LightBar, ...]:
    """One bar for lights beside each other that give the same share of their light."""
    grouped = []
    for share, of_one in groupby(bars, lambda bar: bar.share):
        first, *others = of_one
        name = f"{first.name} – {others[-1].name}" if others else first.name
        grouped.append(LightBar(name, percent(share) if others else first.text, 0, 0, share))
    return tuple(grouped)


def _light_name(number: int, lights: Sequence[LightRecord]) -> str:
    """Name of a light, or its number from 1 where it has none."""
    name = lights[number].name if number < len(lights) else None
    return name or f"light {number + 1}"


def _shutter_share(value_s: float | None) -> float:
    if value_s is None or value_s <= 0:
        return 0.0
    share = math.log(value_s / FASTEST_S) / math.log(SLOWEST_S / FASTEST_S)
    return min(1.0, max(0.03, share))
