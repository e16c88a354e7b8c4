"""Frames from an image server, one after another, perhaps each under another light."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Self

import msgspec
import numpy as np

from bridge.client import ABSENT_S, Client
from bridge.endpoints import CurveClient
from bridge.errors import BadInput, ServerError
from bridge.image_messages import CAPTURE_S, ImageCaptureResult, capture_deadline_s
from bridge.messages import CameraDescription, Describe, LightDescription, Settings
from bridge.received import received, received_frame
from vision_server.channels.depth import Pixels, Raw

SCHEMES = ("ipc://", "tcp://")


class ServedFrames:
    """What a camera behind an image server sees, at its reference exposure.

    Parameters
    ----------
    endpoint : ipc:///path or tcp://127.0.0.1:PORT.
    switch : only one light is on in each frame, the next one in the next; else all are, in all frames.
    curve : keys, for a server that wants them.

    Raises
    ------
    BridgeAbsent : nobody is there.
    BridgeTimeout : nobody answers there.
    ServerError : the server cannot.
    BadInput : what answers is no image server.
    """

    def __init__(self, endpoint: str, switch: bool = False, curve: CurveClient | None = None) -> None:
        self.endpoint, self._switch = endpoint, switch
        self._client = Client(endpoint, CAPTURE_S, curve=curve, absent_s=ABSENT_S)
        try:
            self._described = received(self._client.request("describe")[0], Describe)
        except (ServerError, msgspec.ValidationError) as error:
            self._client.close()
            raise BadInput(f"{endpoint} is no image server: {error}.") from error
        except BaseException:
            self._client.close()
            raise

    @property
    def camera(self) -> CameraDescription | None:
        """What it tells of its camera."""
        return self._described.camera

    @property
    def gamma(self) -> float | None:
        """What it tells of the frames' tone curve, linear = grey^gamma; None if nothing."""
        camera = self._described.camera
        return None if camera is None or camera.gamma == 1.0 else camera.gamma

    def frames(self, raw: Raw) -> Iterator[tuple[Pixels, float]]:
        """Grey frames (H, W) and when they were taken, s, without end.

        Parameters
        ----------
        raw : what the pixels are, where the server does not tell.
        """
        camera, reference = self._described.camera, self._described.reference
        raw = raw if camera is None else Raw(camera.bits, camera.bayer)
        for number in itertools.count():
            settings = Settings(
                levels(self._described.lights, number if self._switch else None),
                reference.shutter_s,
                reference.aperture,
                next(iter(self._described.focal_lengths_mm or ()), None),
                next(iter(self._described.focuses_m or ()), None),
            )
            asked = {"settings": msgspec.to_builtins(settings)}
            told, arrays = self._client.request("capture", asked, capture_deadline_s(settings))
            header = received(told, ImageCaptureResult)
            pixels = received_frame(header, arrays, self.endpoint)
            yield raw.grey(np.array(pixels)), header.timestamp

    def close(self) -> None:
        """Leave the server to others."""
        self._client.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def levels(lights: tuple[LightDescription, ...], number: int | None) -> tuple[int, ...]:
    """All lights full, or but one of them: that of the frame of this number, in turn."""
    return tuple(
        light.levels - 1 if number is None or index == number % len(lights) else 0
        for index, light in enumerate(lights)
    )
