"""Small stack folders for the tests."""

from pathlib import Path

import cv2
import numpy as np

CAMERA = """
[camera]
width = 32
height = 24
fx = 40.0
fy = 40.0
cx = 15.5
cy = 11.5
read_noise_e = 0.0
full_well_e = 1e9
"""
TARGET = """
[target]
model = "box.cao"

[target.seed_pose]
rotation_vector = [0.1, 0.0, 0.0]
translation = [0.0, 0.0, 1.0]

[target.true_pose]
rotation_vector = [0.0, 0.0, 0.0]
translation = [0.0, 0.0, 1.0]
"""
BASIS = (
    'kind = "basis"\nambient = "sun.png"\nambient_scale = 2.0\n'
    + CAMERA
    + """
[[lights]]
name = "left"
levels = 8
radiance = "left.png"

[[lights]]
name = "right"
levels = 1
power = 0.5
radiance = "right.png"
"""
    + TARGET
)
FRAMES = (
    'kind = "frames"\n'
    + CAMERA
    + TARGET
    + """
[[frames]]
image = "a.png"
lights = [0, 7]
shutter_s = 0.0166667
aperture = 4.0

[[frames]]
image = "b.png"
lights = [7, 0]
shutter_s = 0.0333333
aperture = 5.6

[[frames]]
image = "c.png"
lights = [7, 0]
shutter_s = 0.0333333
aperture = 5.6
"""
)
LEVELS = {"left": 20000, "right": 10000, "sun": 3000}


def basis_stack(folder: Path, text: str = BASIS) -> Path:
    """Write a basis stack of flat images."""
    for name, level in LEVELS.items():
        cv2.imwrite(str(folder / f"{name}.png"), np.full((24, 32), level, np.uint16))
    return _with_text(folder, text)


def frames_stack(folder: Path, text: str = FRAMES) -> Path:
    """Write a frames stack of noise images."""
    for number, name in enumerate("abc"):
        image = np.random.default_rng(number).integers(0, 255, (24, 32), np.uint8)
        cv2.imwrite(str(folder / f"{name}.png"), image)
    return _with_text(folder, text)


def _with_text(folder: Path, text: str) -> Path:
    (folder / "box.cao").write_text("V1\n2\n0 0 0\n1 0 0\n1\n0 1\n")
    (folder / "stack.toml").write_text(text)
    return folder
