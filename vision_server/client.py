"""The vision server from Python: images or frames in, poses out, and judgements of poses from elsewhere."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Self

import numpy as np

from bridge.arrays import DTYPES, FramePixels
from bridge.client import ABSENT_S, Client
from bridge.errors import BadInput, LightsAndCameraError
from bridge.keys import client_keys

SHUTTER_S, APERTURE = 1 / 60, 4.0  # of an image of exposure 1; only ratios matter
LAST_S = 1.0  # for a server to hear that a session that failed has ended; chosen by hand


class Vision:
    """A session with one target and one camera on a running vision server; `with` ends it.

    It is for one thread at a time, as it has one connection; another thread opens its own.

    Parameters
    ----------
    endpoint : where `python -m vision_server serve --endpoint ...` listens.
    model : the target's model file, as the server finds it, whose folder may be another one.
    camera : a TOML file with [camera], or that table.
    seed_pose : camera_T_target about where the target is: rotation_vector (rad) and translation (m); None:
        it is looked for everywhere.
    unit : of the model file.
    timeout_s : deadline of each request.
    keys : folder of CURVE keys, for a server that has them (`python -m bridge keys DIR`).

    Raises
    ------
    ServerError : what the server says of bad input; so does each method.
    BridgeTimeout : no answer in time; so does each method.
    BridgeAbsent : nobody is there, or nobody any more; so does each method.
    BridgeRefused : the server has keys, and lets in no one without, or with others.
    BadInput : keys that cannot be used, a pose or an image that is none; of a method, that the session has
        ended.
    """

    def __init__(
        self,
        endpoint: str,
        model: str | Path,
        camera: str | Path | Mapping[str, Any],
        seed_pose: Mapping[str, Any] | None = None,
        unit: str = "m",
        timeout_s: float = 20.0,
        keys: str | Path | None = None,
    ) -> None:
        args: dict[str, Any] = {"model": str(model), "unit": unit}
        args |= {"first_sight": True} if seed_pose is None else {"seed_pose": _pose(seed_pose)}
        if isinstance(camera, Mapping):
            args["camera"] = dict(camera)
        else:
            args["camera_file"] = str(camera)
        self._numbers = itertools.count(1)
        curve = None if keys is None else client_keys(Path(keys), "controller", "vision_server")
        self._client = Client(endpoint, timeout_s, curve=curve, absent_s=ABSENT_S)
        try:
            self._client.request("start", args)
        except BaseException:
            self._client.close()
            raise

    def track(self, frame: FramePixels, time_s: float | None = None) -> dict[str, Any]:
        """The pose in the next frame (H, W): `frame`, `state`, `pose`, `covariance` and more."""
        return self._client.request("track", {"time_s": time_s}, arrays=[_sendable(frame)])[0]

    def estimate(self, *images: FramePixels, exposures: Sequence[float] = ()) -> dict[str, Any]:
        """The pose in images (H, W) of a still scene under any lights: `pose` or None, `covariance` and more.

        ``exposures`` are shutter times over squared apertures, relative to each other; none: equal ones.
        """
        with self._added(images, exposures) as names:
            return self._client.request("estimate", {"images": names})[0]

    def check(
        self, pose: Mapping[str, Any] | None, *images: FramePixels, exposures: Sequence[float] = ()
    ) -> dict[str, Any]:
        """Whether a pose is right, by images of a still scene: `probability`, `state`, `better` and more."""
        args = {"pose": _pose(pose)}
        with self._added(images, exposures) as names:
            return self._client.request("check", args | {"images": names})[0]

    @contextmanager
    def _added(self, images: Sequence[FramePixels], exposures: Sequence[float]) -> Iterator[list[str]]:
        """Names of images that are the server's meanwhile."""
        if exposures and len(exposures) != len(images):
            raise BadInput(
                f"{len(images)} images and {len(exposures)} exposures.", "Give one for each image, or none."
            )
        names: list[str] = []
        try:
            for image, exposure in zip(images, exposures or (1.0,) * len(images), strict=True):
                settings = {"lights": [], "shutter_s": SHUTTER_S * exposure, "aperture": APERTURE}
                name = f"image{next(self._numbers)}"
                args = {"image": name, "settings": settings}
                self._client.request("add", args, arrays=[_sendable(image)])
                names.append(name)
            yield names
        except BaseException:
            with suppress(LightsAndCameraError):  # what went wrong is told, not that this does, too
                self._discard(names)
            raise
        self._discard(names)

    def _discard(self, names: Sequence[str]) -> None:
        for name in names:
            self._client.request("discard", {"image": name})

    def __enter__(self) -> Self:
        return self

    def __exit__(self, failed: type[BaseException] | None, *_: object) -> None:
        try:
            if failed is None:
                self._client.request("end")
            else:  # of a server that is gone, the first error tells
                with suppress(LightsAndCameraError):
                    self._client.request("end", timeout_s=LAST_S)
        finally:
            self._client.close()


def _sendable(image: FramePixels) -> FramePixels:
    """What is sent of an image; of what shape it should be, the server says."""
    if image is None:
        raise BadInput("None is no image.", "cv2.imread gives it where it cannot read a file: is it there?")
    array = np.ascontiguousarray(image)
    if array.dtype.name not in DTYPES:
        raise BadInput(
            f"An image is an array (H, W) of uint8 or uint16, not of {array.dtype}.", "Convert it to grey."
        )
    return array


def _pose(told: Mapping[str, Any] | None) -> dict[str, Any]:
    """What is sent of a pose."""
    if told is None:
        raise BadInput("None is no pose.", "Of a frame where the target is lost there is none to check.")
    if not isinstance(told, Mapping):
        raise BadInput(
            f"A pose is a mapping, not a {type(told).__name__}.",
            "Give rotation_vector (rad) and translation (m) of camera_T_target.",
        )
    return dict(told)
