"""Polygon surfaces: winding, closedness, and which of their edges are lines of the wireframe."""

import hashlib
import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from geometry.errors import GeometryError
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


def _edge_faces(faces: Sequence[Ints]) -> dict[tuple[int, int], list[tuple[int, bool]]]:
    """For each undirected edge its faces, and whether the face runs along it from low to high index."""
    out: dict[tuple[int, int], list[tuple[int, bool]]] = defaultdict(list)
    for index, face in enumerate(faces):
        corners = face.tolist()
        for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
            if a != b:
                out[min(a, b), max(a, b)].append((index, a < b))
    return out


def oriented(surface: Surface) -> tuple[list[Ints], Flags]:
    """Faces with consistent winding, outwards where closed, and which faces can be seen from both sides.

    Faces that share an edge by twos form a component. It is closed when each edge of it has two faces and
    these can be wound alike; then its signed volume tells outside from inside.
    """
    faces = surface.faces
    edges = _edge_faces(faces)
    neighbours: list[list[tuple[int, bool]]] = [[] for _ in faces]
    open_face = np.zeros(len(faces), dtype=bool)
    for sharers in edges.values():
        if len(sharers) == 2 and sharers[0][0] != sharers[1][0]:
            (f, f_up), (g, g_up) = sharers
            neighbours[f].append((g, f_up == g_up))
            neighbours[g].append((f, f_up == g_up))
        else:
            open_face[[f for f, _ in sharers]] = True
    flipped = np.zeros(len(faces), dtype=bool)
    two_sided = np.zeros(len(faces), dtype=bool)
    seen = np.zeros(len(faces), dtype=bool)
    for start in range(len(faces)):
        if seen[start]:
            continue
        seen[start] = True
        component, twisted = [start], False
        for f in component:
            for g, same_run in neighbours[f]:
                turned = bool(flipped[f]) != same_run
                if not seen[g]:
                    seen[g], flipped[g] = True, turned
                    component.append(g)
                elif flipped[g] != turned:
                    twisted = True
        if twisted or open_face[component].any():
            two_sided[component] = True
        elif _signed_volume(surface.vertices, [_turned(faces[f], bool(flipped[f])) for f in component]) < 0:
            flipped[component] ^= True
    return [_turned(face, bool(turn)) for face, turn in zip(faces, flipped, strict=True)], two_sided


def _turned(face: Ints, turn: bool) -> Ints:
    return face[::-1].copy() if turn else face


def _signed_volume(vertices: Floats, faces: list[Ints]) -> float:
    first = vertices[[face[0] for face in faces]]
    return float(np.sum(area_vectors(vertices, faces) * (first - first[0])) / 3.0)


def wireframe(surface: Surface, faces: list[Ints]) -> tuple[Ints, Ints, Flags]:
    """Lines (L, 2), the faces beside them (L, 2) with -1 for none, and which are smooth (L,)."""
    normals = face_normals(surface.vertices, faces)
    drawn = {(min(a, b), max(a, b)) for a, b in surface.drawn.tolist()}
    lines: list[tuple[int, int]] = []
    beside: list[tuple[int, int]] = []
    smooth: list[bool] = []
    edges = _edge_faces(faces)
    for edge, sharers in edges.items():
        kind = _kind(surface, normals, sharers)
        if edge in drawn:
            kind = "sharp"
        if kind == "flat":
            continue
        pair = [f for f, _ in sharers] if len(sharers) <= 2 else []
        lines.append(edge)
        beside.append((pair[0] if pair else -1, pair[1] if len(pair) == 2 else -1))
        smooth.append(kind == "smooth")
    for edge in sorted(drawn - edges.keys()):
        lines.append(edge)
        beside.append((-1, -1))
        smooth.append(False)
    return (
        np.array(lines, dtype=np.int64).reshape(-1, 2),
        np.array(beside, dtype=np.int64).reshape(-1, 2),
        np.array(smooth, dtype=bool),
    )


def _kind(surface: Surface, normals: Floats, sharers: list[tuple[int, bool]]) -> str:
    if len(sharers) != 2:
        return "sharp"
    (f, f_up), (g, g_up) = sharers
    cosine = float(normals[f] @ normals[g]) * (-1.0 if f_up == g_up else 1.0)
    angle_deg = math.degrees(math.acos(min(1.0, max(-1.0, cosine))))
    if angle_deg < surface.flat_deg:
        return "flat"
    same_group = surface.groups[f] >= 0 and surface.groups[f] == surface.groups[g]
    return "smooth" if same_group or angle_deg < surface.sharp_deg else "sharp"
