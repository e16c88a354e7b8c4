"""Whether a glTF file's points can be read: what its reader does not know comes out as another shape."""

import codecs
import json
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from geometry.errors import GeometryError

GLB_HEADER, CHUNK_HEADER = 12, 8  # bytes of a binary file before its JSON: of the file, and of the chunk
COMPRESSIONS = ("KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression")
HARMLESS_FAMILIES = ("KHR_materials_", "KHR_texture_", "EXT_materials_", "EXT_texture_", "MSFT_texture_")
HARMLESS = (
    "KHR_lights_punctual",
    "KHR_mesh_quantization",  # points as integers are read, but for those that stand for fractions
    "KHR_xmp_json_ld",
    "EXT_lights_ies",
    "EXT_lights_image_based",
    "EXT_mesh_features",
    "EXT_structural_metadata",
)
"""Extensions that say how surfaces look, or what they are, and leave them where they are."""
INSTANCES = "EXT_mesh_gpu_instancing"  # where it is not required, one body stands for all
FAN = 6  # mode of a primitive
FLOAT = 5126  # type of an accessor's numbers


class FilesBeside:
    """Content of the files beside a glTF file, by the names it has for them.

    These are URIs, in which a space is `%20` (glTF 2.0, 2.8); some programs write them as they are.
    """

    def __init__(self, file: Path) -> None:
        from trimesh.resolvers import FilePathResolver

        self._files = FilePathResolver(str(file))

    def __getitem__(self, uri: str) -> bytes:
        """Of one file.

        Raises
        ------
        FileNotFoundError : there is none.
        """
        try:
            return bytes(self._files.get(uri))
        except FileNotFoundError:
            return bytes(self._files.get(unquote(uri)))


def files_of_gltf(path: Path) -> list[Path]:
    """A .gltf file, and those that hold its points.

    Raises
    ------
    GeometryError : one of these is neither beside it nor below.
    """
    try:
        buffers = json.loads(path.read_bytes().removeprefix(codecs.BOM_UTF8)).get("buffers", [])
        names = [uri for buffer in buffers if not (uri := buffer.get("uri", "data:")).startswith("data:")]
        files = [
            file if (file := path.parent / name).is_file() else path.parent / unquote(name) for name in names
        ]
        away = [file for file in files if not file.resolve().is_relative_to(path.parent.resolve())]
    except (ValueError, AttributeError, TypeError):  # whoever reads it says what is wrong
        return [path]
    if away:
        raise GeometryError(f"model {path} reads {away[0]}, which is not beside it or below. Copy it there")
    return [path, *files]


def must_be_plain(content: bytes) -> None:
    """Look at what a .gltf or .glb file says that its reader must know (glTF 2.0, 3.6, 3.7 and 3.12).

    Raises
    ------
    GeometryError : its meshes are compressed, sparse, of fractions as integers, of fans, or deformed; it
        requires an extension that may move them; it has no JSON.
    """
    if content.startswith(b"glTF"):
        start = GLB_HEADER + CHUNK_HEADER
        length = int.from_bytes(content[GLB_HEADER : GLB_HEADER + 4], "little")
        content = content[start : start + length]
    try:
        said: Any = json.loads(content)
    except ValueError as error:
        wrong = error if isinstance(error, json.JSONDecodeError) else "no text in UTF-8"
        raise GeometryError(f"it is no glTF file, or was cut short: its JSON is wrong ({wrong})") from error
    if not isinstance(said, dict):
        raise GeometryError("it is no glTF file: its JSON is no object")
    if str(said.get("asset", {}).get("version", "")).startswith("1"):
        raise GeometryError("it is of glTF 1. Export glTF 2")
    for name in said.get("extensionsRequired", []):
        if name in COMPRESSIONS:
            raise GeometryError(f"its meshes are compressed ({name}). Export it without compression")
        if name not in HARMLESS and not name.startswith(HARMLESS_FAMILIES):
            raise GeometryError(f"it requires the extension {name}, which is not read. Export it without it")
    if INSTANCES in said.get("extensionsUsed", []):
        raise GeometryError(f"its bodies are instances ({INSTANCES}). Export it without instancing")
    meshes, nodes = said.get("meshes", []), said.get("nodes", [])
    if any(weight != 0 for thing in meshes + nodes for weight in thing.get("weights", [])):
        raise GeometryError("its meshes are deformed (morph targets). Export it without morph targets")
    if any("skin" in node for node in nodes):
        raise GeometryError("its meshes are deformed (skins). Export it without skins")
    if any("camera" in node and ("mesh" in node or "children" in node) for node in nodes):
        raise GeometryError("its bodies hang on a camera. Export it without cameras")
    for primitive in (primitive for mesh in meshes for primitive in mesh["primitives"]):
        _must_be_plain_triangles(primitive, said.get("accessors", []))


def _must_be_plain_triangles(primitive: dict[str, Any], accessors: list[dict[str, Any]]) -> None:
    """Look at one primitive of a mesh, and at its points and corners.

    Raises
    ------
    GeometryError : they are sparse, or fractions as integers; it is a fan.
    """
    if primitive.get("mode") == FAN:
        raise GeometryError("its meshes are of triangle fans. Export it with plain triangles")
    named = primitive["attributes"].get("POSITION"), primitive.get("indices")
    for accessor in (accessors[number] for number in named if number is not None):
        if "sparse" in accessor:
            raise GeometryError("its meshes are stored as sparse accessors. Export it without them")
        if accessor.get("normalized", False) and accessor.get("componentType") != FLOAT:
            raise GeometryError("its points are normalized integers. Export it without quantization")
