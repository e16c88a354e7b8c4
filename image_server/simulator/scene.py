"""A scene: the triangles of target and background in the camera frame, and how their faces look."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from geometry.rotation import euler_matrix, matrix_of
from image_server.simulator import texture
from image_server.simulator.material import TEXTURES, Appearance, Material, MaterialChanges
from image_server.simulator.scenario_tables import Background
from numerics.arrays import Floats, Ints

# Of the background; chosen by hand: duller and coarser than targets are.
WALL_MATERIAL = Material(
    albedo=0.3, texture="noise", size_m=0.12, contrast=0.6, grain=0.1, specular=0.02, roughness=0.7
)
BOX_MATERIAL = Material(
    albedo=0.45, texture="noise", size_m=0.03, contrast=0.5, grain=0.1, specular=0.03, roughness=0.6
)
BOX_FACES = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
BOX_SIZE = (0.12, 0.3)  # of the target's diameter
# Of an arm: how near the camera, of the target's range; how far aside, how long, of its diameter; how steep.
ARM_NEARER, ARM_ASIDE, ARM_LENGTH, ARM_LEAN = (0.55, 0.8), 0.2, 6.0, 0.3
TARGET = 0  # number of its part
OFFSET_STEP = 17.0  # of neighbouring numbers of faces, in sizes of the texture: nothing is repeated
WALL_MARGIN = 3.0  # the wall reaches this many frame widths, so that it also fills a tilted view


@dataclass(frozen=True, eq=False)
class Part:
    """Faces that share a frame in which their texture is fixed.

    Attributes
    ----------
    pose : camera_T_part.
    triangles : (T, 3, 3) float64 corner points in the camera frame.
    triangle_face : (T,) face of each triangle.
    normals : (T, 3) unit normals in the camera frame.
    surfaces : (F, texture.COLUMNS) float64, one row per face.
    axes : (F, 9) float64 in the part's frame: middle of the face, and the two unit axes of its plane.
    """

    pose: Pose
    triangles: Floats
    triangle_face: Ints
    normals: Floats
    surfaces: Floats
    axes: Floats


class Scene(NamedTuple):
    """All parts, joined.

    Attributes
    ----------
    triangles : (T, 3, 3) float64, camera frame, metres.
    normals : (T, 3) float64.
    face : (T,) int64, the face of each triangle, over all parts.
    surfaces : (F, COLUMNS) float64; axes : (F, 9) float64; part : (F,) int64.
    poses : (P, 4, 3) float64, camera_T_part: the rotation matrix, then the translation, m.
    """

    triangles: Floats
    normals: Floats
    face: Ints
    surfaces: Floats
    axes: Floats
    part: Ints
    poses: Floats


def joined(parts: list[Part]) -> Scene:
    """One scene of several parts."""
    offsets = np.cumsum([0, *(len(part.surfaces) for part in parts)])
    return Scene(
        triangles=np.concatenate([part.triangles for part in parts]),
        normals=np.concatenate([part.normals for part in parts]),
        face=np.concatenate(
            [part.triangle_face + start for part, start in zip(parts, offsets[:-1], strict=True)]
        ),
        surfaces=np.concatenate([part.surfaces for part in parts]),
        axes=np.concatenate([part.axes for part in parts]),
        part=np.repeat(np.arange(len(parts)), [len(part.surfaces) for part in parts]),
        poses=np.stack([np.vstack([part.pose.matrix, part.pose.translation]) for part in parts]),
    )


def target_part(model: Model, appearance: Appearance, changes: MaterialChanges, pose: Pose) -> Part:
    """The target at a pose."""
    materials = [changes.applied_to(appearance.material_of(face)) for face in range(len(model.faces))]
    part = _part(model.vertices, model.faces, model.triangles, model.triangle_face, materials, pose)
    part.surfaces[:, texture.OFFSET] = OFFSET_STEP * skins(model)
    return part


def skins(model: Model) -> Ints:
    """Faces (F,) between which no sharp line runs have one texture, and one number, of the first of them.

    A mesh cuts what is flat or round in the part into facets, which no one could tell on it.
    """
    sharp = {(min(a, b), max(a, b)) for a, b in model.lines[~model.smooth].tolist()}
    first = list(range(len(model.faces)))

    def root(face: int) -> int:
        while first[face] != face:
            first[face] = first[first[face]]
            face = first[face]
        return face

    sides = np.sort(np.concatenate([model.triangles[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
    order = np.lexsort(sides.T)
    sides, owner = sides[order], np.tile(model.triangle_face, 3)[order]
    for at in np.flatnonzero((sides[1:] == sides[:-1]).all(axis=1) & (owner[1:] != owner[:-1])).tolist():
        if tuple(sides[at].tolist()) not in sharp:
            one, other = sorted((root(int(owner[at])), root(int(owner[at + 1]))))
            first[other] = one
    return np.array([root(face) for face in range(len(first))], dtype=np.int64)


def background_parts(
    background: Background, camera: Camera, target: Pose, diameter_m: float, rng: np.random.Generator
) -> list[Part]:
    """An arm before the target; wall and boxes behind and beside it, where it is not in space.

    The wall stands `distance_m` behind the target's bounding sphere, whatever its range. The generator is
    used in the same way at every range, so that the same things are there.
    """
    parts = [] if background.kind == "space" else _behind(background, camera, target, diameter_m, rng)
    if background.arm > 0.0:
        parts.append(_arm(background.arm * diameter_m, target, diameter_m, rng))
    return parts


def _behind(
    background: Background, camera: Camera, target: Pose, diameter_m: float, rng: np.random.Generator
) -> list[Part]:
    """Wall and boxes."""
    depth = float(target.translation[2]) + diameter_m / 2 + background.distance_m
    tilt = np.radians(rng.uniform(-background.tilt_deg, background.tilt_deg, 2))
    half = WALL_MARGIN * depth * max(camera.width / camera.fx, camera.height / camera.fy) / 2
    wall = np.array([[-half, -half, 0.0], [half, -half, 0.0], [half, half, 0.0], [-half, half, 0.0]])
    turned = Pose.from_matrix(euler_matrix(tilt[0], tilt[1], 0.0), np.array([0.0, 0.0, depth]))
    quad = (np.array([0, 1, 2, 3]),)
    parts = [
        _part(wall, quad, np.array([[0, 1, 2], [0, 2, 3]]), np.zeros(2, np.int64),
              [background.material.applied_to(WALL_MATERIAL)], turned),
    ]  # fmt: skip
    if background.kind == "clutter":
        for number in range(background.boxes):
            parts.append(_box(number, background.boxes, target, diameter_m, background.distance_m, rng))
    return parts


def _box(
    number: int, count: int, target: Pose, diameter_m: float, behind_m: float, rng: np.random.Generator
) -> Part:
    """A box beside and a little behind the target; together they stand around it."""
    size = rng.uniform(*BOX_SIZE, 3) * diameter_m
    around = 2 * math.pi * (number + rng.uniform(0.1, 0.9)) / count
    away = diameter_m * rng.uniform(0.5, 0.75)
    back = rng.uniform(0.1, 0.6) * (diameter_m / 2 + behind_m)
    place = target.translation + np.array([away * math.cos(around), away * math.sin(around), back])
    turn = matrix_of(rng.normal(size=3))
    return _block(size, Pose.from_matrix(turn, place))


def _arm(width_m: float, target: Pose, diameter_m: float, rng: np.random.Generator) -> Part:
    """A bar between camera and target, across it or ending there, as wide as it seems at the target."""
    nearer, angle = rng.uniform(*ARM_NEARER), rng.uniform(0.0, math.pi)
    middle = target.translation + diameter_m * np.r_[rng.uniform(-ARM_ASIDE, ARM_ASIDE, 2), 0.0]
    along = np.array([math.cos(angle), math.sin(angle), rng.uniform(-ARM_LEAN, ARM_LEAN)])
    along /= np.linalg.norm(along)
    across = np.cross(along, [0.0, 0.0, 1.0])
    across /= np.linalg.norm(across)
    length = ARM_LENGTH * diameter_m
    ends_there = rng.random() < 0.5
    centre = nearer * middle + (0.5 * length * rng.uniform(0.9, 1.0) if ends_there else 0.0) * along
    turn = np.stack([along, across, np.cross(along, across)], axis=1)
    size = np.array([length, nearer * width_m, nearer * width_m])
    return _block(size, Pose.from_matrix(turn, centre))


def _block(size: Floats, pose: Pose) -> Part:
    """A box of these sides (3,), metres."""
    corners = np.array([[x, y, z] for z in (-0.5, 0.5) for y in (-0.5, 0.5) for x in (-0.5, 0.5)]) * size
    faces = tuple(np.array(face) for face in BOX_FACES)
    triangles = np.array([t for a, b, c, d in BOX_FACES for t in ((a, b, c), (a, c, d))])
    owner = np.repeat(np.arange(6), 2)
    return _part(corners, faces, triangles, owner, [BOX_MATERIAL] * 6, pose)


def _part(
    vertices: Floats,
    faces: tuple[Ints, ...],
    triangles: Ints,
    owner: Ints,
    materials: list[Material],
    pose: Pose,
) -> Part:
    corners = pose.apply(vertices)[triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = cross / np.maximum(np.linalg.norm(cross, axis=1), 1e-30)[:, None]
    axes = np.zeros((len(faces), 9))
    halves = np.zeros((len(faces), 2))
    sizes = np.array([len(face) for face in faces])
    for size in np.unique(sizes):
        alike = np.flatnonzero(sizes == size)
        axes[alike], halves[alike] = _plane_axes(vertices[np.stack([faces[index] for index in alike])])
    rows = {material: _numbers(material) for material in set(materials)}
    surfaces = np.array([rows[material] for material in materials])
    surfaces[:, texture.OFFSET] = OFFSET_STEP * np.arange(len(faces))
    surfaces[:, texture.HALF_U : texture.HALF_V + 1] = halves
    return Part(pose, corners, np.asarray(owner), normals, surfaces, axes)


def _numbers(material: Material) -> list[float]:
    """A material as the kernel's row of numbers; what depends on the face is left 0."""
    row = [0.0] * texture.COLUMNS
    row[texture.ALBEDO] = material.albedo
    row[texture.TEXTURE] = float(TEXTURES.index(material.texture))
    row[texture.SIZE] = material.size_m
    row[texture.CONTRAST] = material.contrast
    row[texture.GRAIN] = material.grain
    row[texture.SPECULAR] = material.specular
    row[texture.ALPHA] = material.roughness**2
    row[texture.CRINKLE] = material.crinkle
    return row


def _plane_axes(polygons: Floats) -> tuple[Floats, Floats]:
    """Frames of the planes of polygons (N, K, 3).

    Returns
    -------
    (N, 9), each the middle and two unit axes, the first along the longest side; (N, 2) half extents.
    """
    count = np.arange(len(polygons))
    sides = np.roll(polygons, -1, axis=1) - polygons
    lengths = np.linalg.norm(sides, axis=2)
    longest = np.argmax(lengths, axis=1)
    u = sides[count, longest] / np.maximum(lengths[count, longest], 1e-30)[:, None]
    mean = polygons.mean(axis=1)
    across = polygons - mean[:, None]
    across = across - np.einsum("nki,ni->nk", across, u)[..., None] * u[:, None]
    reach = np.linalg.norm(across, axis=2)
    widest = np.argmax(reach, axis=1)
    v = across[count, widest] / np.maximum(reach[count, widest], 1e-30)[:, None]
    middle = mean
    halves = np.zeros((len(polygons), 2))
    for axis, unit in enumerate((u, v)):
        along = np.einsum("nki,ni->nk", polygons, unit)
        low, high = along.min(axis=1), along.max(axis=1)
        halves[:, axis] = (high - low) / 2
        offset = (low + high) / 2 - np.einsum("ni,ni->n", mean, unit)
        middle = middle + offset[:, None] * unit
    return np.concatenate([middle, u, v], axis=1), halves
