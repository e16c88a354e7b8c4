"""Polygon surfaces: winding, closedness, and which of their edges are lines of the wireframe."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from geometry.errors import GeometryError
from geometry.face_edges import edges_of, pair_keys
from geometry.polygon import area_vectors
from numerics.arrays import Flags, Floats, Ints


@dataclass(frozen=True, eq=False)
class Surface:
    """What a model file says, before lines and triangles are derived.

    Attributes
    ----------
    vertices : (V, 3) float64.
    faces : polygons of vertex indices, simple and planar.
    groups : one number per face; the edges between faces of the same group >= 0 are lines of a curved
        surface (seen only as outline). -1: no group.
    drawn : (D, 2) int64, vertex indices of lines that are there whatever the faces say.
    flat_deg, sharp_deg : an edge between two faces whose normals differ by less than `flat_deg` is no line;
        by less than `sharp_deg`, a line of a curved surface; else a line.
    """

    vertices: Floats
    faces: list[Ints]
    groups: Ints
    drawn: Ints
    flat_deg: float
    sharp_deg: float

    def scaled(self, factor: float) -> "Surface":
        """The same surface in another unit."""
        return replace(self, vertices=self.vertices * factor)

    @property
    def content(self) -> bytes:
        """A digest of all that it says."""
        said = hashlib.blake2b(repr((self.flat_deg, self.sharp_deg)).encode())
        corners = np.concatenate([np.empty(0, np.int64), *self.faces])
        counts = np.array([len(face) for face in self.faces], np.int64)
        for part in (self.vertices, corners, counts, self.groups, self.drawn):
            said.update(repr((part.shape, part.dtype)).encode())
            said.update(part.tobytes())
        return said.digest()


def face_normals(vertices: Floats, faces: Sequence[Ints]) -> Floats:
    """Unit normals (F, 3); a face without area raises GeometryError."""
    out = area_vectors(vertices, faces)
    length = np.linalg.norm(out, axis=1)
    if (length == 0).any():
        raise GeometryError(f"face {int(np.argmin(length))} has no area")
    normals: Floats = out / length[:, None]
    return normals


def oriented(surface: Surface) -> tuple[list[Ints], Flags]:
    """Faces with consistent winding, outwards where closed, and which faces can be seen from both sides.

    Faces that share an edge by twos form a component. It is closed when these can be wound alike, and as many
    of it then run one way as the other along each edge that several share, as where it touches itself; then
    its signed volume tells outside from inside.
    """
    faces = surface.faces
    edges = edges_of(faces)
    paired = edges.sharers == 2
    paired[paired] = np.ptp(edges.pairs(paired)[0], axis=1) > 0
    pairs, same_run = edges.pairs(paired)
    component, flipped, open_ended = _wound(len(faces), pairs, same_run)
    sides = np.flatnonzero(np.repeat(~paired, edges.sharers))
    owner = component[edges.face[sides]]
    edge = np.repeat(np.arange(len(paired)), edges.sharers)[sides]
    way = np.where(edges.up[sides] != flipped[edges.face[sides]], 1, -1)
    places, place = np.unique(pair_keys(owner, edge), return_inverse=True)
    open_ended[places[np.bincount(place, way, len(places)) != 0] >> 32] = True
    two_sided = open_ended[component]
    wound = [_turned(face, turn) for face, turn in zip(faces, flipped.tolist(), strict=True)]
    inside_out = (_signed_volumes(surface.vertices, wound, component) < 0)[component] & ~two_sided
    return [_turned(face, turn) for face, turn in zip(wound, inside_out.tolist(), strict=True)], two_sided


def _wound(count: int, pairs: Ints, same_run: Flags) -> tuple[Ints, Flags, Flags]:
    """Components of faces that share edges by twos, and how they are wound as the first of each is.

    Parameters
    ----------
    pairs, same_run : (P, 2), two faces that share an edge; (P,), whether they run along it the same way.

    Returns
    -------
    For each face its component, from 0, and whether it has to be turned; of each component, whether its faces
    cannot be wound alike.
    """
    source, target, same = pairs.ravel(), pairs[:, ::-1].ravel(), np.repeat(same_run, 2)
    order = np.argsort(source, kind="stable")
    begin = np.searchsorted(source[order], np.arange(count + 1)).tolist()  # of each face's neighbours
    neighbours, same_runs = target[order].tolist(), same[order].tolist()
    component, flipped, twisted = [-1] * count, [False] * count, list[bool]()
    for start in range(count):
        if component[start] >= 0:
            continue
        number, queue = len(twisted), [start]
        component[start] = number
        twisted.append(False)
        for f in queue:
            for k in range(begin[f], begin[f + 1]):
                g, turned = neighbours[k], flipped[f] != same_runs[k]
                if component[g] < 0:
                    component[g], flipped[g] = number, turned
                    queue.append(g)
                elif flipped[g] != turned:
                    twisted[number] = True
    return np.array(component, np.int64), np.array(flipped, np.bool_), np.array(twisted, np.bool_)


def _turned(face: Ints, turn: bool) -> Ints:
    return face[::-1].copy() if turn else face


def _signed_volumes(vertices: Floats, faces: list[Ints], component: Ints) -> Floats:
    """What each component (F,) of faces encloses, m^3; negative where they are wound inwards."""
    first = vertices[[face[0] for face in faces]].reshape(-1, 3)
    _, begin = np.unique(component, return_index=True)
    enclosed = (area_vectors(vertices, faces) * (first - first[begin][component])).sum(axis=1) / 3.0
    return np.asarray(np.bincount(component, enclosed))


def wireframe(surface: Surface, faces: list[Ints]) -> tuple[Ints, Ints, Flags]:
    """Lines (L, 2), the faces beside them (L, 2) with -1 for none, and which are smooth (L,)."""
    normals = face_normals(surface.vertices, faces)
    edges = edges_of(faces)
    paired = edges.sharers == 2
    pairs, same_run = edges.pairs(paired)
    flat, smooth = np.zeros((2, len(paired)), dtype=np.bool_)
    flat[paired], smooth[paired] = _flat_and_smooth(surface, normals, pairs, same_run)
    beside = np.full((len(paired), 2), -1)
    beside[paired] = pairs
    beside[edges.sharers == 1, 0] = edges.face[edges.begin[edges.sharers == 1]]
    drawn = np.unique(np.sort(surface.drawn, axis=1), axis=0)
    known, told = pair_keys(*edges.ends.T), pair_keys(*drawn.T)
    is_drawn = np.isin(known, told)
    kept = is_drawn | ~flat
    alone = drawn[~np.isin(told, known)]
    return (
        np.concatenate([edges.ends[kept], alone]),
        np.concatenate([beside[kept], np.full_like(alone, -1)]),
        np.concatenate([(smooth & ~is_drawn)[kept], np.zeros(len(alone), dtype=np.bool_)]),
    )


def _flat_and_smooth(surface: Surface, normals: Floats, pairs: Ints, same_run: Flags) -> tuple[Flags, Flags]:
    """Which edges between two faces each, (P, 2), are no lines, and which are lines of a curved surface."""
    one, other = normals[pairs].transpose(1, 0, 2)
    cosine = (one * other).sum(axis=1) * np.where(same_run, -1.0, 1.0)
    angle_deg = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
    group = surface.groups[pairs]
    of_one_group = (group[:, 0] >= 0) & (group[:, 0] == group[:, 1])
    flat = angle_deg < surface.flat_deg
    return flat, ~flat & (of_one_group | (angle_deg < surface.sharp_deg))
