"""Light conditions for benchmarks: recorded stacks under another sun, and simulated scenarios."""

import re
from pathlib import Path

HARD_BLUR = "defocus_sigma_px = 4.0\nmotion_px_per_s = [240.0, 160.0]\n"
"""`[camera]` keys of the hard half of the conditions: blur at the widest aperture, motion in the image."""
HARD_POWER = 0.25
"""Light power of the hard half."""


def stack_under_sun(folder: Path, sun: float, hard: bool, scratch: Path) -> Path:
    """Copy a basis stack with another `ambient_scale` and, when `hard`, blur and weak lights.

    Images and model are linked, not copied.

    Parameters
    ----------
    folder
        Stack folder of kind ``basis``.
    sun
        Multiplies the ambient image; 0 is eclipse.
    hard
        Defocus, motion blur and a quarter of the light; otherwise none of them.
    scratch
        Where the new folder is made.
    """
    copy = scratch / f"{folder.name}-{'hard' if hard else 'mild'}-{sun:g}"
    copy.mkdir()
    for file in folder.resolve().iterdir():
        if file.name != "stack.toml":
            (copy / file.name).symlink_to(file)
    text = (folder / "stack.toml").read_text()
    text = re.sub(r"(?m)^(ambient_scale|power|defocus_sigma_px|motion_px_per_s)\s*=.*\n", "", text)
    text = f"ambient_scale = {sun}\n" + text
    power = HARD_POWER if hard else 1.0
    text = text.replace("[[lights]]\n", f"[[lights]]\npower = {power}\n")
    if hard:
        text = text.replace("[camera]\n", "[camera]\n" + HARD_BLUR)
    (copy / "stack.toml").write_text(text)
    return copy


SUNS = {
    "front": "angle_deg = [10.0, 30.0]\n",
    "side": "angle_deg = [45.0, 65.0]\n",
    "grazing": "angle_deg = [80.0, 95.0]\n",
    "back-lit": "angle_deg = [130.0, 165.0]\n",
    "above": "angle_deg = [40.0, 60.0]\nazimuth_deg = [-100.0, -80.0]\n",
}
"""Five sun directions, as the keys of a scenario's `[sun]`."""

TEXTURED = '[background]\nkind = "clutter"\n'


def sun_scenarios(scratch: Path) -> dict[str, Path]:
    """Write a scenario for each sun direction in space and before a textured background; files by name."""
    files = {}
    for sun, keys in SUNS.items():
        for behind, table in {"space": "", "textured": TEXTURED}.items():
            name = f"{sun}, {behind}"
            files[name] = scratch / f"{sun}-{behind}.toml"
            files[name].write_text(f"ambient_scale = 4.0\n[sun]\n{keys}{table}")
    return files


def simulated_conditions(sun: float, hard: bool, scratch: Path) -> Path:
    """Write the scenario of a sun's strength, mild or hard its file."""
    file = scratch / f"{'hard' if hard else 'mild'}-{sun:g}.toml"
    text = f"ambient_scale = {sun}\n"
    if hard:
        text += f"light_power = {HARD_POWER}\n[camera]\n{HARD_BLUR}"
    file.write_text(text)
    return file
