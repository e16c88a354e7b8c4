"""Boxes as they are on desks: rounded edges, print on every face, blurred by their motion.

The model of each is the sharp box. Rays are traced to the rounded one, each at a moment of the exposure.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from geometry.surface import Surface
from numerics.arrays import Floats, Ints
from numerics.kernels import kernel

SIDES_M = (0.06, 0.12)
ROUNDED = (0.01, 0.04)  # radius of the edges, as a share of the shortest side
FONT = cv2.FONT_HERSHEY_SIMPLEX
FRAMED = 0.25  # of the faces, with a frame printed near their edges
TEXELS = 192  # of a face, each way
FINER = 3  # rays across a pixel
AMBIENT, LIT, GLOSS, SHARPNESS = 0.25, 0.7, 0.08, 20.0
STEPS, NEAR_M = 60, 1e-6  # of a ray on its way to the surface, and what counts as there
CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64)
FACES = ([0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3])


class Box(NamedTuple):
    """A rounded box about the origin of its frame.

    Attributes
    ----------
    half : (3,), m.
    radius : of its edges, m.
    prints : (6, TEXELS, TEXELS), albedo of its faces at -x, +x, -y, +y, -z, +z.
    """

    half: Floats
    radius: float
    prints: Floats


def sharp(box: Box) -> Model:
    """Its model."""
    faces, none = [np.array(face) for face in FACES], np.empty((0, 2), np.int64)
    surface = Surface(CORNERS * box.half, faces, np.full(len(faces), -1), none, 0.01, 20.0)
    return Model.of_surface("box", surface)


def random_box(rng: np.random.Generator) -> Box:
    """Sides, rounding and print by chance."""
    half = 0.5 * rng.uniform(*SIDES_M, 3)
    radius = float(rng.uniform(*ROUNDED) * 2.0 * half.min())
    return Box(half, radius, np.stack([_print(rng) for _ in FACES]))


def _print(rng: np.random.Generator) -> Floats:
    """A face's albedo: a ground, now and then a frame near its edges, patches, lines and letters."""
    picture = np.full((TEXELS, TEXELS), rng.integers(64, 230), dtype=np.uint8)
    if rng.random() < FRAMED:
        inset, width = int(rng.uniform(0.01, 0.08) * TEXELS), int(rng.integers(1, 8))
        corner = TEXELS - 1 - inset
        cv2.rectangle(picture, (inset, inset), (corner, corner), int(rng.integers(25, 240)), width)
    for _ in range(int(rng.integers(3, 9))):
        points = rng.integers(0, TEXELS, (int(rng.integers(2, 6)), 1, 2)).astype(np.int32)
        if rng.random() < 0.5:
            cv2.fillPoly(picture, [points], int(rng.integers(25, 240)), cv2.LINE_AA)
        else:
            cv2.polylines(picture, [points], True, int(rng.integers(25, 240)), int(rng.integers(1, 5)))
    words = "".join(rng.choice(list("ABCDEFGHKMNPRSTVXYZ"), 5))
    at = (int(rng.integers(0, TEXELS // 2)), int(rng.integers(TEXELS // 4, TEXELS)))
    cv2.putText(picture, words, at, FONT, rng.uniform(0.5, 1.2), int(rng.integers(25, 240)), 2)
    return np.asarray(cv2.GaussianBlur(picture, (0, 0), 0.7) / 255.0)


def taken(box: Box, poses: Sequence[Pose], camera: Camera, lamp: Floats, behind: Floats) -> Floats:
    """Linear intensity (H, W), with the box at each pose for the same share of the exposure.

    Parameters
    ----------
    lamp : (3,), unit vector to the light, camera frame.
    behind : (H, W), what is behind the box.
    """
    centres = np.array([pose.translation for pose in poses])
    seen = np.vstack([camera.project(pose.apply(CORNERS * box.half)) for pose in poses])
    low = np.maximum(np.floor(seen.min(axis=0)) - 2, 0).astype(np.int64)
    high = np.minimum(np.ceil(seen.max(axis=0)) + 3, [camera.width, camera.height]).astype(np.int64)
    out = behind.copy()
    back = np.array([pose.matrix.T for pose in poses])
    eye, lit = -np.einsum("kij,kj->ki", back, centres), back @ lamp
    lens = np.array([camera.fx, camera.fy, camera.cx, camera.cy])
    _traced(box, back, centres, eye, lit, lens, np.r_[low, high], out)
    return out


@kernel()
def _outside(box: Box, p: Floats) -> float:
    """Distance (m) of a point from the rounded box."""
    half, radius = box.half, box.radius
    square, most = 0.0, -np.inf
    for k in range(3):
        q = abs(p[k]) - half[k] + radius
        square += max(q, 0.0) ** 2
        most = max(most, q)
    return math.sqrt(square) + min(most, 0.0) - radius


@kernel()
def _shade(box: Box, p: Floats, toward: Floats, lamp: Floats) -> float:
    """Radiance of a surface point; ray and lamp in the box's frame."""
    half, radius, prints = box.half, box.radius, box.prints
    face, normal, length = 0, np.zeros(3), 0.0
    for k in range(3):
        q = abs(p[k]) - half[k] + radius
        if q > abs(p[face]) - half[face] + radius:
            face = k
        normal[k] = max(q, 0.0) * (1.0 if p[k] > 0.0 else -1.0)
        length += normal[k] ** 2
    length = math.sqrt(length)
    u, v = (face + 1) % 3, (face + 2) % 3
    size = prints.shape[1] - 1
    x, y = 0.5 * (p[u] / half[u] + 1.0) * size, 0.5 * (p[v] / half[v] + 1.0) * size
    column, row = min(max(int(x), 0), size - 1), min(max(int(y), 0), size - 1)
    a, b = x - column, y - row
    side = prints[2 * face + (1 if p[face] > 0.0 else 0)]
    albedo = (1 - b) * ((1 - a) * side[row, column] + a * side[row, column + 1])
    albedo += b * ((1 - a) * side[row + 1, column] + a * side[row + 1, column + 1])
    facing, along, ahead = 0.0, 0.0, 0.0
    for k in range(3):
        facing += normal[k] / length * lamp[k]
        along += normal[k] / length * toward[k]
        ahead += lamp[k] * toward[k]
    mirrored = ahead - 2.0 * facing * along
    return float(albedo * (AMBIENT + LIT * max(0.0, facing)) + GLOSS * max(0.0, mirrored) ** SHARPNESS)


@kernel()
def _traced(
    box: Box, back: Floats, centres: Floats, eye: Floats, lit: Floats, lens: Floats, part: Ints, out: Floats
) -> None:
    """Draw the box over ``out``; FINER^2 rays a pixel take the poses in turn.

    Each pose as ``back`` into the box's frame, with eye and lamp there, and the box's centre in the camera's.
    No expression of whole arrays: each takes a second to compile.
    """
    half = box.half
    reach = math.sqrt(half[0] ** 2 + half[1] ** 2 + half[2] ** 2)
    count = len(back)
    toward, along, place = np.empty(3), np.empty(3), np.empty(3)
    for row in range(part[1], part[3]):
        for column in range(part[0], part[2]):
            total = 0.0
            for ray in range(FINER * FINER):
                k = (ray * 7 + row * 11 + column * 13 + row * column) % count
                x = column + (ray % FINER + 0.5) / FINER - 0.5
                y = row + (ray // FINER + 0.5) / FINER - 0.5
                toward[0], toward[1], toward[2] = (x - lens[2]) / lens[0], (y - lens[3]) / lens[1], 1.0
                length = math.sqrt(toward[0] ** 2 + toward[1] ** 2 + 1.0)
                far, away = 0.0, 0.0
                for i in range(3):
                    toward[i] /= length
                    far += toward[i] * centres[k, i]
                    away += centres[k, i] ** 2
                light = out[row, column]
                if away - far * far < reach * reach:
                    for i in range(3):
                        along[i] = (
                            back[k, i, 0] * toward[0] + back[k, i, 1] * toward[1] + back[k, i, 2] * toward[2]
                        )
                    passed = far - reach
                    for _ in range(STEPS):
                        for i in range(3):
                            place[i] = eye[k, i] + passed * along[i]
                        gap = _outside(box, place)
                        if gap < NEAR_M or passed > far + reach:
                            break
                        passed += gap
                    if passed <= far + reach:
                        for i in range(3):
                            place[i] = eye[k, i] + passed * along[i]
                        light = _shade(box, place, along, lit[k])
                total += light
            out[row, column] = total / (FINER * FINER)
