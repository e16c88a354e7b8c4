"""Level of detail: of very many lines the longest say which pose is worth a look at all of them."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from geometry.chains import chains, longest_chains
from geometry.model import Model
from numerics.arrays import Ints
from vision_server.pose.observation import PoseProblem

MOST_COMPARED_CURVES = 500  # lines and chains of lines, by hand: a model of no more has all compared


def fewer_lines(problem: PoseProblem) -> PoseProblem:
    """The problem with the longest MOST_COMPARED_CURVES of its model's lines; all faces still hide.

    Outlines of curved surfaces all stay: which of them are seen depends on the pose.
    """
    model, kept = _sparse(problem.model)
    return problem if model is problem.model else replace(problem, model=model, scale=problem.scale[:, kept])


@lru_cache(maxsize=8)
def _sparse(model: Model) -> tuple[Model, Ints]:
    """The model with these lines only, and which they are."""
    chosen = longest_chains(model.vertices, model.lines, model.smooth, chains(model), MOST_COMPARED_CURVES)
    kept = np.flatnonzero(chosen)
    if len(kept) == len(model.lines):
        return model, kept
    lines, faces, smooth = model.lines[kept], model.line_faces[kept], model.smooth[kept]
    return replace(model, lines=lines, line_faces=faces, smooth=smooth), kept
