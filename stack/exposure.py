"""The law of exposure and of light levels: what settings do to the signal."""

import math
from collections.abc import Sequence

from bridge.messages import SETTING_TOLERANCE, LightDescription, ReferenceExposure, Settings

SHUTTERS_S = (1 / 240, 1 / 120, 1 / 60, 1 / 30, 1 / 15)
"""Shutters where a stack or scenario names none: the five of the paper's testbed, in steps of one stop."""
APERTURES = (2.8, 4.0, 5.6)
"""f-numbers where none are named: the three of the paper's testbed, in steps of one stop."""
REFERENCE = ReferenceExposure()
"""The exposure that counts as 1, unless a device describes another."""
WHITE = 255.0
"""Grey value of full scale, 8 bits."""
FULL_SCALE_16 = 65535.0
"""Value of the signal 1 in a linear 16-bit image."""


def relative_exposure(shutter_s: float, aperture: float, reference: ReferenceExposure = REFERENCE) -> float:
    """Light gathered relative to the reference: in proportion to shutter_s / aperture²."""
    return (shutter_s / aperture**2) / (reference.shutter_s / reference.aperture**2)


def level_fraction(level: int, levels: int) -> float:
    """Share of full power of a level; a light with one level is on."""
    return 1.0 if levels == 1 else level / (levels - 1)


def light_powers(lights: Sequence[LightDescription], levels: Sequence[int]) -> list[float]:
    """Power of each light at its level, 1 where a light of power 1 is full on."""
    return [
        light.power * level_fraction(level, light.levels) for light, level in zip(lights, levels, strict=True)
    ]


def full_levels(lights: Sequence[LightDescription], only: int | None = None) -> tuple[int, ...]:
    """Levels with every light full on, or only the one of that index, the others off."""
    return tuple(light.levels - 1 if only in (None, index) else 0 for index, light in enumerate(lights))


def same_value(a: float, b: float) -> bool:
    """Whether two values of a setting mean the same one."""
    return math.isclose(a, b, rel_tol=SETTING_TOLERANCE)


def in_words(settings: Settings) -> str:
    """Settings on one line."""
    text = f"lights {list(settings.lights)}, {settings.shutter_s:g} s, f/{settings.aperture:g}"
    if settings.focal_length_mm is not None:
        text += f", {settings.focal_length_mm:g} mm"
    if settings.focus_m is not None:
        text += f", focus {settings.focus_m:g} m"
    return text
