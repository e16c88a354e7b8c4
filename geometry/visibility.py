"""Which parts of a model's lines can be seen from a pose.

A mesh's lines (`surface.wireframe`) are joined to chains and arcs (`chains`); from a pose, the smooth edges
that are outline there are added (`lines_in_view`, `outlines`), and each is cut where something is before it
(`hidden_lines`, `occluders`).
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from geometry.camera import Camera
from geometry.chains import arcs, chains
from geometry.deformed import change_of
from geometry.errors import GeometryError
from geometry.hidden_lines import trace
from geometry.model import Model
from geometry.occluders import Solid
from geometry.pose import Pose
from geometry.roundings import shifts_of
from geometry.triangle_tree import tree_of
from numerics.arrays import Floats, Ints

DENSEST_PX = 2.0  # between samples: the sharpest filter makes nearer ones alike
QUARTER_TURN = np.array([-1.0, 1.0])  # of a direction whose x and y are interchanged
MIN_LINE_PX = 4.0  # lines and chains of facets shorter than this in the image are left out


class Samples(NamedTuple):
    """Points along the visible parts of a model's lines.

    Attributes
    ----------
    points : (N, 3) float64, target frame, metres.
    direction : (N, 3) float64, unit vector of the line, target frame.
    line : (N,) int64, index into the model's lines, of arcs and outlines of many facets one of these;
        ascending.
    image : (N, 2) float64, px; with the lens distortion of the camera that was asked.
    image_direction : (N, 2) float64, unit vector of the line in the image there.
    px : (N,) float64, image length that each sample stands for.
    own : (N,) int64, the line that the sample is on, of an arc or an outline the facet's.
    """

    points: Floats
    direction: Floats
    line: Ints
    image: Floats
    image_direction: Floats
    px: Floats
    own: Ints

    @property
    def normal(self) -> Floats:
        """(N, 2), unit normals of the lines in the image: their directions turned by 90 degrees."""
        return np.asarray(self.image_direction[:, ::-1] * QUARTER_TURN)


@lru_cache(maxsize=8)
def solid_of(model: Model) -> Solid:
    """Arrays of a model for `trace`; shared, not to be written to."""
    vertices, change = np.ascontiguousarray(model.vertices, dtype=np.float64), change_of(model)
    before = None if change is None else solid_of(change.before)
    found = arcs(model) if before is None else before
    return Solid(
        vertices,
        np.ascontiguousarray(model.lines, dtype=np.int64),
        np.ascontiguousarray(model.line_faces, dtype=np.int64),
        np.ascontiguousarray(model.smooth, dtype=np.bool_),
        chains(model) if before is None else before.chain,
        found.leader,
        found.place,
        found.backwards,
        tree_of(vertices, np.ascontiguousarray(model.triangles, dtype=np.int64), model.diameter),
        np.ascontiguousarray(model.triangle_face, dtype=np.int64),
        vertices[model.triangles[np.searchsorted(model.triangle_face, np.arange(len(model.faces))), 0]],
        np.ascontiguousarray(model.face_normals, dtype=np.float64),
        np.ascontiguousarray(model.two_sided, dtype=np.bool_),
        model.diameter,
    )


def visible_samples(model: Model, camera: Camera, pose: Pose, spacing_px: float = 1.0) -> Samples:
    """Sample the visible parts of a model's lines evenly in the image.

    Hidden are parts behind a face, lines between two faces that look away, parts outside the image or
    nearer than NEAR, and lines shorter than MIN_LINE_PX. Touching faces do not hide each other's lines.

    Parameters
    ----------
    spacing_px : image distance between the samples of a line, px; less, to DENSEST_PX, of short lines.

    Raises
    ------
    GeometryError : a spacing that is not positive.
    """
    if not spacing_px > 0:
        raise GeometryError(f"spacing of samples must be positive, got {spacing_px} px")
    bounds = image_bounds(camera)
    seen = trace(
        solid_of(model),
        pose.matrix,
        np.asarray(pose.translation),
        camera.intrinsics,
        bounds,
        float(spacing_px),
        min(float(spacing_px), DENSEST_PX),
        MIN_LINE_PX,
    )
    samples = Samples(seen.points, seen.along, seen.line, seen.image, seen.direction, seen.px, seen.own)
    if camera.distorted:
        samples = _through_lens(samples, camera, pose)
    return _rounded(samples, model, camera, pose) if model.edge_radius_m > 0.0 else samples


def _rounded(samples: Samples, model: Model, camera: Camera, pose: Pose) -> Samples:
    """Where in the image the rounded edges are seen that the samples' lines stand for."""
    points, along = pose.apply(samples.points), samples.direction @ pose.matrix.T
    shifts = model.edge_radius_m * shifts_of(model, pose.matrix, samples.line, points, along)
    return samples._replace(image=samples.image + camera.project(points + shifts) - camera.project(points))


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
        samples.own[inside],
    )
