"""Which parts of a model's lines can be seen from a pose: exact hidden-line removal.

A triangle hides the part of a line that lies behind its plane and in the cone that it spans with the camera.
Cone and half-space are convex, so that part is one interval of the line, found in closed form from the
signed distances of the two ends of the line: no ray is cast per sample.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.errors import GeometryError
from geometry.model import Model
from geometry.occluders import Solid, hidden_part, near_line, occluders, tiled
from geometry.pose import Pose
from numerics.kernels import kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

TOUCH = 1e-4  # a point this fraction of the model's diameter behind a face lies on it: a block on a plate
NEAR = 1e-3  # nearest depth that is drawn, as a fraction of the model's diameter
MIN_LINE_PX = 4.0  # lines shorter than this in the image are left out


class Samples(NamedTuple):
    """Points along the visible parts of a model's lines.

    Attributes
    ----------
    points : (N, 3) float64, target frame, metres.
    direction : (N, 3) float64, unit vector of the line, target frame.
    line : (N,) int64, index into the model's lines; ascending.
    image : (N, 2) float64, px; with the lens distortion of the camera that was asked.
    image_direction : (N, 2) float64, unit vector of the line in the image there.
    px : (N,) float64, image length that each sample stands for.
    """

    points: Floats
    direction: Floats
    line: Ints
    image: Floats
    image_direction: Floats
    px: Floats

    @property
    def normal(self) -> Floats:
        """(N, 2), unit normals of the lines in the image: their directions turned by 90 degrees."""
        return np.stack([-self.image_direction[:, 1], self.image_direction[:, 0]], axis=1)


@lru_cache(maxsize=8)
def solid_of(model: Model) -> Solid:
    """Arrays of a model for `trace`; shared, not to be written to."""
    return Solid(
        np.ascontiguousarray(model.vertices, dtype=np.float64),
        np.ascontiguousarray(model.lines, dtype=np.int64),
        np.ascontiguousarray(model.line_faces, dtype=np.int64),
        np.ascontiguousarray(model.smooth, dtype=np.bool_),
        np.ascontiguousarray(model.triangles, dtype=np.int64),
        np.ascontiguousarray(model.triangle_face, dtype=np.int64),
        np.array([model.vertices[face[0]] for face in model.faces]),
        np.ascontiguousarray(model.face_normals, dtype=np.float64),
        np.ascontiguousarray(model.two_sided, dtype=np.bool_),
        model.diameter,
    )


@lru_cache(maxsize=8)
def _line_directions(model: Model) -> Floats:
    """Unit vectors of a model's lines, (L, 3); shared, not to be written to."""
    along = model.vertices[model.lines[:, 1]] - model.vertices[model.lines[:, 0]]
    return np.asarray(along / np.linalg.norm(along, axis=1, keepdims=True))


@kernel()
def _faces_towards(solid: Solid, centre: Floats) -> Flags:
    """Whether each face's outer side looks at the camera centre (target frame)."""
    count = len(solid.face_normal)
    out = np.empty(count, dtype=np.bool_)
    for f in range(count):
        towards = 0.0
        for k in range(3):
            towards += solid.face_normal[f, k] * (centre[k] - solid.face_point[f, k])
        out[f] = towards > 0.0
    return out


@kernel()
def _line_turned(solid: Solid, towards: Flags, line: int) -> bool:
    """Whether the faces beside a line let it be seen, other parts of the model apart."""
    f, g = solid.line_faces[line, 0], solid.line_faces[line, 1]
    if solid.smooth[line] and f >= 0 and g >= 0:
        return bool(towards[f] != towards[g])
    if f < 0 and g < 0:
        return True
    if f >= 0 and (towards[f] or solid.two_sided[f]):
        return True
    return bool(g >= 0 and (towards[g] or solid.two_sided[g]))


@kernel()
def _clipped(ends: Floats, bounds: Floats) -> tuple[float, float]:
    """Part (from, to) of a segment [x1, y1, x2, y2] inside bounds [x0, y0, x1, y1]; from > to: none."""
    low, high = 0.0, 1.0
    for k in range(2):
        start, step = ends[k], ends[k + 2] - ends[k]
        if step == 0.0:
            if start < bounds[k] or start > bounds[k + 2]:
                return 1.0, 0.0
            continue
        first, second = (bounds[k] - start) / step, (bounds[k + 2] - start) / step
        low, high = max(low, min(first, second)), min(high, max(first, second))
    return low, high


@kernel()
def _extent(ends: Floats) -> tuple[Floats, Floats]:
    """Least and greatest x, y (2,) of segments (N, 4); 0 without any."""
    low, high = np.zeros(2), np.zeros(2)
    for k in range(2):
        for i in range(len(ends)):
            least, most = min(ends[i, k], ends[i, k + 2]), max(ends[i, k], ends[i, k + 2])
            low[k] = least if i == 0 else min(low[k], least)
            high[k] = most if i == 0 else max(high[k], most)
    return low, high


@kernel()
def trace(
    solid: Solid,
    rotation: Floats,
    translation: Floats,
    intrinsics: Floats,
    bounds: Floats,
    spacing_px: float,
    min_line_px: float,
) -> tuple[Ints, Floats, Floats, Floats, Floats]:
    """Samples of the visible lines for a camera without distortion.

    Parameters
    ----------
    rotation, translation : (3, 3), (3,), camera_T_target.
    intrinsics : (4,), fx, fy, cx, cy in px.
    bounds : (4,), the part of the image plane to fill: least x, least y, greatest x, greatest y, px.

    Returns
    -------
    line (N,); points in the target frame (N, 3); image (N, 2); image direction (N, 2); px (N,).
    """
    near = NEAR * solid.diameter
    touch = TOUCH * solid.diameter
    points = np.empty_like(solid.vertices)
    for i in range(len(points)):
        for k in range(3):
            points[i, k] = (
                rotation[k, 0] * solid.vertices[i, 0]
                + rotation[k, 1] * solid.vertices[i, 1]
                + rotation[k, 2] * solid.vertices[i, 2]
                + translation[k]
            )
    centre = np.empty(3)
    for k in range(3):
        centre[k] = -(
            rotation[0, k] * translation[0]
            + rotation[1, k] * translation[1]
            + rotation[2, k] * translation[2]
        )
    towards = _faces_towards(solid, centre)

    # Lines that face the camera, cut to what lies in front and in the image.
    count = len(solid.lines)
    kept = np.empty(count, dtype=np.int64)
    seen = np.empty((count, 4))  # image ends
    cut = np.empty((count, 2, 3))  # the same ends, camera frame
    total, kept_count = 0, 0
    for i in range(count):
        if not _line_turned(solid, towards, i):
            continue
        a, b = solid.lines[i, 0], solid.lines[i, 1]
        depth_a, depth_b = points[a, 2], points[b, 2]
        if depth_a <= near and depth_b <= near:
            continue
        ends, ends3 = seen[kept_count], cut[kept_count]
        low = max(0.0, (near - depth_a) / (depth_b - depth_a)) if depth_a < near else 0.0
        high = min(1.0, (near - depth_a) / (depth_b - depth_a)) if depth_b < near else 1.0
        for k in range(3):
            step = points[b, k] - points[a, k]
            ends3[0, k] = points[a, k] + low * step
            ends3[1, k] = points[a, k] + high * step
        for side in range(2):
            ends[2 * side] = intrinsics[0] * ends3[side, 0] / ends3[side, 2] + intrinsics[2]
            ends[2 * side + 1] = intrinsics[1] * ends3[side, 1] / ends3[side, 2] + intrinsics[3]
        low, high = _clipped(ends, bounds)
        if low > 0.0 or high < 1.0:
            if low >= high:
                continue
            x, y, dx, dy = ends[0], ends[1], ends[2] - ends[0], ends[3] - ends[1]
            ends[0], ends[1], ends[2], ends[3] = x + low * dx, y + low * dy, x + high * dx, y + high * dy
            inverse_a, inverse_b = 1.0 / ends3[0, 2], 1.0 / ends3[1, 2]
            at_low = low * inverse_b / (inverse_a + low * (inverse_b - inverse_a))
            at_high = high * inverse_b / (inverse_a + high * (inverse_b - inverse_a))
            for k in range(3):
                first, step = ends3[0, k], ends3[1, k] - ends3[0, k]
                ends3[0, k] = first + at_low * step
                ends3[1, k] = first + at_high * step
        length = math.hypot(ends[2] - ends[0], ends[3] - ends[1])
        if length < min_line_px:
            continue
        kept[kept_count] = i
        kept_count += 1
        total += max(1, int(length / spacing_px + 0.5))

    planes, boxes = occluders(solid, towards, points, near, intrinsics)
    tiles = tiled(boxes, *_extent(seen[:kept_count]))
    stamp = np.full(len(planes), -1, dtype=np.int64)
    listed = np.empty(len(planes), dtype=np.int64)
    span = np.empty(4)
    line = np.empty(total, dtype=np.int64)
    out = np.empty((total, 3))
    image = np.empty((total, 2))
    direction = np.empty((total, 2))
    px = np.empty(total)
    written = 0
    hidden = np.empty((max(1, len(planes)), 2))
    for j in range(kept_count):
        i, ends, ends3 = kept[j], seen[j], cut[j]
        span[0], span[2] = min(ends[0], ends[2]), max(ends[0], ends[2])
        span[1], span[3] = min(ends[1], ends[3]), max(ends[1], ends[3])
        farthest = max(ends3[0, 2], ends3[1, 2])
        intervals = 0
        for m in range(near_line(tiles, span, stamp, j, listed)):
            k = listed[m]
            box = boxes[k]
            if planes[k, 13] > farthest or box[0] > span[2] or box[2] < span[0]:
                continue
            if box[1] > span[3] or box[3] < span[1]:
                continue
            low, high = hidden_part(planes[k], ends3[0], ends3[1], touch)
            if low <= high:
                hidden[intervals, 0], hidden[intervals, 1] = low, high
                intervals += 1
        dx, dy = ends[2] - ends[0], ends[3] - ends[1]
        length = math.hypot(dx, dy)
        number = max(1, int(length / spacing_px + 0.5))
        inverse_a, inverse_b = 1.0 / ends3[0, 2], 1.0 / ends3[1, 2]
        for k in range(number):
            along = (k + 0.5) / number
            at = along * inverse_b / (inverse_a + along * (inverse_b - inverse_a))
            covered = False
            for m in range(intervals):
                if hidden[m, 0] <= at <= hidden[m, 1]:
                    covered = True
                    break
            if covered:
                continue
            line[written] = i
            px[written] = length / number
            image[written, 0], image[written, 1] = ends[0] + along * dx, ends[1] + along * dy
            direction[written, 0], direction[written, 1] = dx / length, dy / length
            x = ends3[0, 0] + at * (ends3[1, 0] - ends3[0, 0]) - translation[0]
            y = ends3[0, 1] + at * (ends3[1, 1] - ends3[0, 1]) - translation[1]
            z = ends3[0, 2] + at * (ends3[1, 2] - ends3[0, 2]) - translation[2]
            for c in range(3):
                out[written, c] = rotation[0, c] * x + rotation[1, c] * y + rotation[2, c] * z
            written += 1
    return line[:written], out[:written], image[:written], direction[:written], px[:written]


def visible_samples(model: Model, camera: Camera, pose: Pose, spacing_px: float = 1.0) -> Samples:
    """Sample the visible parts of a model's lines evenly in the image.

    Hidden are parts behind a face, lines between two faces that look away, parts outside the image or
    nearer than NEAR, and lines shorter than MIN_LINE_PX. Touching faces do not hide each other's lines.

    Parameters
    ----------
    spacing_px : image distance between the samples of a line, px; a line has at least one sample.

    Raises
    ------
    GeometryError : a spacing that is not positive.
    """
    if not spacing_px > 0:
        raise GeometryError(f"spacing of samples must be positive, got {spacing_px} px")
    bounds = image_bounds(camera)
    line, points, image, image_direction, px = trace(
        solid_of(model),
        pose.matrix,
        np.asarray(pose.translation),
        camera.intrinsics,
        bounds,
        float(spacing_px),
        MIN_LINE_PX,
    )
    samples = Samples(points, _line_directions(model)[line], line, image, image_direction, px)
    return _through_lens(samples, camera, pose) if camera.distorted else samples


def image_bounds(camera: Camera) -> Floats:
    """Least x, least y, greatest x, greatest y (4,) of the image in ideal pixels."""
    right, bottom = camera.width - 1.0, camera.height - 1.0
    if not camera.distorted:
        return np.array([0.0, 0.0, right, bottom])
    along = np.linspace(0.0, 1.0, 33)
    zero, one = np.zeros_like(along), np.ones_like(along)
    border = np.concatenate(
        [np.stack(pair, axis=1) for pair in ((along, zero), (along, one), (zero, along), (one, along))]
    )
    ideal = camera.undistort_points(border * [right, bottom])
    return np.concatenate([ideal.min(axis=0), ideal.max(axis=0)])


def _through_lens(samples: Samples, camera: Camera, pose: Pose) -> Samples:
    """Where a lens with distortion puts the samples; those that leave the image go."""
    image = camera.project(pose.apply(samples.points))
    step = 0.5 * samples.image_direction
    ahead, behind = samples.image + step, samples.image - step
    rays = np.concatenate([ahead, behind])
    rays = (rays - [camera.cx, camera.cy]) / [camera.fx, camera.fy]
    bent = camera.project(np.column_stack([rays, np.ones(len(rays))]))
    secant = bent[: len(ahead)] - bent[len(ahead) :]
    stretch = np.linalg.norm(secant, axis=1)
    inside = ((image >= 0) & (image <= [camera.width - 1, camera.height - 1])).all(axis=1) & (stretch > 0)
    return Samples(
        samples.points[inside],
        samples.direction[inside],
        samples.line[inside],
        image[inside],
        secant[inside] / stretch[inside, None],
        (samples.px * stretch)[inside],
    )
