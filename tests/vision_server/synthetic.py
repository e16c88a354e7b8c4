"""Pictures of a cuboid with known truth: plain faces, area-sampled, blurred, with noise and a tone curve."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from geometry.camera import Camera
from geometry.model import Model, load_model
from geometry.pose import Pose
from numerics.arrays import Field, Floats, Grey
from vision_server.image_set import ImageSet

FINER = 6  # samples across a pixel
CAMERA = Camera(320, 240, 420.0, 420.0, 159.5, 119.5)
POSE = Pose(np.array([0.55, 0.70, 0.10]), np.array([0.004, -0.003, 0.42]))
SIZE_M = (0.10, 0.08, 0.06)


def cuboid(folder: Path) -> Model:
    """A closed cuboid read from a .cao file, centred on its origin."""
    x, y, z = (0.5 * side for side in SIZE_M)
    corners = [
        (-x, -y, -z),
        (x, -y, -z),
        (x, y, -z),
        (-x, y, -z),
        (-x, -y, z),
        (x, -y, z),
        (x, y, z),
        (-x, y, z),
    ]
    faces = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    lines = ["V1", "8", *(" ".join(map(str, corner)) for corner in corners), "0", "0", "6"]
    lines += ["4 " + " ".join(map(str, face)) for face in faces] + ["0", "0"]
    path = folder / "cuboid.cao"
    path.write_text("\n".join(lines) + "\n")
    return load_model(path)


def lines_alone(model: Model, folder: Path) -> Path:
    """A .cao file of a model's lines without its faces."""
    corners = [" ".join(f"{x:.9g}" for x in point) for point in model.vertices]
    lines = [f"{one} {other}" for one, other in model.lines.tolist()]
    path = folder / f"{model.name}-lines.cao"
    path.write_text("\n".join(["V1", str(len(corners)), *corners, str(len(lines)), *lines, *"0000"]) + "\n")
    return path


def boxes(folder: Path, ends: Sequence[tuple[Floats, Floats]]) -> Model:
    """Boxes between two opposite corners each, (3,) m, read from a .cao file."""
    points: list[Floats] = []
    faces: list[list[int]] = []
    for first, (low, high) in enumerate(ends):
        corner = np.array([(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))])
        points += list(np.where(corner == 0, low, high))
        around = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
        faces += [[8 * first + number for number in face] for face in around]
    lines = ["V1", str(len(points)), *(" ".join(f"{x:.6f}" for x in point) for point in points)]
    lines += ["0", "0", str(len(faces)), *("4 " + " ".join(map(str, face)) for face in faces), "0", "0"]
    path = folder / "boxes.cao"
    path.write_text("\n".join(lines) + "\n")
    return load_model(path)


def linear_picture(
    model: Model,
    camera: Camera,
    pose: Pose,
    greys: tuple[float, ...] | None = None,
    background: float = 0.08,
    blur_px: float = 0.7,
) -> Floats:
    """Linear intensity 0..1 (or more) of a convex model, (H, W): each visible face in its own grey."""
    picture = np.full((camera.height * FINER, camera.width * FINER), background, dtype=np.float32)
    points = pose.apply(model.vertices)
    normals = model.face_normals @ pose.matrix.T
    pixels = (camera.project(points) + 0.5) * FINER - 0.5
    for index, face in enumerate(model.faces):
        if normals[index] @ points[face[0]] < 0.0:
            grey = 0.25 + 0.11 * index if greys is None else greys[index]
            _fill(picture, pixels[face], float(grey))
    rows = picture.reshape(camera.height, FINER, -1).sum(axis=1)
    small = rows.reshape(camera.height, camera.width, FINER).sum(axis=2) / np.float32(FINER**2)
    return np.asarray(cv2.GaussianBlur(small, (0, 0), blur_px), dtype=np.float64)


def _fill(picture: Field, corners: Floats, value: float) -> None:
    """Give all pixels whose centre is inside a convex polygon a value."""
    low = np.maximum(np.floor(corners.min(axis=0)).astype(int), 0)
    high = np.minimum(np.ceil(corners.max(axis=0)).astype(int) + 1, picture.shape[::-1])
    y, x = (np.arange(low[k], high[k], dtype=np.float32) for k in (1, 0))
    left, right = np.ones((2, len(y), len(x)), dtype=bool)
    for ahead, corner in zip(np.roll(corners, -1, axis=0) - corners, corners, strict=True):
        down, across = ahead[0] * (y - corner[1])[:, None], ahead[1] * (x - corner[0])
        left &= down >= across
        right &= down <= across
    picture[low[1] : high[1], low[0] : high[0]][left | right] = value


def photographed(
    linear: Floats,
    exposure: float = 1.0,
    noise_sd_grey: float = 1.0,
    gamma: float = 1.0,
    seed: int = 0,
) -> Grey:
    """8-bit frame of linear intensity: exposed, with Gaussian noise, clipped, coded with 1/gamma."""
    rng = np.random.default_rng(seed)
    grey = 255.0 * linear * exposure + noise_sd_grey * rng.standard_normal(linear.shape)
    coded = 255.0 * (np.clip(grey, 0.0, 255.0) / 255.0) ** (1.0 / gamma)
    return np.asarray(np.round(coded), dtype=np.uint8)


def camera_file(path: Path, camera: Camera = CAMERA, **other: float) -> None:
    """A file with [camera], some of its values others than the camera's."""
    values = camera.to_dict() | other
    path.write_text("[camera]\n" + "".join(f"{key} = {value}\n" for key, value in values.items()))


def one_image(pixels: Grey, gamma: float = 1.0) -> ImageSet:
    """An image set of one frame, called i1."""
    images = ImageSet(pixels.shape[1], pixels.shape[0])
    images.add("i1", pixels, 1.0, gamma)
    return images
