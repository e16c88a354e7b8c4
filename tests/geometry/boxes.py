"""Small models for tests of symmetries."""

from pathlib import Path

import numpy as np

from geometry.model import Model, load_model
from numerics.arrays import Floats

BOX_FACES = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))


def model_of(folder: Path, points: Floats, faces: list[tuple[int, ...]]) -> Model:
    """A model by way of its file."""
    lines = ["V1", str(len(points)), *(" ".join(f"{value:.9f}" for value in point) for point in points)]
    lines += [
        "0",
        "0",
        str(len(faces)),
        *(" ".join(map(str, (len(face), *face))) for face in faces),
        "0",
        "0",
    ]
    file = folder / "model.cao"
    file.write_text("\n".join(lines))
    return load_model(file)


def box(folder: Path, *sides: float, slant: float = 0.0) -> Model:
    """A box off the origin; two corners of its right side are moved to slant it."""
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=np.float64) * sides
    corners[[3, 7], 0] -= slant
    return model_of(folder, corners + 0.3, list(BOX_FACES))
