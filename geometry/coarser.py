"""A model of very many facets in fewer ones, as a search looks at it."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from geometry.deformed import change_of, deformed
from geometry.mesh import simplified, surface_of_triangles
from geometry.model import Model
from geometry.polygon import face_areas

MANY_FACETS = 10_000
# Of the diameter, that a surface may be off: 0.4 px, as a search looks at a target. Twice as much lost two
# of nine statues. Less where it would take sheets away that are thinner, of which few parts have many facets.
SEARCHED_OFF = (1e-3, 1e-4)
LEAST_LEFT = 0.97  # of the area: of 51 meshes of printers .986 and more is left, of three thin sheets nothing


@lru_cache(maxsize=8)
def coarser(model: Model) -> Model:
    """A closed model of MANY_FACETS or more in fewer, SEARCHED_OFF of its diameter off at most; others as is.

    Its vertices are some of the model's. Where these are on no sharp line, large facets make none. A
    `deformed` model has the facets of what it was.
    """
    if len(model.triangles) < MANY_FACETS:
        return model
    change = change_of(model)
    if change is not None:
        before = coarser(change.before)
        return model if before is change.before else deformed(before, change.matrix, change.about)
    area = face_areas(model.vertices, list(model.triangles)).sum()
    for share in SEARCHED_OFF:
        few = simplified(model.vertices, model.triangles, share * model.diameter)
        if few is None:
            return model
        kept, triangles = few
        if face_areas(model.vertices[kept], list(triangles)).sum() >= LEAST_LEFT * area:
            break
    else:
        return model
    found = Model.of_surface(model.name, surface_of_triangles(model.vertices[kept], triangles))
    sharp = np.zeros(len(model.vertices), dtype=bool)
    sharp[model.lines[~model.smooth]] = True
    return replace(found, smooth=found.smooth | ~sharp[kept][found.lines].all(axis=1))
