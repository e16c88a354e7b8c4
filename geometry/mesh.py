"""Triangle meshes (OBJ, STL, PLY, glTF) as surfaces."""

import codecs
import io
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from geometry.errors import GeometryError
from geometry.gltf import FilesBeside, must_be_plain
from geometry.junctions import cut_at_junctions
from geometry.obj_polygons import NO_SUCH_POINT, cut_polygons, lines_alone
from geometry.ply import must_be_few, read_ply
from geometry.polygon import face_areas
from geometry.stl import checked_stl, wrong_in_text
from geometry.surface import Surface
from geometry.text_files import text_of
from numerics.arrays import Floats, Ints

FLAT_DEG = 0.01  # rounding of coordinates; anything above may be part of a fine tessellation
SHARP_DEG = 30.0  # edges bent by more are lines (by hand): by less, facets of curves are; by more, no bevels
ONE_CORNER_SHARE = 1e-6  # of the diameter: facets that meet are written with their own rounding
COARSEST_SHARE = 1e-2  # at most: beyond, as of small parts far from their origin, it is another part
WELDED_SHARE = 1e-4  # likewise, of a mesh most of whose facets share no corner: no two lines are told apart
ON_SIDE_SHARE = 1e-5  # likewise, of a corner on a side of another facet: three decimals of mm, of 0.1 m
MOST_TRIANGLES = 80_000  # 65 000 are read in 0.5 s of processor time; what finer facets add is under a pixel
MOST_READ = 1_500_000  # of a closed mesh, which is made coarser: 1.3 million in 13 s and 1.7 GB
FARTHEST = 1e10  # in the file's unit, from its origin: ten thousand kilometres in millimetres
NOT_WHOLE = "it is damaged, or says what its format does not allow. Export it again"
READ_OFF = 1e-4  # of the diameter, by which it may be off then: 0.1 px of a part that fills the frame


def read_mesh(path: Path) -> Surface:
    """Read a mesh with trimesh; vertices at one place become one; doubles, and triangles without area, go.

    One place is what the rounding of coordinates leaves of it, or steps of 32-bit numbers (ONE_CORNER_SHARE);
    if most facets then still lie loose, WELDED_SHARE.

    Raises
    ------
    GeometryError : a file that trimesh cannot read, more than MOST_TRIANGLES, a point that is not finite.
    """
    import trimesh

    try:
        if path.suffix.lower() == ".obj":
            text = text_of(path)
            points, drawn = lines_alone(text)
            if len(drawn):
                return replace(surface_of_triangles(points, np.empty((0, 3), np.int64)), drawn=drawn)
            mesh = _read_obj(text)
        elif path.suffix.lower() == ".ply":
            mesh = trimesh.Trimesh(*read_ply(path, MOST_READ), process=False)
        elif path.suffix.lower() == ".stl":
            mesh = _read_stl(path)
        else:
            content = path.read_bytes().removeprefix(codecs.BOM_UTF8)
            must_be_plain(content)
            mesh = trimesh.load_mesh(
                io.BytesIO(content),
                file_type=path.suffix.lower()[1:],
                resolver=FilesBeside(path),
                process=False,
            )
        if not isinstance(mesh, trimesh.Trimesh):
            mesh = mesh.to_mesh()
        must_be_few(len(mesh.faces), MOST_READ)
        if not (np.abs(mesh.vertices) <= FARTHEST).all():
            raise GeometryError(f"it has a point that is not finite, or over {FARTHEST:g} from the origin")
        if len(mesh.vertices):
            mesh.vertices = _snapped(np.asarray(mesh.vertices, dtype=np.float64))
        mesh.process()
        mesh.merge_vertices(merge_tex=True, merge_norm=True)
        if len(mesh.vertices) > len(mesh.faces):  # of a closed surface there are half as many
            mesh.vertices = _welded(np.asarray(mesh.vertices, dtype=np.float64))
            mesh.merge_vertices(merge_tex=True, merge_norm=True)
        mesh.update_faces(mesh.nondegenerate_faces())
        vertices = np.array(mesh.vertices, dtype=np.float64).reshape(-1, 3)
        doubled = np.array(mesh.faces, dtype=np.int64).reshape(-1, 3)
        faces = doubled[mesh.unique_faces()]
        if len(faces):
            faces = cut_at_junctions(vertices, faces, ON_SIDE_SHARE * _across(vertices))
        if len(faces) > MOST_TRIANGLES:
            vertices, faces = _fewer(vertices, faces, doubled)
    except FileNotFoundError as error:  # the .bin of a .gltf
        said = f"model {path} needs the file {error.filename or error}, which is not beside it; copy both"
        raise GeometryError(said) from error
    except GeometryError as error:
        raise GeometryError(f"model {path} cannot be read as a mesh: {error}") from error
    except Exception as error:  # trimesh's readers raise whatever their format stumbles on
        raise GeometryError(f"model {path} cannot be read as a mesh: {NOT_WHOLE}") from error
    return surface_of_triangles(vertices, faces)


def _read_obj(text: str) -> Any:
    """The mesh of an OBJ file's text, or what trimesh makes of several."""
    import trimesh

    try:
        return trimesh.load_mesh(io.StringIO(cut_polygons(text)), file_type="obj", process=False)
    except GeometryError:
        raise
    except IndexError as error:
        raise GeometryError(NO_SUCH_POINT) from error
    except ValueError as error:
        raise GeometryError("its points and faces are not all numbers") from error


def _read_stl(path: Path) -> Any:
    """The mesh of an STL file, or what trimesh makes of several."""
    import trimesh

    content = checked_stl(path.read_bytes())
    try:
        return trimesh.load_mesh(io.BytesIO(content), file_type="stl", process=False)
    except ValueError as error:
        raise GeometryError(wrong_in_text(content)) from error


def surface_of_triangles(vertices: Floats, triangles: Ints) -> Surface:
    """The surface of a mesh, (V, 3) and (T, 3); its lines are told by how its facets are bent."""
    return Surface(
        vertices=vertices,
        faces=list(triangles),
        groups=np.full(len(triangles), -1, dtype=np.int64),
        drawn=np.empty((0, 2), dtype=np.int64),
        flat_deg=FLAT_DEG,
        sharp_deg=SHARP_DEG,
    )


def _fewer(vertices: Floats, triangles: Ints, doubled: Ints) -> tuple[Floats, Ints]:
    """A mesh in fewer triangles, none of them more than READ_OFF of its size from its place.

    Parameters
    ----------
    doubled : (U, 3), its triangles as the file has them. Where two bodies touch, each has its own there: with
        one of both left out neither is closed.

    Raises
    ------
    GeometryError : it is not closed, or more than MOST_TRIANGLES are left.
    """
    size = _across(vertices)
    few = simplified(vertices, triangles, READ_OFF * size) or simplified(vertices, doubled, READ_OFF * size)
    if few is None:
        raise GeometryError(
            f"it has {len(triangles)} triangles, and as it is not closed at most {MOST_TRIANGLES} are read. "
            f"Close its holes (of a closed mesh {MOST_READ} are), or export it with a coarser tolerance "
            "(0.1 % of its size will do)"
        )
    if len(few[1]) > MOST_TRIANGLES:
        raise GeometryError(
            f"of its {len(triangles)} triangles {len(few[1])} are left where it is made coarser by "
            f"{100.0 * READ_OFF:g} % of its size, and at most {MOST_TRIANGLES} are read. Export it with a "
            "coarser tolerance (0.1 % of its size will do)"
        )
    _, once = np.unique(np.sort(few[1], axis=1), axis=0, return_index=True)
    return vertices[few[0]], few[1][np.sort(once)]


def _across(vertices: Floats) -> float:
    """The diagonal of the box around vertices (V, 3)."""
    return float(np.linalg.norm(np.ptp(vertices, axis=0)))


def _snapped(vertices: Floats) -> Floats:
    """Vertices (V, 3) of which those at nearly one place are at just one.

    Raises
    ------
    GeometryError : it is so far from its origin that this would change it.
    """
    size = _across(vertices)
    apart = max(ONE_CORNER_SHARE * size, 4.0 * float(np.spacing(np.float32(np.abs(vertices).max()))))
    if apart > COARSEST_SHARE * size > 0.0:
        raise GeometryError(
            f"it is {size:.3g} across, and so far from its origin that numbers of 32 bits say its points to "
            f"{0.25 * apart:.3g} only. Move it to the origin, and export it again"
        )
    place = np.zeros(len(vertices), dtype=np.int64)
    for values in vertices.T:
        order = np.argsort(values, kind="stable")
        cell = np.empty_like(place)
        cell[order] = np.cumsum(np.r_[0, np.diff(values[order]) > apart])
        place = place * len(vertices) + cell
    _, first, which = np.unique(place, return_index=True, return_inverse=True)
    return np.asarray(vertices[first[which]])


def _welded(vertices: Floats) -> Floats:
    """Vertices (V, 3), of which those WELDED_SHARE apart, or with such between them, are at one place."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    if len(vertices) == 0:
        return vertices
    reach = WELDED_SHARE * _across(vertices)
    one, other = cKDTree(vertices).query_pairs(reach, output_type="ndarray").T
    beside = coo_matrix((np.ones(len(one), dtype=bool), (one, other)), shape=(len(vertices), len(vertices)))
    _, first, which = np.unique(
        connected_components(beside, directed=False)[1], return_index=True, return_inverse=True
    )
    return np.asarray(vertices[first[which]])


def simplified(vertices: Floats, triangles: Ints, off: float) -> tuple[Ints, Ints] | None:
    """A closed mesh in fewer facets, by edge collapse (Manifold): vertices that stay (W,), triangles (T, 3).

    None of a mesh that is not closed.

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
    few = number[mesh.tri_verts.astype(np.int64)]
    few = few[(few != np.roll(few, 1, axis=1)).all(axis=1)]  # where bodies touch, each had its own corner
    flat = face_areas(vertices[kept], list(few)) == 0.0
    if flat.any():
        few = cut_at_junctions(vertices[kept], few[~flat], ON_SIDE_SHARE * _across(vertices))
    return kept, few
