"""Where the light of an image came from: the lights around the camera, each as bright as it was."""

import math
from collections.abc import Sequence
from html import escape
from itertools import combinations

from bridge.result_file import SettingsRecord
from report.scene import LightRecord

WIDTH, HEIGHT = 120, 84
LAMP_R, LEAST_R, MARGIN = 9.0, 2.0, 14.0
CAMERA = '<rect class="body" x="-13" y="-9" width="26" height="18" rx="3"/><circle class="lens" r="6"/>'
"""All is drawn as the camera sees it: x right, y down."""


def lights_svg(settings: SettingsRecord | None, lights: Sequence[LightRecord]) -> str:
    """The diagram as SVG; empty where the place of a light is not known, or no level was recorded.

    Parameters
    ----------
    settings : one level per light.
    lights : with positions in the camera frame, m; the distance along the line of sight is not shown.
    """
    if settings is None or not lights or len(settings.lights) != len(lights):
        return ""
    placed = [light.position for light in lights if light.position is not None]
    if len(placed) != len(lights):
        return ""
    reach = max(max(abs(x) / (WIDTH / 2 - MARGIN), abs(y) / (HEIGHT / 2 - MARGIN)) for x, y, _ in placed)
    if reach == 0:
        return ""
    middles = [(x / reach, y / reach) for x, y, _ in placed]
    apart = [math.dist(*pair) for pair in combinations(set(middles), 2)]
    radius = min([LAMP_R, *(max(LEAST_R, distance / 2) for distance in apart)])
    lamps = []
    for light, level, (x, y) in zip(lights, settings.lights, middles, strict=True):
        top = max((light.levels or 2) - 1, 1)
        share = min(1.0, max(0.0, level / top)) if light.levels != 1 else 1.0
        title = escape(f"{light.name or 'light'}: {level:g} of {top}")
        lamps.append(
            f'<g transform="translate({x:.1f} {y:.1f})"><title>{title}</title>'
            f'<circle class="lamp" r="{radius:.3g}"/>'
            f'<circle class="lit" r="{radius:.3g}" fill-opacity="{share:.2f}"/></g>'
        )
    said = ", ".join(
        f"{light.name or 'light'} {level:g}" for light, level in zip(lights, settings.lights, strict=True)
    )
    return (
        f'<svg class="rig" viewBox="{-WIDTH / 2:g} {-HEIGHT / 2:g} {WIDTH} {HEIGHT}" role="img"'
        f' aria-label="Lights around the camera: {escape(said)}">{CAMERA}{"".join(lamps)}</svg>'
    )
