"""Where things are: draws of the true pose, the seed pose, the sun, and of what goes wrong in a move."""

import math

import numpy as np

from bridge.errors import BadInput
from geometry.camera import Camera
from geometry.model import Model, about_middle, size_meant
from geometry.pose import SEARCH_ROTATION_DEG, SEARCH_TRANSLATION_PX, Pose
from geometry.rotation import euler_matrix, matrix_of
from image_server.simulator.scenario import RANGE_M
from image_server.simulator.scenario_tables import FARTHEST_M, Move, PoseDraw, Sun
from numerics.arrays import Floats

TRIES = 400  # chosen by hand: where so many draws fail, the best of them is as good as it gets
FRAME_MARGIN_PX = 6.0  # chosen by hand
POINTS_PER_LINE = 9  # at which lines are asked whether they are in the frame
WELL_SHOWN = 0.12  # share of the visible faces' projected area
GLINT_SCATTER_DEG = 1.5  # chosen by hand: the glint is near its middle, not always there
LEAST_RANGE_DIAMETERS = 0.5  # a target nearer than this would contain the camera
LEAST_PX = 1.0  # of a target in the image: of a smaller one nothing but a dot is seen


def check_draw(draw: PoseDraw, model: Model, camera: Camera) -> None:
    """Whether a target can be put where a scenario says, and be seen there.

    Raises
    ------
    BadInput : its range is beyond what numbers hold, within the target, or so far away that the target is a
        dot; the search range of a seed pose, which is in px, is beyond the focal length.
    """
    least, most = draw.range_m or RANGE_M
    if most > FARTHEST_M:
        raise BadInput(
            f"The scenario's [pose] range_m ends at {most:g} m, in proportion to a target that is"
            f" {model.diameter:.2g} m large.",
            f"Allowed: {FARTHEST_M:g} m or less.",
        )
    nearest = LEAST_RANGE_DIAMETERS * model.diameter
    if least < nearest and size_meant(model.diameter):
        raise BadInput(
            f"The scenario's [pose] range_m begins at {least:g} m, and the target is"
            f" {model.diameter:.2g} m large.",
            f"Allowed: {nearest:.2g} m or more.",
        )
    if SEARCH_TRANSLATION_PX * draw.search_fraction >= camera.fx:
        raise BadInput(
            f"The scenario's [camera] fx is {camera.fx:g} px: a seed pose that is off by as many px"
            " as it may be lies behind the camera.",
            "fx is no focal length in mm, but in px; untold it is 1.25 times the width.",
        )
    if camera.fx * model.diameter < LEAST_PX * most and size_meant(model.diameter):
        raise BadInput(
            f"The scenario's [pose] range_m ends at {most:g} m: from there the target, which is"
            f" {model.diameter:.2g} m large, is less than a pixel wide.",
            f"Give metres: {camera.fx * model.diameter / LEAST_PX:.3g} m or less.",
        )


def drawn_pose(draw: PoseDraw, model: Model, front: Floats, camera: Camera, rng: np.random.Generator) -> Pose:
    """A true pose: of up to TRIES draws the first that lies in the frame, else the one that does so most.

    Raises
    ------
    BadInput : none does at all.
    """
    best, best_inside = None, -1.0
    aimed_at = _aimed_at(model)
    for _ in range(TRIES):
        pose = _one_pose(draw, front, camera, rng)
        pose = Pose(pose.rotation_vector, pose.translation - pose.matrix @ aimed_at)
        if draw.orientation == "uniform" and faces_shown(model, pose) < draw.least_faces:
            continue
        inside = fraction_inside(model, camera, pose)
        if inside >= draw.inside_fraction:
            return pose
        if inside > best_inside:
            best, best_inside = pose, inside
    if best_inside == 0.0:
        raise BadInput(
            f"The scenario puts the target outside of its frame of {camera.width}×{camera.height} px.",
            "Check [camera] fx, cx and cy, and [pose] centre_px: all are in px.",
        )
    return best if best is not None else _one_pose(draw, front, camera, rng)


def _aimed_at(model: Model) -> Floats:
    """What is put where a draw says, (3,), target frame: its origin, or its middle if that is outside it."""
    low, high = model.vertices.min(axis=0), model.vertices.max(axis=0)
    return np.zeros(3) if ((low <= 0.0) & (high >= 0.0)).all() else model.middle


def _one_pose(draw: PoseDraw, front: Floats, camera: Camera, rng: np.random.Generator) -> Pose:
    distance = rng.uniform(*(draw.range_m or RANGE_M))
    across = rng.uniform(-1, 1, 2) * draw.centre_px / np.array([camera.fx, camera.fy])
    sight = np.array([across[0], across[1], 1.0])
    sight /= np.linalg.norm(sight)
    if draw.orientation == "uniform":
        quaternion = rng.normal(size=4)
        quaternion /= np.linalg.norm(quaternion)
        rotation = _matrix_of_quaternion(quaternion)
    else:
        rotation = _view(draw, front, rng)
    return Pose.from_matrix(rotation, distance * sight)


def _view(draw: PoseDraw, front: Floats, rng: np.random.Generator) -> Floats:
    """Rotation whose front leans from the camera by a drawn tilt, then rolled about the optical axis."""
    low, high = np.cos(np.radians(draw.tilt_deg))
    tilt = math.acos(rng.uniform(min(low, high), max(low, high)))
    azimuth = rng.uniform(-math.pi, math.pi)
    roll = math.radians(rng.uniform(-draw.roll_deg, draw.roll_deg))
    lean: Floats = matrix_of(tilt * np.array([math.cos(azimuth), math.sin(azimuth), 0.0]))
    turn: Floats = euler_matrix(0.0, 0.0, roll)
    return lean @ turn @ _facing(front)


def _facing(front: Floats) -> Floats:
    """Smallest rotation that turns the front to the camera, along -z."""
    front = front / np.linalg.norm(front)
    camera_side = np.array([0.0, 0.0, -1.0])
    axis = np.cross(front, camera_side)
    sine, cosine = float(np.linalg.norm(axis)), float(front @ camera_side)
    if sine < 1e-9:
        return np.eye(3) if cosine > 0 else np.diag([-1.0, 1.0, -1.0])
    out: Floats = matrix_of(axis / sine * math.atan2(sine, cosine))
    return out


def _matrix_of_quaternion(q: Floats) -> Floats:
    w, axis = q[0], q[1:]
    length = float(np.linalg.norm(axis))
    out: Floats = matrix_of(axis / max(length, 1e-12) * 2 * math.atan2(length, w))
    return out


def faces_shown(model: Model, pose: Pose) -> int:
    """How many faces each take a good share of what is turned to the camera."""
    areas = shown_areas(model, pose)
    return int((areas > WELL_SHOWN * max(areas.sum(), 1e-30)).sum())


def shown_areas(model: Model, pose: Pose) -> Floats:
    """Area (F,) of each face as it is turned to the camera, m²; 0 from behind."""
    corners = pose.apply(model.vertices)[model.triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    middle = corners.mean(axis=1)
    towards = -np.einsum("ij,ij->i", cross, middle) / np.linalg.norm(middle, axis=1)
    two_sided = model.two_sided[model.triangle_face]
    towards = np.where(two_sided, np.abs(towards), np.maximum(towards, 0))
    areas = np.bincount(model.triangle_face, weights=towards, minlength=len(model.faces))
    return areas.astype(np.float64)


def fraction_inside(model: Model, camera: Camera, pose: Pose) -> float:
    """Share of the model's line points that fall into the frame."""
    ends = pose.apply(model.vertices)[model.lines]
    along = np.linspace(0, 1, POINTS_PER_LINE)[:, None, None]
    points = ((1 - along) * ends[:, 0] + along * ends[:, 1]).reshape(-1, 3)
    pixels = camera.project(points)
    limits = np.array([camera.width - 1, camera.height - 1]) - FRAME_MARGIN_PX
    return float(((pixels >= FRAME_MARGIN_PX) & (pixels <= limits)).all(axis=1).mean())


def seed_pose_of(
    origin: Pose, model: Model, camera: Camera, fraction: float, rng: np.random.Generator
) -> Pose:
    """A seed pose around which the search range, about the model's middle, holds the true pose of its origin.

    R_true = R_seed·Rx·Ry·Rz, T_true = T_seed + offsets of ≤ 40 px · Z_seed / f (docs/architecture.md), each
    drawn from `fraction` of the range.
    """
    to_middle = about_middle(model)[1]
    true = origin.compose(to_middle) if to_middle.translation.any() else origin
    angles = np.radians(SEARCH_ROTATION_DEG) * fraction * rng.uniform(-1, 1, 3)
    offsets = SEARCH_TRANSLATION_PX / camera.fx * fraction * rng.uniform(-1, 1, 3)
    depth = true.translation[2] / (1 + offsets[2])
    rotation = true.matrix @ euler_matrix(*angles).T
    return Pose.from_matrix(rotation, true.translation - offsets * depth - rotation @ to_middle.translation)


def moved_pose(true: Pose, range_m: float, move: Move, rng: np.random.Generator) -> Pose:
    """The target brought to a range along its line of sight, not quite exactly."""
    sight = true.translation / np.linalg.norm(true.translation)
    distance = range_m * (1 + move.range_fraction * rng.normal())
    sideways = range_m * move.lateral_fraction * rng.normal(size=3)
    sideways -= sight * (sight @ sideways)
    turn: Floats = matrix_of(math.radians(move.attitude_deg) / math.sqrt(3) * rng.normal(size=3))
    return Pose.from_matrix(turn @ true.matrix, distance * sight + sideways)


def drawn_sun(sun: Sun, model: Model, pose: Pose, rng: np.random.Generator) -> Floats:
    """Unit vector (3,) towards the sun, camera frame."""
    angle = math.radians(rng.uniform(*sun.angle_deg))
    azimuth = math.radians(rng.uniform(*sun.azimuth_deg))
    if sun.direction is not None:
        return np.asarray(np.array(sun.direction) / np.linalg.norm(sun.direction))
    to_camera = -pose.translation / np.linalg.norm(pose.translation)
    if sun.glint:
        scatter = math.radians(GLINT_SCATTER_DEG) * rng.normal(size=3)
        normal = _largest_normal(model, pose)
        mirrored = 2 * (normal @ to_camera) * normal - to_camera + scatter
        return np.asarray(mirrored / np.linalg.norm(mirrored))
    right = np.array([1.0, 0.0, 0.0])
    right -= to_camera * (to_camera @ right)
    right /= np.linalg.norm(right)
    down = np.cross(right, to_camera)
    down = down if down[1] > 0 else -down
    return np.asarray(
        math.cos(angle) * to_camera + math.sin(angle) * (math.cos(azimuth) * right + math.sin(azimuth) * down)
    )


def _largest_normal(model: Model, pose: Pose) -> Floats:
    """Normal of the face that shows most, towards the camera."""
    face = int(np.argmax(shown_areas(model, pose)))
    normal: Floats = pose.matrix @ model.face_normals[face]
    middle = pose.apply(model.vertices[model.faces[face]]).mean(axis=0)
    return normal if normal @ middle < 0 else -normal


def sun_axis(direction: Floats, rng: np.random.Generator) -> Floats:
    """A drawn unit vector (3,) across the sun's direction, about which it turns."""
    axis = np.cross(direction, rng.normal(size=3))
    return np.asarray(axis / np.linalg.norm(axis))


def turned_sun(direction: Floats, turn_deg: float, rng: np.random.Generator) -> Floats:
    """The sun's direction after a turn about a drawn axis across it."""
    out: Floats = matrix_of(sun_axis(direction, rng) * math.radians(turn_deg)) @ direction
    return out
