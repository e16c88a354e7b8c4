"""Outlines of curved surfaces: shading rises steeply beside them, and draws the edge that is seen inwards.

Near its outline a surface turns away from the camera as the root of the distance does, and so does its
shading change: the gradient goes on inside, and its maximum lies beyond the outline. By how much the flank of
the gradient inside is the larger one tells how far.
"""

from __future__ import annotations

import numpy as np

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from geometry.visibility import Samples
from numerics.arrays import Flags, Floats, Ints
from numerics.kernels import kernel
from vision_server.channels.gradients import Frame
from vision_server.pose.edge_points import Channel, derivative_at

# From 2000 edge points on views of a free-form body of 64 and 128 segments under lamps drawn at random:
# edges whose flanks differ by less than a tenth of their height lay 0.1 px inside, by a quarter 0.3 and by a
# half 0.6, half of them within a third of that.
FLANK_SCALES = 3.0  # from the edge to where its flanks are compared, in scales of the filter
SHIFT_PER_FLANK = 1.3  # scales by which the edge is drawn in, where one flank is as high as the edge
MOST_SHIFT_SCALES = 1.0  # scales by which one is moved back
SHIFT_SD_SHARE = 0.5  # of the way back, its standard deviation


def inside_of(model: Model, camera: Camera, pose: Pose, samples: Samples) -> Floats:
    """On which side of each sample's line the curved surface is of which it is the outline.

    Returns
    -------
    (N,): 1 ahead along the normal, -1 behind, 0 where the line is no outline.
    """
    if not model.faces:
        return np.zeros(len(samples.line))
    faces, normals = model.line_faces, model.face_normals
    return np.asarray(_inside(samples, model.smooth, faces, normals, pose.matrix, camera.fx, camera.fy))


@kernel()
def _inside(
    samples: Samples, smooth: Flags, line_faces: Ints, normals: Floats, rotation: Floats, fx: float, fy: float
) -> Floats:
    """See `inside_of`; of lines (L,) which are smooth, their faces (L, 2), and the faces' normals (F, 3)."""
    line, direction = samples.line, samples.image_direction
    inside = np.zeros(len(line))
    for i in range(len(line)):
        one, two = line_faces[line[i], 0], line_faces[line[i], 1]
        if not smooth[line[i]] or one < 0 or two < 0:
            continue
        x, y = 0.0, 0.0
        for k in range(3):
            outwards = normals[one, k] + normals[two, k]
            x += rotation[0, k] * outwards
            y += rotation[1, k] * outwards
        inside[i] = -np.sign(x * -direction[i, 1] / fx + y * direction[i, 0] / fy)
    return inside


@kernel()
def way_back(
    frame: Frame,
    channel: Channel,
    place: tuple[float, float],
    normal: tuple[float, float],
    slope: float,
    inside: float,
) -> tuple[float, float]:
    """By how much to move an edge of an outline along the normal, and the standard deviation of that, px.

    Parameters
    ----------
    place, normal : of the edge, px; the unit normal of the line.
    slope : the derivative there, grey per px.
    inside : 1 or -1, see `inside_of`.
    """
    rows, columns = frame.shape
    reach = FLANK_SCALES * channel.sigma
    (x, y), (nx, ny) = place, normal
    if not (reach <= x < columns - 2.0 - reach and reach <= y < rows - 2.0 - reach):
        return 0.0, 0.0
    dx, dy = inside * reach * nx, inside * reach * ny
    within = derivative_at(channel, x + dx, y + dy, nx, ny)
    without = derivative_at(channel, x - dx, y - dy, nx, ny)
    heavier = (within - without) / slope
    if heavier <= 0.0:
        return 0.0, 0.0
    shift = min(SHIFT_PER_FLANK * heavier, MOST_SHIFT_SCALES) * channel.sigma
    return -inside * shift, SHIFT_SD_SHARE * shift
