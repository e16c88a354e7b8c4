"""Hidden-line removal sample by sample, with a ray and every triangle: the oracle of geometry.visibility."""

import numpy as np
from numpy.typing import NDArray

from geometry.hidden_lines import TOUCH
from geometry.model import Model
from geometry.pose import Pose

Floats = NDArray[np.float64]


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


def hidden(model: Model, pose: Pose, points: Floats) -> NDArray[np.bool_]:
    """Whether any triangle lies between the camera and each point (N, 3) of the target frame."""
    centre = pose.inverse().translation
    out = np.zeros(len(points), dtype=bool)
    for triangle, face in zip(model.triangles, model.triangle_face, strict=True):
        a, b, c = model.vertices[triangle]
        normal = np.cross(b - a, c - a)
        normal = normal / np.linalg.norm(normal)
        if not model.two_sided[face] and normal @ (centre - a) <= 0:
            continue
        rays = points - centre
        for i, ray in enumerate(rays):
            steps = np.column_stack([b - a, c - a, -ray])
            if abs(np.linalg.det(steps)) < 1e-15:
                continue
            u, v, t = np.linalg.solve(steps, centre - a)
            behind = abs(normal @ (points[i] - a)) > TOUCH * model.diameter
            if u >= 0 and v >= 0 and u + v <= 1 and 0 < t < 1 and behind:
                out[i] = True
    return out
