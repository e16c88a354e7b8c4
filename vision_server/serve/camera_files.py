"""Camera files of OpenCV, ROS, Kalibr and ViSP as a `[camera]` table."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import yaml  # type: ignore[import-untyped]

from bridge.errors import BadInput

MOST_BYTES = 1024 * 1024
MATRICES = ("camera_matrix", "Camera_Matrix", "cameraMatrix", "K")
COEFFICIENTS = ("distortion_coefficients", "Distortion_Coefficients", "distCoeffs", "D")
WIDTHS, HEIGHTS = ("image_width", "image_Width"), ("image_height", "image_Height")
FISHEYES = ("equidistant", "fisheye", "kannala_brandt")  # ROS and Kalibr name one model so
PINHOLES = ("plumb_bob", "rational_polynomial", "radtan", "none", "thin_prism")
MOST_SKEW = 1e-5  # of fx, which is 0.01 px at the edge of a frame of 2000; more is no rounding
TILTED = 14  # coefficients of OpenCV's largest model, of which the last two tilt the sensor
HINT = "Write a TOML file with [camera] instead: width, height, fx, fy, cx, cy, distortion."


def camera_table(path: Path) -> dict[str, Any]:
    """The `[camera]` table of a file of OpenCV (YAML, XML), ROS, Kalibr (both YAML) or ViSP (XML).

    Raises
    ------
    BadInput
        It cannot be read, is none of these, or is of a lens that is not known here.
    """
    try:
        text = path.read_bytes()[: MOST_BYTES + 1].decode("utf-8-sig", "replace")
    except OSError as error:
        raise BadInput(f"Cannot read {path}: {error.strerror or error}.", "Check the path.") from error
    try:
        if len(text) > MOST_BYTES:
            raise _NotReadError(f"it has more than {MOST_BYTES} bytes")
        return _of_xml(text) if text.lstrip().startswith("<") else _of_yaml(text)
    except _NotReadError as error:
        what = str(error)
    except KeyError as error:
        what = f"no {error.args[0]}"
    except (yaml.YAMLError, ElementTree.ParseError) as error:
        what = str(error).split("\n")[0]
    except (ValueError, TypeError, AttributeError, IndexError, OverflowError, RecursionError):
        what = "something in it is no matrix, list or number where there should be one"
    raise BadInput(f"{path} is no camera file that can be read: {what}.", HINT)


class _NotReadError(Exception):
    """A camera that is not known here."""


def _table(
    size: Sequence[Any], focal: Sequence[Any], middle: Sequence[Any], lens: str, k: Any
) -> dict[str, Any]:
    """A `[camera]` table; trailing zeros of ``k`` that ask for a larger model than needed go."""
    coefficients = [float(one) for one in np.ravel(np.asarray(k, dtype=np.float64))]
    if lens == "pinhole":
        if len(coefficients) == TILTED:
            if any(coefficients[12:]):
                raise _NotReadError("its sensor is tilted (14 coefficients), which is not known here")
            coefficients = coefficients[:12]
        coefficients += [0.0] * (5 - len(coefficients))
    known: dict[str, Any] = {
        "width": int(float(size[0])), "height": int(float(size[1])),
        "fx": float(focal[0]), "fy": float(focal[1]), "cx": float(middle[0]), "cy": float(middle[1]),
        "distortion": coefficients,
    }  # fmt: skip
    return known if lens == "pinhole" else {**known, "lens": lens}


def _of_matrix(size: Sequence[Any], matrix: Any, lens: str, k: Any) -> dict[str, Any]:
    found = np.asarray(matrix, dtype=np.float64).reshape(3, 3)
    rest = found - [[found[0, 0], 0.0, found[0, 2]], [0.0, found[1, 1], found[1, 2]], [0.0, 0.0, 1.0]]
    if not np.abs(rest).max() <= MOST_SKEW * abs(found[0, 0]):
        raise _NotReadError(
            "its camera matrix is not fx 0 cx, 0 fy cy, 0 0 1: one with a skew is not known here"
        )
    return _table(size, (found[0, 0], found[1, 1]), (found[0, 2], found[1, 2]), lens, k)


class _Loader(yaml.SafeLoader):  # type: ignore[misc]
    """YAML in which a matrix of OpenCV is a mapping like that of ROS."""


_Loader.add_multi_constructor(
    "tag:yaml.org,2002:opencv-", lambda loader, _, node: loader.construct_mapping(node, deep=True)
)


def _of_yaml(text: str) -> dict[str, Any]:
    text = re.sub(r"^%YAML:.*", "", text)  # as OpenCV writes it, which no other reader takes
    data = next(yaml.load_all(text, _Loader), None)  # a printed message ends with a line of ---
    if not isinstance(data, Mapping):
        raise _NotReadError("it has no names with values")
    if "cam0" in data or "intrinsics" in data:
        return _of_kalibr(data)
    return _of_message(data) if "width" in data else _of_matrices(data)


def _of_xml(text: str) -> dict[str, Any]:
    root = ElementTree.fromstring(text)
    if root.tag != "opencv_storage":
        return _of_visp(root)
    return _of_matrices(
        {one.tag: {"data": one.findtext("data", "").split()} if len(one) else one.text for one in root}
    )


def _of_matrices(data: Mapping[str, Any]) -> dict[str, Any]:
    """A calibration of OpenCV or of ROS: each matrix has its numbers as `data`."""
    size = _first(data, WIDTHS), _first(data, HEIGHTS)
    fisheye = float(data.get("fisheye_model", 0.0)) != 0.0
    lens = "fisheye" if fisheye else _lens(data.get("distortion_model", PINHOLES[0]))
    return _of_matrix(size, _first(data, MATRICES)["data"], lens, _first(data, COEFFICIENTS)["data"])


def _first(data: Mapping[str, Any], names: Sequence[str]) -> Any:
    return data[next((name for name in names if name in data), names[0])]


def _of_message(data: Mapping[str, Any]) -> dict[str, Any]:
    """A CameraInfo as `ros2 topic echo --once` prints it, or `rostopic echo -n 1`, with K and D."""
    known = {name.lower(): value for name, value in data.items()}
    size = known["width"], known["height"]
    region = known.get("roi") or {}
    if max(known.get("binning_x", 0), known.get("binning_y", 0)) > 1:
        raise _NotReadError("its images are binned, and its matrix is of the whole sensor")
    if (region.get("width", 0), region.get("height", 0)) not in ((0, 0), size):
        raise _NotReadError("its images are a part (roi) of those that its matrix is of")
    return _of_matrix(size, known["k"], _lens(known["distortion_model"]), known["d"])


def _of_kalibr(data: Mapping[str, Any]) -> dict[str, Any]:
    camera = data.get("cam0", data)
    if camera.get("camera_model", "pinhole") != "pinhole":
        raise _NotReadError(f"its camera_model is {camera['camera_model']}; pinhole is read")
    fx, fy, cx, cy = camera["intrinsics"]
    lens = _lens(camera.get("distortion_model", "none"))
    return _table(camera["resolution"], (fx, fy), (cx, cy), lens, camera.get("distortion_coeffs", []))


def _of_visp(root: ElementTree.Element) -> dict[str, Any]:
    camera = root if root.tag == "camera" else root.find("camera")
    if camera is None:
        raise KeyError("camera")
    models = {str(model.findtext("type")).strip(): model for model in camera.iter("model")}
    model = models.get("perspectiveProjWithDistortion", models.get("perspectiveProjWithoutDistortion"))
    if model is None:
        raise _NotReadError(f"its model is {', '.join(models) or 'missing'}; perspectiveProj… is read")
    size = _number(camera, "image_width"), _number(camera, "image_height")
    focal, middle = (_number(model, "px"), _number(model, "py")), (_number(model, "u0"), _number(model, "v0"))
    k1 = 0.0 if model.find("kud") is None else _number(model, "kud")
    return _table(size, focal, middle, "pinhole", [k1])


def _number(element: ElementTree.Element, name: str) -> float:
    text = element.findtext(name)
    if text is None:
        raise KeyError(name)
    return float(text)


def _lens(model: str) -> str:
    if model in FISHEYES:
        return "fisheye"
    if model not in PINHOLES:
        raise _NotReadError(f"its distortion_model is {model}; {', '.join((*PINHOLES, *FISHEYES))} are read")
    return "pinhole"
