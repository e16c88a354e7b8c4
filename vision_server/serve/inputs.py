"""What a session or a command starts from: model, camera and seed pose, read from files and checked."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bridge.errors import BadInput
from bridge.messages import MOST_COORDINATE, TargetDescription
from geometry.camera import Camera
from geometry.errors import GeometryError
from geometry.model import Model, load_model, size_meant
from geometry.pose import Pose
from stack.format import CAMERA_ADVICE, GivenTargetTable, camera_file
from stack.tables import read_text, read_toml
from vision_server.channels.depth import Raw
from vision_server.matching.match import Anywhere, seen_sizes_px, sizes_from_px

# Chosen by hand where nothing else is said.
FOREIGN = (".yaml", ".yml", ".xml")  # camera files of other programs
MOST_ROUNDED = 0.1  # of the target's size: lines of what is rounder are no edges any more
MOST_TOLERANCE = 0.05  # of the target's size: what is so far off is another part
USUAL_TOLERANCE = 0.0005  # of it, where nothing is told: usual for machined parts, see docs/pose.md
SIZES_SEEN = (0.02, 20.0)  # of a part, over the frame's width: beyond, unit or seed pose are wrong
FARTHER = 1.1  # than was told, times: what is told is rough
NEAREST = 1e-6  # of the target's size: nearer to its middle a camera has no direction from which it looks


@dataclass(frozen=True)
class GivenCamera:
    """What a camera file gives.

    Parameters
    ----------
    path
        Of the file.
    camera
        Its camera.
    table
        What its ``[camera]`` tells, checked.
    target
        Its ``[target]``.
    """

    path: Path
    camera: Camera
    table: dict[str, Any]
    target: GivenTargetTable

    def anywhere(self, model: Model) -> Anywhere:
        """What ``[target]`` tells where there is no seed pose; raises as `told_anywhere`."""
        return told_anywhere(self.target, model, self.camera, f"{self.path}: [target]")

    def tolerance_m(self, model: Model) -> float | None:
        """``[target] tolerance_m``: how far lines of the part may be off the model's; None if untold."""
        told = self.target.tolerance_m
        return None if told is None else checked_tolerance(told, model, f"{self.path}: [target] ")

    def edge_radius_m(self, model: Model) -> float | None:
        """``[target] edge_radius_m``: by how much the target's edges are rounded; None if untold."""
        told, name = self.target.edge_radius_m, f"{self.path}: [target] edge_radius_m"
        return None if told is None else checked_edge_radius(told, model, name)


def read_camera_file(path: Path) -> GivenCamera:
    """A TOML file with ``[camera]`` (or nothing else), and perhaps ``[target]``.

    Files of OpenCV, ROS, Kalibr and ViSP are read, too, see `camera_table`.

    Raises
    ------
    BadInput
        It cannot be read, or has no camera that can be used.
    """
    if path.suffix.lower() in FOREIGN:
        from vision_server.serve.camera_files import camera_table  # most sessions do without YAML and XML

        data = camera_table(path)
    else:
        data = read_toml(path, "camera file")
    file, table = camera_file(data, path)
    try:
        return GivenCamera(path, Camera.from_dict(table), table, file.target)
    except GeometryError as error:
        raise BadInput(f"{path}: {error}.", CAMERA_ADVICE) from error


def read_camera(path: Path) -> tuple[Camera, dict[str, Any]]:
    """The camera of a file, and what its ``[camera]`` tells; raises as `read_camera_file`."""
    given = read_camera_file(path)
    return given.camera, given.table


def told_raw(table: Mapping[str, Any], bits: int | None = None) -> Raw:
    """What [camera] says of its pixels: `bits`, in images of 16, and `bayer`; else ``bits`` are as given."""
    return Raw(table.get("bits", bits), table.get("bayer", False))


def read_seed_pose(path: Path, model: Model) -> Pose:
    """The seed pose of a TOML file with ``[target.seed_pose]``, ``[seed_pose]`` or nothing but a pose.

    Of a JSON file as `read_pose`.
    """
    data: Any = _told_pose(path, "seed pose")
    for key in ("target", "seed_pose"):
        if isinstance(data, dict) and key in data:
            data = data[key]
    advice = "Give [target.seed_pose] with rotation_vector and translation."
    if not isinstance(data, dict):
        raise BadInput(f"{path}: the seed pose is not a table.", advice)
    return _pose_of(data, path, model, advice)


def read_pose(path: Path, model: Model) -> Pose:
    """The pose of a TOML file with ``rotation_vector`` and ``translation``, in no table.

    Or that of one JSON object, as commands and sessions tell it, with ``pose`` or nothing but a pose.

    Raises
    ------
    BadInput
        It cannot be read, or is no pose of the model. A seed pose, as of a stack, is not taken for one.
    """
    advice = "Give rotation_vector and translation at its top, in no [table]."
    return _pose_of(_told_pose(path, "pose"), path, model, advice)


def _pose_of(table: Mapping[str, Any], path: Path, model: Model, advice: str) -> Pose:
    """The pose of a file's table, or BadInput with the advice where it has none."""
    try:
        return checked_pose(Pose.from_dict(table), model)
    except GeometryError as error:
        told = all(name in table for name in ("rotation_vector", "translation"))
        hint = "It is camera_T_target, rad and metres." if told else advice
        raise BadInput(f"{path}: {error}.", hint) from error


def _told_pose(path: Path, what: str) -> dict[str, Any]:
    """Plain values of a TOML file, or the pose of a JSON file; raises as `read_toml`."""
    if path.suffix.lower() != ".json":
        return read_toml(path, what)
    try:
        told = json.loads(read_text(path, what, "JSON"))
    except (ValueError, RecursionError) as error:
        raise BadInput(
            f"{path} is not one JSON object: {error}.", "Give a single line of what track prints."
        ) from None
    if isinstance(told, dict) and "pose" in told:
        told = told["pose"]
    if not isinstance(told, dict):
        raise BadInput(f"{path} tells no pose.", "Give an object with one; a lost target has none.")
    return told


def untold_tolerance_m(told: float | None, model: Model) -> float:
    """How far lines of a part may be off the model's where nobody has ``told``, m; 0 where one has."""
    return USUAL_TOLERANCE * model.diameter if told is None else 0.0


def checked_tolerance(value: Any, model: Model, whose: str = "Parameter ") -> float:
    """A tolerance in metres, as it is used; raises as `_checked_length`."""
    advice = "half a permille is usual for machined parts"
    return _checked_length(value, model, MOST_TOLERANCE, f"{whose}tolerance_m", advice)


def checked_edge_radius(value: Any, model: Model, name: str) -> float:
    """The radius of rounded edges in metres, as it is used; raises as `_checked_length`."""
    return _checked_length(value, model, MOST_ROUNDED, name, "0 is for sharp edges")


def _checked_length(value: Any, model: Model, share: float, name: str, advice: str) -> float:
    """A length in metres.

    Raises
    ------
    BadInput
        No number, negative, or more than a share of the model's size.
    """
    most = share * model.diameter
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0.0 <= value <= most:
        raise BadInput(
            f"{name} must be a number from 0 to {most:.3g} m, not {value!r}.",
            f"At most {share:.0%} of the model's size; {advice}.",
        )
    return float(value)


def checked_pose(pose: Pose, model: Model) -> Pose:
    """The pose, whose target must be in front of the camera.

    Raises
    ------
    GeometryError
        A number beyond those of the messages; the middle of the target is not in front of the camera, or the
        camera is there.
    """
    for name, values in pose.to_dict().items():
        if max(map(abs, values)) > MOST_COORDINATE:
            raise GeometryError(f"pose {name} must be at most {MOST_COORDINATE:g}, got {values}")
    middle = pose.apply(model.middle[None])[0]
    depth = middle[2]
    if not depth > 0.0:
        raise GeometryError(f"the target is behind the camera (z = {depth:g} m)")
    if not np.linalg.norm(middle) > NEAREST * model.diameter:
        raise GeometryError(f"the camera is in the middle of the target (z = {depth:g} m)")
    return pose


def read_model(path: Path, unit: str = "m") -> Model:
    """A model file; geometry's errors become BadInput."""
    try:
        return load_model(path, unit)
    except GeometryError as error:
        raise BadInput(f"{str(error).rstrip('.')}.", "Check the model file and its unit.") from error


def picture_px(model: Model, camera: Camera, seed_pose: Pose) -> float:
    """How large a model in front of the camera is in its image, px."""
    return float(model.diameter * camera.fx / seed_pose.apply(model.middle[None])[0, 2])


def told_anywhere(
    target: GivenTargetTable | TargetDescription, model: Model, camera: Camera, whose: str
) -> Anywhere:
    """What is told of a target of which there is no seed pose.

    Raises
    ------
    BadInput
        No distances, or no direction; distances from which the model would not be seen in the frame.
    """
    try:
        told = Anywhere(target.range_m, target.view)
    except GeometryError as error:
        raise BadInput(f"{whose}: {error}.", CAMERA_ADVICE) from error
    if told.range_m is not None:
        largest, smallest = sizes_from_px(told.range_m, model.diameter, camera)
        least, most = seen_sizes_px(camera)
        if largest < least or smallest > most:
            raise BadInput(
                f"{whose}: range_m = [{told.range_m[0]:g}, {told.range_m[1]:g}]: the model is"
                f" {model.diameter:.3g} m across and would be {smallest:.3g} to {largest:.3g} px wide.",
                "Give metres, and check the unit of the model (--unit).",
            )
    return told


def range_warning(model: Model, pose: Pose, told: Anywhere) -> str | None:
    """What to say of a pose at another distance than was told: sizes in the image tell no unit."""
    if told.range_m is None:
        return None
    away = float(np.linalg.norm(pose.apply(model.middle[None])))
    if told.range_m[0] / FARTHER <= away <= told.range_m[1] * FARTHER:
        return None
    return (
        f"the pose is {away:.3g} m away; [target] range_m says {told.range_m[0]:g} to {told.range_m[1]:g} m. "
        "The unit of the model (--unit), fx of the camera or range_m is wrong."
    )


def model_warning(model: Model, camera: Camera, seed_pose: Pose | None) -> str | None:
    """What to say of a model before it is looked for: of its size, and of what it does not tell."""
    size = _unit_warning(model) if seed_pose is None else size_warning(model, camera, seed_pose)
    turn = None if seed_pose is None else _turn_warning(seed_pose)
    faces = None
    if not model.faces:
        faces = (
            "the model has no faces. None of its lines is taken for hidden, nor a wrong side told, and what "
            "lights will show is not foreseen."
        )
    return " ".join(said for said in (size, turn, faces) if said) or None


def _turn_warning(pose: Pose) -> str | None:
    """What to say of a rotation that turns more than once: no program tells one so, but in degrees."""
    length = float(np.linalg.norm(pose.rotation_vector))
    if length <= 2.0 * math.pi:
        return None
    return (
        f"the pose's rotation_vector is {length:.3g} rad long, more than a whole turn. Is it in degrees? "
        "It is the axis times the angle in rad."
    )


def _unit_warning(model: Model) -> str | None:
    """What to say of a model whose size is likelier a wrong unit, where no seed pose tells."""
    if size_meant(model.diameter):
        return None
    return (
        f"the model is {model.diameter:.3g} m across. If the part is not, --unit is wrong, and the pose is "
        "as much too near or too far."
    )


def size_warning(model: Model, camera: Camera, seed_pose: Pose) -> str | None:
    """What to say when a model in front of the camera is far too large or too small for its frame."""
    share = picture_px(model, camera, seed_pose) / camera.width
    if SIZES_SEEN[0] <= share <= SIZES_SEEN[1]:
        return None
    unit, range_m = "mm" if share > 1.0 else "m", float(np.linalg.norm(seed_pose.apply(model.middle[None])))
    return (
        f"the model is {model.diameter:.3g} m across and would be {share:.2g} times as wide as the frame "
        f"from a pose {range_m:.3g} m away. Check the model's unit (--unit {unit}?) and the pose's, metres."
    )
