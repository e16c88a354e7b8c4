"""Hidden-line removal sample by sample, with a ray and every triangle: the oracle of geometry.visibility."""

import numpy as np

from geometry.hidden_lines import ON_FACE_SHARE
from geometry.model import Model
from geometry.pose import Pose
from numerics.arrays import Flags, Floats


def turned_to_camera(model: Model, pose: Pose, line: int) -> bool:
    """Whether the faces beside a line let it be seen."""
    centre = pose.inverse().translation
    sides = []
    for face in model.line_faces[line]:
        if face >= 0:
            outward = float(model.face_normals[face] @ (centre - model.vertices[model.faces[face][0]]))
            sides.append((outward > 0, bool(model.two_sided[face])))
    if not sides:
        return True
    if model.smooth[line] and len(sides) == 2:
        return sides[0][0] != sides[1][0]
    return any(front or both for front, both in sides)


def hidden(model: Model, pose: Pose, points: Floats) -> Flags:
    """Whether any triangle lies between the camera and each point (N, 3) of the target frame."""
    centre, touch = pose.inverse().translation, ON_FACE_SHARE * model.diameter
    out = np.zeros(len(points), dtype=bool)
    for triangle, face in zip(model.triangles, model.triangle_face, strict=True):
        a, b, c = model.vertices[triangle]
        normal = np.cross(b - a, c - a)
        normal = normal / np.linalg.norm(normal)
        if not model.two_sided[face] and normal @ (centre - a) <= 0:
            continue
        steps = np.empty((len(points), 3, 3))
        steps[:, :, 0], steps[:, :, 1], steps[:, :, 2] = b - a, c - a, centre - points
        crosses = abs(np.linalg.det(steps)) >= 1e-15
        to_corner = np.broadcast_to((centre - a)[:, None], (crosses.sum(), 3, 1))
        u, v, t = np.linalg.solve(steps[crosses], to_corner)[..., 0].T
        met = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0) & (t < 1)
        out[crosses] |= met & (abs((points[crosses] - a) @ normal) > touch)
    return out
