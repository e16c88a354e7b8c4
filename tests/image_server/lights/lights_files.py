"""Lights files for the tests."""

from pathlib import Path

LIGHTS = """
device = "{device}"
protocol = "{protocol}"
settle_s = 0.0
dark_after_s = {dark_after_s}

[[lights]]
name = "left"
channels = [1]

[[lights]]
name = "right"
channels = [2, 3]
levels = 3
values = [0, 10, 200]
"""


def lights_file(folder: Path, device: str, protocol: str, dark_after_s: float = 0.0) -> Path:
    """Write a lights file of two lights on three channels."""
    file = folder / "lights.toml"
    file.write_text(LIGHTS.format(device=device, protocol=protocol, dark_after_s=dark_after_s))
    return file


def until(condition: object, within_s: float = 60.0) -> bool:
    """Whether a condition (a callable) becomes true in time."""
    import time

    assert callable(condition)
    deadline = time.monotonic() + within_s
    while not condition():
        if time.monotonic() > deadline:
            return False
        time.sleep(0.01)
    return True
