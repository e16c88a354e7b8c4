"""Meshes are read by trimesh alone: what else it can draw on takes most of its start."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

READ = """\
import sys
from pathlib import Path
from geometry.mesh import read_mesh
for file in sys.argv[1:]:
    print(len(read_mesh(Path(file)).faces))
print(*sorted({"scipy", "networkx"} & sys.modules.keys()))
"""


def test_every_format_is_read_without_other_packages(root: Path, tmp_path: Path) -> None:
    box = trimesh.creation.box((0.1, 0.08, 0.06))
    files = [tmp_path / f"box.{kind}" for kind in ("stl", "obj", "ply", "glb")]
    for file in files:
        box.export(file)
    beside = np.diag([1.0, -1.0, -1.0, 1.0])  # turned by half, ...
    beside[0, 3] = 0.3  # ... and put beside the other
    scene: Any = trimesh.Scene([box])
    scene.add_geometry(box, transform=beside)
    scene.export(tmp_path / "two.glb")
    done = subprocess.run(
        [sys.executable, "-c", READ, *map(str, files), str(tmp_path / "two.glb")],
        cwd=root, capture_output=True, text=True, timeout=60, check=True,
    )  # fmt: skip
    assert done.stdout.splitlines() == ["12", "12", "12", "12", "24", ""]
