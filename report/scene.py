"""What `images/stack.toml` of a run folder tells: camera, model and lights of the session."""

import tomllib
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

import msgspec

from bridge.messages import Vector3
from bridge.result_file import LightTold, Result
from geometry.camera import Camera
from geometry.drawn_wireframes import WIREFRAMES, Wireframes
from geometry.errors import GeometryError
from geometry.model import Model, load_model


class LightRecord(LightTold, frozen=True):
    """A light with its place in the camera frame, m, where that is known."""

    position: Vector3 | None = None


@dataclass(frozen=True)
class Scene:
    """What is needed to draw the model over an image, as far as it is known.

    Attributes
    ----------
    lights : names and numbers of levels, in the order of the settings.
    notes : plain sentences on what is missing.
    wireframes : the model as the vision server has drawn it at its poses (`geometry.drawn_wireframes`);
        None where it draws none, as one of an earlier version.
    """

    camera: Camera | None = None
    model: Model | None = None
    lights: tuple[LightRecord, ...] = ()
    notes: tuple[str, ...] = field(default=())
    wireframes: Wireframes | None = field(default=None, repr=False)


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
        model = _model(path.parent / str(target["model"]), str(target.get("unit", "m")))
    except (KeyError, GeometryError, TypeError, AttributeError) as error:
        notes.append(f"The target in images/stack.toml cannot be used ({_reason(error)}): no overlays.")
    return Scene(camera, model, _lights(table.get("lights")), tuple(notes), _wireframes(folder))


def known_lights(result: Result, scene: Scene) -> tuple[LightRecord, ...]:
    """The session's lights; where they are placed is told by the scene alone."""
    told = tuple(LightRecord(one.name, one.levels) for one in result.lights or ())
    same = len(told) == len(scene.lights) and all(
        one.name == two.name for one, two in zip(told, scene.lights, strict=True)
    )
    return scene.lights if same or not told else told


def _wireframes(folder: Path) -> Wireframes | None:
    try:
        return Wireframes((folder / "images" / WIREFRAMES).read_bytes().splitlines())
    except OSError:
        return None


def _model(file: Path, unit: str) -> Model:
    try:
        changed = file.stat().st_mtime_ns
    except OSError:
        return load_model(file, unit)  # which says what is wrong
    return _read_model(file, unit, changed)


@lru_cache(maxsize=1)  # a page that is watched asks again and again
def _read_model(file: Path, unit: str, _changed_ns: int) -> Model:
    return load_model(file, unit)


def _reason(error: Exception) -> str:
    return f"no {error}" if isinstance(error, KeyError) else str(error)


def _lights(tables: Any) -> tuple[LightRecord, ...]:
    if not isinstance(tables, list):
        return ()
    lights = []
    for table in tables:
        try:
            lights.append(msgspec.convert(table, LightRecord))
        except msgspec.ValidationError:
            lights.append(LightRecord())
    return tuple(lights)
