"""The paper's matcher: a genetic algorithm over six parameters of eight bits each."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from numerics.arrays import Floats, Ints
from numerics.kernels import kernel
from vision_server.matching.draws import poses_in_range, reach_m
from vision_server.matching.icp import LEAST_DEPTH_M
from vision_server.matching.match import Hypothesis, SearchRange, distinct, matching_problem
from vision_server.matching.search import MOST_HYPOTHESES
from vision_server.matching.views import ViewTable

# The paper's numbers: Rx Ry Rz Tx Ty Tz by eight bits each; 200 individuals and about ten generations; the
# best 5 % stay, children come from the best 30 %.
BITS = 8
GENES = 6
POPULATION = 200
GENERATIONS = 10
ELITE_SHARE, PARENT_SHARE = 0.05, 0.30
CHILDREN_TRIED = 4  # per place in a generation; doubles are dropped (chosen by hand)
SPACING_PX = 20.0  # a line is visible when any of its samples is
NEAR_COST = 2 * 5.0**2  # an image line with both ends within 5 px counts as support
NO_LINES_COST = 1e12


def match_genetic(
    segments: Floats,
    model: Model,
    camera: Camera,
    seed_pose: Pose,
    seed: int,
    search_range: SearchRange = SearchRange(),
    population: int = POPULATION,
    generations: int = GENERATIONS,
) -> list[Hypothesis]:
    """Evolve poses in the search range towards the least sum of line costs; distinct, best first.

    Parameters and errors are those of `matching_problem`.

    Parameters
    ----------
    seed : of the random numbers.
    search_range : around the seed pose.
    population, generations : the paper's numbers unless given.
    """
    nearer_m = reach_m(seed_pose, camera, search_range)
    problem = matching_problem(segments, model, camera, seed_pose, nearer_m, SPACING_PX)
    if len(problem.segments) == 0:
        return []
    lines = line_table(problem.segments)
    views, intrinsics = problem.views, problem.camera.intrinsics

    def judged(rotations: Floats, translations: Floats) -> tuple[Floats, Floats]:
        view = views.of(rotations, translations)
        cost, supported = line_costs(lines, views.table(), view, rotations, translations, intrinsics)
        return cost, supported

    rotations, translations, cost = evolved(
        lambda r, t: judged(r, t)[0], seed_pose, problem.camera, search_range, seed, population, generations
    )
    best = distinct(rotations, translations, -cost, MOST_HYPOTHESES)
    _, supported = judged(rotations[best], translations[best])
    return [
        Hypothesis(Pose.from_matrix(rotations[i], translations[i]), -float(cost[i]), float(share))
        for i, share in zip(best, supported, strict=True)
        if cost[i] < NO_LINES_COST
    ]


def evolved(
    costs: Callable[[Floats, Floats], Floats],
    seed_pose: Pose,
    camera: Camera,
    search_range: SearchRange,
    seed: int,
    population: int,
    generations: int,
) -> tuple[Floats, Floats, Floats]:
    """The last generation: rotations (N, 3, 3), translations (N, 3) and what ``costs`` says of them, (N,)."""
    random = np.random.default_rng(seed)
    genomes = first_generation(random, population)
    for generation in range(generations + 1):
        rotations, translations = poses_in_range(seed_pose, camera, search_range, decoded(genomes))
        cost = costs(rotations, translations)
        if generation < generations:
            ranked = genomes[np.argsort(cost, kind="stable")]
            numbers = random.integers(0, 2**31, (CHILDREN_TRIED * population, 4))
            genomes = next_generation(ranked, numbers, population)
    return rotations, translations, cost


def decoded(genomes: Ints) -> Floats:
    """Genomes (N,) of GENES · BITS bits as parameters (N, GENES) from -1 to 1."""
    shifts = BITS * np.arange(GENES)
    top = 2**BITS - 1
    out: Floats = 2.0 * ((genomes[:, None] >> shifts) & top) / top - 1.0
    return out


def first_generation(random: np.random.Generator, size: int = POPULATION) -> Ints:
    """So many different random genomes."""
    found: dict[int, None] = {}
    while len(found) < size:
        found[int(random.integers(0, 2 ** (BITS * GENES)))] = None
    return np.array(list(found), dtype=np.int64)


def crossed(first: Ints, second: Ints, point: Ints, flipped: Ints) -> Ints:
    """Children (K,) with the bits of ``first`` below ``point`` and of ``second`` from there, one flipped."""
    one = np.int64(1)
    low = (one << point) - one
    out: Ints = ((first & low) | (second & ~low)) ^ (one << flipped)
    return out


def next_generation(ranked: Ints, numbers: Ints, size: int = POPULATION) -> Ints:
    """Elite and children of a generation ranked best first; all different.

    Parameters
    ----------
    numbers : (K, 4), random integers >= 0; each row makes one child: two parents, crossover point, flipped
        bit. When children that are already there use them all up, the generation stays smaller.
    """
    elite = ranked[: max(1, round(ELITE_SHARE * size))]
    parents = ranked[: max(2, round(PARENT_SHARE * size))]
    mother, father, point, flipped = numbers.T
    children = crossed(
        parents[mother % len(parents)],
        parents[father % len(parents)],
        1 + point % (BITS * GENES - 1),
        flipped % (BITS * GENES),
    )
    everyone = np.concatenate([elite, children])
    _, first_seen = np.unique(everyone, return_index=True)
    return everyone[np.sort(first_seen)[:size]]


def line_table(segments: Floats) -> Floats:
    """Segments (N, 4) with their axis, degrees in [0, 180): (5, N)."""
    angle = np.degrees(np.arctan2(segments[:, 3] - segments[:, 1], segments[:, 2] - segments[:, 0]))
    return np.ascontiguousarray(np.column_stack([segments, angle % 180.0]).T)


@kernel(inline="always")
def _least_cost(lines: Floats, x: float, y: float, nx: float, ny: float, axis: float) -> float:
    """Least cost of an image line for the model line through (x, y) of that normal and axis."""
    x0, y0, x1, y1, axes = lines[0], lines[1], lines[2], lines[3], lines[4]
    best = NO_LINES_COST
    for k in range(len(axes)):  # no branches: fills vector registers
        first = nx * (x0[k] - x) + ny * (y0[k] - y)
        second = nx * (x1[k] - x) + ny * (y1[k] - y)
        apart = abs(axis - axes[k])
        turn = min(apart, 180.0 - apart)
        best = min(best, first * first + second * second + turn * turn)
    return best


@kernel(fastmath={"nnan", "ninf", "nsz", "reassoc", "contract"})
def line_costs(
    lines: Floats,
    views: ViewTable,
    view: Ints,
    rotations: Floats,
    translations: Floats,
    intrinsics: Floats,
) -> tuple[Floats, Floats]:
    """The paper's fitness of each pose, to be made small, and the supported fraction, (N,) each.

    Sum over visible model lines of the least, over image lines, of angle difference squared (degrees) plus
    the squared distances (px) of both ends of the image line to the model line.

    Parameters
    ----------
    lines : (5, M), from `line_table`.
    """
    count = len(view)
    cost = np.empty(count)
    supported = np.zeros(count)
    fx, fy, cx, cy = intrinsics[0], intrinsics[1], intrinsics[2], intrinsics[3]
    for i in range(count):
        r, t = rotations[i], translations[i]
        total, used, near, length = 0.0, 0, 0.0, 0.0
        for q in range(views.first[view[i]], views.first[view[i] + 1]):
            p, e = views.ends[q, 0], views.ends[q, 1]
            z = r[2, 0] * p[0] + r[2, 1] * p[1] + r[2, 2] * p[2] + t[2]
            z_end = r[2, 0] * e[0] + r[2, 1] * e[1] + r[2, 2] * e[2] + t[2]
            if z <= LEAST_DEPTH_M or z_end <= LEAST_DEPTH_M:
                continue
            x = fx * (r[0, 0] * p[0] + r[0, 1] * p[1] + r[0, 2] * p[2] + t[0]) / z + cx
            y = fy * (r[1, 0] * p[0] + r[1, 1] * p[1] + r[1, 2] * p[2] + t[1]) / z + cy
            dx = fx * (r[0, 0] * e[0] + r[0, 1] * e[1] + r[0, 2] * e[2] + t[0]) / z_end + cx - x
            dy = fy * (r[1, 0] * e[0] + r[1, 1] * e[1] + r[1, 2] * e[2] + t[1]) / z_end + cy - y
            norm = math.hypot(dx, dy)
            if norm == 0.0:
                continue
            axis = math.degrees(math.atan2(dy, dx)) % 180.0
            best = _least_cost(lines, x, y, -dy / norm, dx / norm, axis)
            total += best
            used += 1
            seen = 0.0
            for k in range(views.run[q], views.run[q + 1]):
                seen += views.px[k]
            length += seen
            if best < NEAR_COST:
                near += seen
        cost[i] = total if used > 0 else NO_LINES_COST
        supported[i] = near / length if length > 0.0 else 0.0
    return cost, supported
