"""A mesh is read without what trimesh looks for and reading needs nothing of, and is the same as with it."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import trimesh

from geometry.mesh import read_mesh

MESHES: Any = trimesh  # untyped
READ = """
import sys
from pathlib import Path
from geometry.mesh import read_mesh
print(read_mesh(Path(sys.argv[1])).content.hex())
print(*sorted({"networkx", "scipy"} & set(sys.modules)))
import scipy.spatial
print(scipy.__name__)
"""


@pytest.mark.parametrize("kind", ["stl", "obj", "ply", "glb", "gltf"])
def test_the_same_is_read_alone(tmp_path: Path, root: Path, kind: str) -> None:
    turned = MESHES.transformations.rotation_matrix(0.5, (1, 2, 3), (0, 0, 4))
    part = MESHES.util.concatenate(
        [MESHES.creation.box((1, 2, 3)), MESHES.creation.icosphere(2).apply_transform(turned)]
    )
    file = tmp_path / f"part.{kind}"
    part.export(file)
    told = subprocess.run(
        [sys.executable, "-c", READ, file], cwd=root, capture_output=True, text=True, timeout=60, check=True
    )
    assert told.stdout.splitlines() == [read_mesh(file).content.hex(), "", "scipy"]
