"""What the mock servers answer unasked: simple enough to predict, plausible enough to control."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bridge.messages import (
    CameraDescription,
    Describe,
    LightDescription,
    PoseMessage,
    Settings,
    TargetDescription,
)
from stack.exposure import APERTURES, SHUTTERS_S, WHITE, light_powers, relative_exposure

TRUE_POSE = PoseMessage(rotation_vector=(0.1, -0.2, 0.05), translation=(0.02, 0.01, 0.6))
LINES = 12
DARK = 8 / WHITE
AMBIENT = 0.02
"""Linear grey of the target at the reference exposure with all lights off."""
LIT = 0.5
"""What all lights at full level add to it."""


def describe(events: str | None = None) -> Describe:
    """The testbed of the paper: 3 lights × 8 levels, 5 shutters × 3 apertures."""
    return Describe(
        device="mock",
        lights=(
            LightDescription(name="left", levels=8, position=(-0.3, 0.0, 0.0)),
            LightDescription(name="right", levels=8, position=(0.3, 0.0, 0.0)),
            LightDescription(name="top", levels=8, position=(0.0, -0.3, 0.0)),
        ),
        shutters_s=SHUTTERS_S,
        apertures=APERTURES,
        camera=CameraDescription(width=64, height=48, fx=80.0, fy=80.0, cx=31.5, cy=23.5),
        target=TargetDescription(model="/mock/cube.cao", seed_pose=TRUE_POSE),
        movable=True,
        events=events,
    )


def brightness(settings: Settings, device: Describe) -> float:
    """Linear grey of the target, 1 at full scale, not clipped."""
    exposure = relative_exposure(settings.shutter_s, settings.aperture, device.reference)
    powers = light_powers(device.lights, settings.lights)
    return exposure * (AMBIENT + LIT * sum(powers) / max(len(powers), 1))


def frame(settings: Settings, device: Describe) -> NDArray[np.uint8]:
    """An image of a bright square on a dark ground, (H, W)."""
    camera = device.camera
    height, width = (48, 64) if camera is None else (camera.height, camera.width)
    pixels = np.zeros((height, width), np.uint8)
    grey = round(WHITE * min(brightness(settings, device), 1.0))
    pixels[height // 4 : 3 * height // 4, width // 4 : 3 * width // 4] = grey
    return pixels


def statistics(settings: Settings, device: Describe) -> dict[str, Any]:
    """Statistics of a target whose linear greys are spread evenly from 0.2 to 1.8 × its brightness."""
    mean = brightness(settings, device)
    low, high = 0.2 * mean, 1.8 * mean

    def fraction_below(grey: float) -> float:
        return min(max((grey - low) / (high - low), 0.0), 1.0)

    def percentile(p: float) -> float:
        return min(low + p * (high - low), 1.0)

    region: dict[str, Any] = {
        "mean": min(mean, 1.0),
        "p05": percentile(0.05),
        "p50": percentile(0.5),
        "p95": percentile(0.95),
        "dark_fraction": fraction_below(DARK),
        "saturated_fraction": 1 - fraction_below(250 / WHITE),
        "sharpness": 0.5,
        "noise": 0.004,
    }
    return {**region, "blur_px": 0.8 + 2.0 * settings.shutter_s / (1 / 15), "frame": region}


def worth(stats: dict[str, Any]) -> float:
    """How much an image tells, from 0 (black or white) to 1."""
    return float((1 - stats["dark_fraction"]) * (1 - stats["saturated_fraction"]))


def estimate(images: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """Estimate from images by name and statistics; its error falls as the set grows."""
    told = sum(worth(stats) for stats in images.values())
    seconds = {"edges": 0.001, "linking": 0.001, "matching": 0.002, "refinement": 0.001}
    if told < 0.1:
        return {
            "pose": None,
            "covariance": None,
            "rms_px": None,
            "uncertainty": None,
            "supported_fraction": 0.0,
            "score": 0.0,
            "ambiguity": 1.0,
            "lines": [],
            "rivals": [],
            "segments": 0,
            "seconds": seconds,
        }
    rms_px = 0.2 + 0.8 / told
    translation_sd = 0.003 / math.sqrt(told)
    supported = 1 - 0.5 * math.exp(-told)
    variance = [(0.5 * translation_sd) ** 2] * 3 + [translation_sd**2] * 3
    names = list(images)
    return {
        "pose": {
            "rotation_vector": list(TRUE_POSE.rotation_vector),
            "translation": list(TRUE_POSE.translation),
        },
        "covariance": np.diag(variance).tolist(),
        "rms_px": rms_px,
        "uncertainty": translation_sd / TRUE_POSE.translation[2],
        "supported_fraction": supported,
        "score": min(0.5 + 0.1 * told, 0.95),
        "ambiguity": 0.5 * math.exp(-told),
        "lines": [
            {
                "line": line,
                "visible_px": 20.0,
                "support": 0.9 if line < round(LINES * supported) else 0.1,
                "rms_px": rms_px,
                "image": names[line % len(names)],
            }
            for line in range(LINES)
        ],
        "rivals": [],
        "segments": 30 * len(images),
        "seconds": seconds,
    }
