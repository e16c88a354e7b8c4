"""Numbers as people say them: lengths, angles, shutters, settings in words."""

import math
from collections.abc import Sequence

from bridge.result_file import LightTold, SettingsRecord

NONE = "–"


def significant(value: float, digits: int = 2) -> str:
    """A number with so many significant digits, and no exponent where it can be helped."""
    if not math.isfinite(value):
        return "∞" if value > 0 else NONE
    if value == 0:
        return "0"
    magnitude = math.floor(math.log10(abs(value)))
    if magnitude < -4:
        return f"{value:.{digits - 1}e}"
    places = max(0, digits - 1 - magnitude)
    text = f"{value:.{places}f}"
    return text if abs(value) < 10**digits else f"{value:.0f}"


def length(metres: float | None, digits: int = 2) -> str:
    """A length in the unit that suits it, such as `0.12 mm` or `1.5 m`."""
    if metres is None:
        return NONE
    size = abs(metres)
    if size >= 1:
        return f"{significant(metres, max(digits, 3))} m"
    if size >= 1e-5 or size == 0:
        return f"{significant(metres * 1e3, digits)} mm"
    return f"{significant(metres * 1e6, digits)} µm"


def angle(degrees: float | None) -> str:
    """An angle, such as `0.031°`."""
    return NONE if degrees is None else f"{significant(degrees)}°"


def percent(fraction: float | None, digits: int = 2) -> str:
    """A fraction as a percentage."""
    return NONE if fraction is None else f"{significant(100 * fraction, digits)} %"


def pixels(value: float | None) -> str:
    """A length in the image."""
    if value is None:
        return NONE
    if 0 < abs(value) < 0.1:  # hundredths would say little
        return f"{significant(value)} px"
    return f"{value:.2f} px" if abs(value) < 100 else f"{value:.0f} px"


def seconds(value: float | None) -> str:
    """A duration."""
    if value is None:
        return NONE
    if value < 0.0995:
        return f"{significant(1000 * value)} ms"
    if value < 60:
        return f"{significant(value)} s" if value < 9.95 else f"{value:.0f} s"
    return f"{int(value // 60)} min {value % 60:.0f} s"


def shutter(value_s: float | None) -> str:
    """A shutter as photographers write it."""
    if value_s is None or value_s <= 0:
        return NONE
    if value_s < 0.3:
        return f"1/{round(1 / value_s)} s"
    return f"{significant(value_s)} s"


def aperture(f_number: float | None) -> str:
    """An aperture as photographers write it."""
    return NONE if f_number is None else f"f/{f_number:g}"


def settings(record: SettingsRecord, lights: Sequence[LightTold]) -> str:
    """As a session shows them: `left 7 right 0 top 0, 1/60 s, f/4`."""
    lit = " ".join(
        f"{light.name} {level:g}" for light, level in zip(lights, record.lights or (), strict=False)
    )
    return ", ".join(filter(None, (lit, shutter(record.shutter_s), aperture(record.aperture))))


def same_settings(one: SettingsRecord, other: SettingsRecord) -> bool:
    """Whether two records say the same, to the thousandth that devices tell."""
    return one.lights == other.lights and all(
        a is None or b is None or math.isclose(a, b, rel_tol=1e-3)
        for a, b in ((one.shutter_s, other.shutter_s), (one.aperture, other.aperture))
    )
