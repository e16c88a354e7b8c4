"""What `images/stack.toml` of a run folder tells: camera, model and lights of the session."""

import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from geometry.camera import Camera
from geometry.errors import GeometryError
from geometry.model import Model, load_model
from report.records import LightRecord


@dataclass(frozen=True)
class Scene:
    """What is needed to draw the model over an image, as far as it is known.

    Attributes
    ----------
    lights : names and numbers of levels, in the order of the settings.
    notes : plain sentences on what is missing.
    """

    camera: Camera | None = None
    model: Model | None = None
    lights: tuple[LightRecord, ...] = ()
    notes: tuple[str, ...] = field(default=())


def read_scene(folder: Path) -> Scene:
    """Read RUN_FOLDER/images/stack.toml; what is missing or broken becomes a note, not an error."""
    path = folder / "images" / "stack.toml"
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return Scene(notes=("There is no images/stack.toml, so camera and model are unknown: no overlays.",))
    except (OSError, ValueError) as error:
        return Scene(notes=(f"images/stack.toml cannot be read ({error}): no overlays.",))
    notes = []
    camera = model = None
    try:
        camera = Camera.from_dict(table["camera"])
    except (KeyError, GeometryError, TypeError) as error:
        notes.append(f"The camera in images/stack.toml cannot be used ({_reason(error)}): no overlays.")
    try:
        target = table["target"]
        model = load_model(path.parent / str(target["model"]), str(target.get("unit", "m")))
    except (KeyError, GeometryError, TypeError, AttributeError) as error:
        notes.append(f"The target in images/stack.toml cannot be used ({_reason(error)}): no overlays.")
    return Scene(camera, model, _lights(table.get("lights")), tuple(notes))


def _reason(error: Exception) -> str:
    return f"no {error}" if isinstance(error, KeyError) else str(error)


def _lights(tables: Any) -> tuple[LightRecord, ...]:
    if not isinstance(tables, list):
        return ()
    lights = []
    for table in tables:
        name = table.get("name") if isinstance(table, dict) else None
        levels = table.get("levels") if isinstance(table, dict) else None
        lights.append(
            LightRecord(
                name if isinstance(name, str) else None,
                levels if isinstance(levels, int) and levels > 0 else None,
            )
        )
    return tuple(lights)
