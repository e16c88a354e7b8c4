"""Closed meshes of very many facets in fewer ones, by edge collapse within a tolerance (Manifold's)."""

from __future__ import annotations

import numpy as np

from numerics.arrays import Floats, Ints


def simplified(vertices: Floats, triangles: Ints, off: float) -> tuple[Ints, Ints] | None:
    """Which vertices stay, (W,), and the triangles (T, 3) of these; None of a mesh that is not closed.

    Parameters
    ----------
    vertices, triangles : (V, 3) and (U, 3), which wind outwards.
    off : how far a surface may move, in the unit of the vertices.
    """
    import manifold3d  # few models need it

    solid = manifold3d.Manifold(manifold3d.Mesh64(vertices, triangles.astype(np.uint64)))
    if solid.status() != manifold3d.Error.NoError:
        return None
    mesh = solid.simplify(off).to_mesh64()
    places = np.concatenate([vertices, mesh.vert_properties])
    _, first, which = np.unique(places, axis=0, return_index=True, return_inverse=True)
    kept, number = np.unique(first[which[len(vertices) :]], return_inverse=True)
    return kept, number[mesh.tri_verts.astype(np.int64)]
