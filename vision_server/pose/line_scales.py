"""How soft the edges of each model line are in each channel, and so how well they tell where they are.

One image is blurred alike. A line that seems sharper than most is beside another edge: of two opposite steps
nearer than their blur, the maxima are narrow, and pushed apart. Such a line is taken for as soft as half of
the visible length is.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from geometry.pose import Pose
from geometry.visibility import visible_samples
from numerics.arrays import Floats, Ints
from numerics.kernels import kernel
from vision_server.channels.gradients import SCALES_PX, Normals
from vision_server.pose.edge_points import search
from vision_server.pose.observation import PoseProblem
from vision_server.pose.sampling import thinned

# Chosen by hand where nothing else is said. Halved or doubled (`python -m benchmarks.constants`, 24 sets of
# recorded and hard stacks), the ratio matters much: at 0.35 seven tight poses of 15 are lost and errors are
# 2.6 times as large, at 0.85 two are, and errors are 1.4 times as large.
SCALE_STEP_PX, SCALE_SAMPLES = 3.0, 20  # of the samples of a line: blur varies slowly along it
SCALE_REACH_PX = 4.0  # around a hypothesis' lines, where the blur of the edges is looked at
SOFTER_RATIO = 0.70  # peak at twice the scale over peak at the scale: above this the edge is the softer one
FEWEST_RATIOS = 6  # of a line's samples, for their median to say anything


def line_scales(problem: PoseProblem, pose: Pose) -> Ints:
    """Softness of each line in each channel, (C, L), indices into SCALES_PX.

    An edge of blur b answers a Gaussian derivative of scale s with a peak proportional to (b^2 + s^2)^-1/2;
    the ratio of the peaks at 2s and s therefore tells b/s, whatever the contrast. The scales of ``problem``
    are the least.
    """
    samples = thinned(visible_samples(problem.model, problem.camera, pose, SCALE_STEP_PX), SCALE_SAMPLES)
    normal, out = samples.normal, problem.scale.copy()
    least = int(out.min(initial=0))
    for index, channel in enumerate(problem.channels):
        peaks = np.zeros(len(normal))
        for scale in range(least, len(SCALES_PX)):
            own = out[index, samples.line]
            asked = np.flatnonzero((own == scale) | (own == scale - 1))  # of others it says nothing
            reach = np.full(len(asked), max(SCALE_REACH_PX, 1.5 * SCALES_PX[scale]))
            chosen = np.full((1, len(asked)), scale, dtype=np.int64)
            points = search([channel], chosen, Normals(samples.image[asked], normal[asked], reach))
            below, peaks = peaks, np.zeros(len(normal))
            peaks[asked] = np.abs(points.strength[0]).max(axis=1)
            if scale == least:
                continue
            ratio = _median_ratios(peaks, below, samples.line, out.shape[1])
            softer = (out[index] == scale - 1) & (ratio > SOFTER_RATIO)
            out[index, softer] = scale
            if not softer.any():
                break
    visible_px = np.asarray(np.bincount(samples.line, samples.px, out.shape[1]), dtype=np.float64)
    _raise_to_median(out, visible_px)
    return out


def with_line_scales(problem: PoseProblem, pose: Pose) -> PoseProblem:
    """The problem with each line as soft as it is near a pose, see `line_scales`."""
    return replace(problem, scale=line_scales(problem, pose))


def _raise_to_median(scale: Ints, visible_px: Floats) -> None:
    """Let no line be sharper than half of the visible length (L,) is; (C, L), changed in place."""
    if not visible_px.any():
        return
    for own in scale:
        order = np.argsort(own, kind="stable")
        reached = np.cumsum(visible_px[order])
        np.maximum(own, own[order][np.searchsorted(reached, 0.5 * reached[-1])], out=own)


@kernel()
def _median_ratios(upper: Floats, lower: Floats, line: Ints, lines: int) -> Floats:
    """Median of upper / lower for each line; where lower sees too little but upper does not: 1, else 0.

    ``upper``, ``lower`` (N,), 0 for no peak; ``line`` (N,) ascending.
    """
    out = np.zeros(lines)
    ratios = np.empty(len(line))
    start = 0
    while start < len(line):
        end, both, above, below = start, 0, 0, 0
        while end < len(line) and line[end] == line[start]:
            above += upper[end] > 0.0
            below += lower[end] > 0.0
            if upper[end] > 0.0 and lower[end] > 0.0:
                ratios[both] = upper[end] / lower[end]
                both += 1
            end += 1
        if both >= FEWEST_RATIOS:
            out[line[start]] = np.median(ratios[:both])
        if below < 0.25 * above:
            out[line[start]] = 1.0
        start = end
    return out
