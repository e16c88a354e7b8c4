"""Frames from an image server, one after another, perhaps each under another light."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import msgspec
import numpy as np

from bridge.client import ABSENT_S, Client
from bridge.endpoints import CurveClient
from bridge.errors import BadInput, ServerError
from bridge.image_messages import CAPTURE_S, ImageCaptureResult, capture_deadline_s
from bridge.messages import CameraDescription, Describe, Settings
from bridge.received import received, received_frame
from stack.exposure import full_levels
from vision_server.channels.depth import Pixels, Raw

SCHEMES = ("ipc://", "tcp://")


class ServedFrames:
    """What a camera behind an image server sees, at its reference exposure.

    Parameters
    ----------
    endpoint : ipc:///path or tcp://127.0.0.1:PORT.
    switch : only one light is on in each frame, the next one in the next; else all are, in all frames.
    curve : keys, for a server that wants them.

    Attributes
    ----------
    camera : what it tells of its camera.
    gamma : what it tells of the frames' tone curve, linear = grey^gamma; None if nothing.

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
        self.camera: CameraDescription | None = self._described.camera
        self.gamma = None if self.camera is None or self.camera.gamma == 1.0 else self.camera.gamma

    def frames(self, raw: Raw) -> Iterator[tuple[Pixels, float]]:
        """Grey frames (H, W) and when they were taken, s, without end.

        Where the server does not tell what the pixels are, they are ``raw``.
        """
        lights, reference = self._described.lights, self._described.reference
        raw = raw if self.camera is None else Raw(self.camera.bits, self.camera.bayer)
        for only in itertools.cycle(range(len(lights)) if self._switch and lights else [None]):
            settings = Settings(
                full_levels(lights, only),
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
