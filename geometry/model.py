"""A target's wireframe and the faces that hide parts of it, from .cao, OBJ, STL, PLY or glTF files."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np

from geometry.cao import files_of_cao, read_cao
from geometry.errors import GeometryError
from geometry.gltf import files_of_gltf
from geometry.mesh import read_mesh
from geometry.polygon import triangulate
from geometry.pose import Pose
from geometry.surface import Surface, face_normals, oriented, wireframe
from numerics.arrays import Flags, Floats, Ints

UNITS_M = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}
SIZES_MEANT_M = (0.003, 30.0)  # across: parts outside are rare, and files in another unit than told are not
READERS: dict[str, Callable[[Path], Surface]] = {
    ".cao": read_cao,
    ".obj": read_mesh,
    ".stl": read_mesh,
    ".ply": read_mesh,
    ".glb": read_mesh,
    ".gltf": read_mesh,
}
OF_SEVERAL_FILES: dict[str, Callable[[Path], list[Path]]] = {".cao": files_of_cao, ".gltf": files_of_gltf}
SIZES_M = (1e-5, 1e4)  # across: beyond, no camera has seen it, and the unit is wrong
ROUNDED_SHARE = 1e-9  # of the size: a middle so near to the origin is there, but for rounding
TARGETS = Path(__file__).resolve().parent.parent / "targets"


@dataclass(frozen=True, eq=False)
class Model:
    """A target in its own frame.

    Attributes
    ----------
    name : the file's stem.
    vertices : (V, 3) float64, metres.
    lines : (L, 2) int64, vertex indices of the wireframe's lines, each once.
    line_faces : (L, 2) int64, the faces on both sides of a line, -1 = none. A line with more than two
        faces, or drawn on no face's side, has (-1, -1): only the hidden-line test decides on it.
    smooth : (L,) bool, a line of a curved surface: seen only where it is the surface's outline.
    faces : polygons, int64 vertex indices each; they wind outwards where the surface closes. A model of
        lines alone has none: nothing hides its lines.
    face_normals : (F, 3) float64, unit normals.
    two_sided : (F,) bool, faces of surfaces that are not closed; they can be seen from both sides.
    triangles : (T, 3) int64, vertex indices; they tile the faces and wind as these do.
    triangle_face : (T,) int64, the face of each triangle.
    edge_radius_m : of its sharp convex edges, if these are rounded; lines stay where the faces would meet.
    """

    name: str
    vertices: Floats
    lines: Ints
    line_faces: Ints
    smooth: Flags
    faces: tuple[Ints, ...]
    face_normals: Floats
    two_sided: Flags
    triangles: Ints
    triangle_face: Ints
    edge_radius_m: float = 0.0

    @cached_property
    def diameter(self) -> float:
        """Diagonal of the bounding box, metres."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0)))

    @cached_property
    def middle(self) -> Floats:
        """Middle of the bounding box, (3,), metres, shared: not to be written to. A search turns about it."""
        return np.asarray(0.5 * (self.vertices.min(axis=0) + self.vertices.max(axis=0)))

    @classmethod
    def of_surface(cls, name: str, surface: Surface) -> "Model":
        """Orient the faces, find the lines and cut the faces into triangles."""
        faces, two_sided = oriented(surface)
        lines, line_faces, smooth = wireframe(surface, faces)
        triangles = [
            face[None] if len(face) == 3 else face[triangulate(surface.vertices[face])] for face in faces
        ]
        owner = np.repeat(np.arange(len(faces)), [len(part) for part in triangles])
        return cls(
            name=name,
            vertices=surface.vertices,
            lines=lines,
            line_faces=line_faces,
            smooth=smooth,
            faces=tuple(faces),
            face_normals=face_normals(surface.vertices, faces),
            two_sided=two_sided,
            triangles=np.concatenate([np.empty((0, 3), dtype=np.int64), *triangles]),
            triangle_face=owner,
        )


def size_meant(diameter_m: float) -> bool:
    """Whether a part may be so large, or is likelier in another unit than was told."""
    return SIZES_MEANT_M[0] <= diameter_m <= SIZES_MEANT_M[1]


@lru_cache(maxsize=8)
def about_middle(model: Model) -> tuple[Model, Pose]:
    """The model in a frame whose origin is its middle, and model_T_middle; itself if they are one."""
    middle = model.middle
    if np.abs(middle).max() <= ROUNDED_SHARE * model.diameter:
        return model, Pose(np.zeros(3), np.zeros(3))
    return replace(model, vertices=model.vertices - middle), Pose(np.zeros(3), middle)


@dataclass(frozen=True)
class _Read:
    """What was read, equal to what is of the same name and content."""

    name: str
    content: bytes
    surface: Surface = field(compare=False)


@lru_cache(maxsize=8)
def _model_of(read: _Read) -> Model:
    return Model.of_surface(read.name, read.surface)


def load_model(path: str | Path, unit: str = "m") -> Model:
    """Read a model file; its coordinates are in `unit` (m, cm, mm or in).

    A file that says what one before has said gives the same model, with what was derived from it: it is
    shared, and not to be written to.

    Raises
    ------
    GeometryError : an unreadable or malformed file (named with its line), an unknown unit or suffix, a
        model without lines, a mesh without faces.
    """
    path = Path(path)
    if unit not in UNITS_M:
        raise GeometryError(f"unknown unit {unit!r} for model {path}; use one of {', '.join(UNITS_M)}")
    if path.is_dir():
        raise GeometryError(f"model file {path} is a folder")
    if not path.is_file():
        raise GeometryError(f"model file {path} does not exist")
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise GeometryError(
            f"model {path}: unknown kind {path.suffix!r}; use one of {', '.join(READERS)} "
            "(every CAD program exports STL; MeshLab and Blender open other meshes and export these)"
        )
    surface = reader(path)
    if len(surface.vertices) > 0 and (surface.vertices == surface.vertices[0]).all():
        raise GeometryError(f"model {path} has no size: all of its points are in one place")
    if not surface.faces and len(surface.drawn) == 0:
        raise GeometryError(f"model {path} has no faces, and no lines of its own")
    if not np.isfinite(surface.vertices).all():
        raise GeometryError(f"model {path} has a point that is not finite")
    try:
        scaled = surface.scaled(UNITS_M[unit])
        model = _model_of(_Read(path.stem, scaled.content, scaled))
    except GeometryError as error:
        raise GeometryError(f"model {path}: {error}") from error
    if not SIZES_M[0] <= model.diameter <= SIZES_M[1]:
        raise GeometryError(f"model {path} is {model.diameter:.3g} m across; is its unit {unit!r}?")
    if len(model.lines) == 0:
        raise GeometryError(f"model {path} has no lines to match")
    return model


def files_of_model(path: Path) -> list[Path]:
    """The model file, and those beside or below it that it reads; raises as `load_model`."""
    several = OF_SEVERAL_FILES.get(path.suffix.lower())
    return [path] if several is None else several(path)


def find_target(name_or_file: str) -> Path:
    """Path of a target's model: a file as given, or the name of one under `targets/`.

    Raises
    ------
    GeometryError : neither a file nor a known name; the message lists the known ones. A file of another kind
        is for `load_model` to refuse.
    """
    as_file = Path(name_or_file)
    if as_file.is_file():
        return as_file
    if as_file.suffix.lower() in READERS:
        raise GeometryError(f"target file {as_file} does not exist")
    named = TARGETS / f"{name_or_file}.cao"
    if as_file.name == name_or_file and named.is_file():
        return named
    known = ", ".join(sorted(file.stem for file in TARGETS.glob("*.cao")))
    raise GeometryError(
        f"unknown target {name_or_file!r}; known: {known}, or a file ending in {', '.join(READERS)}"
    )
