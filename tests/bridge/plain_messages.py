"""What is said on the wire, as plain values: a device, its settings, and the header of a frame."""

from typing import Any

SETTINGS: dict[str, Any] = {"lights": [0, 7, 3], "shutter_s": 0.01667, "aperture": 4.0}
POSE = {"rotation_vector": [0.1, 0.2, 0.3], "translation": [0, 0, 1]}
CAMERA = {"width": 640, "height": 480, "fx": 700.0, "fy": 700.0, "cx": 319.5, "cy": 239.5}
DESCRIBE: dict[str, Any] = {
    "device": "simulator",
    "lights": [{"name": "left", "levels": 8, "position": [0, 0, 0], "power": 1.0}],
    "shutters_s": [0.01],
    "apertures": [4.0],
    "camera": CAMERA,
    "target": {"model": "/m/cube.cao", "unit": "mm", "seed_pose": POSE},
    "events": "ipc:///tmp/e",
}
CAPTURED = {
    "requested": SETTINGS,
    "applied": SETTINGS,
    "verified": True,
    "sequence": 1,
    "timestamp": 1.0,
    "devices": {"camera": "c"},
    "sha256": "0" * 64,
}
