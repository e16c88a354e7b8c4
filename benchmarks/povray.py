"""The simulator's scenes rendered by POV-Ray, an independent ray tracer.

POV-Ray's axes are x right, y up, z forward (left-handed): a point of the camera frame keeps x and z and turns
its y round. Lengths are written in mm, because POV-Ray starts its shadow rays 0.001 units off a surface.
"""

import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from bridge.errors import DeviceError
from geometry.camera import Camera
from image_server.simulator.scene import Scene
from image_server.simulator.texture import ALBEDO
from numerics.arrays import Field, Floats

MM = 1000.0
FADE_MM = 5.0
"""A light of fade power 2 shines as 2 / (1 + (d / fade)²): this near, the 1 is nothing at any target."""
FAR_MM = 1e7
DEADLINE_S = 900.0
FULL_SCALE_16 = 65535.0


def available() -> bool:
    """Whether POV-Ray is installed."""
    return shutil.which("povray") is not None


def point_light(position: Floats, strength: float, aim: Floats | None = None, power: float = 0.0) -> str:
    """A light at a position (m) that gives a white face 1 m away the radiance `strength`.

    With `aim`, a spotlight whose intensity falls as cosine^power from it.
    """
    spot = ""
    if aim is not None:
        spot = f" spotlight point_at {vector(MM * (position + aim))}"
        spot += f" radius 89.9999 falloff 90 tightness {power:.8g}"
    return _near_light(position, strength, spot)


def spotlight(position: Floats, at: Floats, strength: float, beam_deg: float) -> str:
    """A point light aimed at a point; its beam is even to half of `beam_deg` (half angle) and ends there."""
    spot = f" spotlight point_at {vector(MM * at)} radius {beam_deg / 2:g} falloff {beam_deg:g}"
    return _near_light(position, strength, spot)


def _near_light(position: Floats, strength: float, spot: str) -> str:
    colour = strength * MM**2 / (2 * FADE_MM**2)
    return (
        f"light_source {{ {vector(MM * position)} color rgb {colour:.8g}{spot}"
        f" fade_distance {FADE_MM:g} fade_power 2 }}"
    )


def far_light(direction: Floats, strength: float) -> str:
    """Parallel light from a direction; a white face turned to it has the radiance `strength`."""
    return (
        f"light_source {{ {vector(FAR_MM * direction)} color rgb {strength:.8g}"
        f" parallel point_at <0, 0, 0> }}"
    )


def rendered(scene: Scene, camera: Camera, lights: Sequence[str], samples: int, folder: Path) -> Field:
    """A scene of the simulator, see `ray_traced`.

    Every face scatters evenly with its own albedo; textures and mirrors stay out.
    """
    return ray_traced([*lights, *_meshes(scene)], camera, samples, folder)


def ray_traced(objects: Sequence[str], camera: Camera, samples: int, folder: Path) -> Field:
    """Linear radiance (H, W) float32, `samples`² rays a pixel, no clipping below 1.

    Parameters
    ----------
    objects : lights and things in POV-Ray's language, its axes, mm.

    Raises
    ------
    DeviceError : POV-Ray failed or took too long.
    """
    source, image = folder / "scene.pov", folder / "scene.png"
    source.write_text("\n".join([*_head(camera), *objects]) + "\n")
    command = [
        "povray", f"+I{source}", f"+O{image}", f"+W{camera.width}", f"+H{camera.height}", "+FN16",
        "File_Gamma=1.0", "+AM1", "+A0.0", f"+R{samples}", "-J", "-D", "-GA",
    ]  # fmt: skip
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=DEADLINE_S, check=False)
    except subprocess.TimeoutExpired:
        raise DeviceError(f"povray did not end within {DEADLINE_S:g} s.", f"Its scene is {source}.") from None
    if done.returncode != 0:
        raise DeviceError(f"povray failed: {done.stderr[-300:]}", f"Its scene is {source}.")
    pixels = cv2.imread(str(image), cv2.IMREAD_UNCHANGED)
    if pixels is None or pixels.dtype != np.uint16:
        raise DeviceError(f"povray wrote no 16-bit image to {image}.")
    return np.asarray(pixels[..., 0] / np.float32(FULL_SCALE_16), dtype=np.float32)


def _head(camera: Camera) -> list[str]:
    return [
        "#version 3.7;",
        "global_settings { assumed_gamma 1.0 ambient_light rgb 0 }",
        "camera { perspective location <0, 0, 0> direction <0, 0, 1>"
        f" right <{camera.width / camera.fx:.10g}, 0, 0> up <0, {camera.height / camera.fy:.10g}, 0> }}",
    ]


def _meshes(scene: Scene) -> list[str]:
    return [
        mesh(
            scene.triangles[scene.face == face],
            f"pigment {{ color rgb {scene.surfaces[face, ALBEDO]:.8g} }}"
            " finish { ambient 0 emission 0 diffuse 1 }",
        )
        for face in np.unique(scene.face)
    ]


def mesh(triangles: Floats, look: str) -> str:
    """Triangles (T, 3, 3), metres in the camera frame, with pigment, normal and finish."""
    corners = MM * triangles
    parts = " ".join(f"triangle {{ {', '.join(map(vector, triangle))} }}" for triangle in corners)
    return f"mesh {{ {parts} {look} }}"


def vector(point: Floats) -> str:
    """A point of the camera frame in POV-Ray's axes."""
    return f"<{point[0]:.9g}, {-point[1]:.9g}, {point[2]:.9g}>"
