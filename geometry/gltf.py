"""Whether a glTF file's points can be read: compressed ones come out as zeros, or not at all."""

import json
from typing import Any

from geometry.errors import GeometryError

GLB_HEADER, CHUNK_HEADER = 12, 8  # bytes of a binary file before its JSON: of the file, and of the chunk
COMPRESSIONS = ("KHR_draco_mesh_compression", "EXT_meshopt_compression")


def must_be_uncompressed(content: bytes) -> None:
    """Look at what a .gltf or .glb file says that its reader must know; what is no glTF file passes.

    Raises
    ------
    GeometryError : its meshes are compressed.
    """
    if content.startswith(b"glTF"):
        start = GLB_HEADER + CHUNK_HEADER
        length = int.from_bytes(content[GLB_HEADER : GLB_HEADER + 4], "little")
        content = content[start : start + length]
    try:
        said: Any = json.loads(content)
    except ValueError:  # it has no JSON: its reader says what is wrong
        return
    required = said.get("extensionsRequired", []) if isinstance(said, dict) else []
    for name in COMPRESSIONS:
        if name in required:
            raise GeometryError(f"its meshes are compressed ({name}). Export it without compression")
