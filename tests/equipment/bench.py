"""An optical bench that is not there: what an emulated camera sees of a target under emulated lights.

Picture and electrons are the simulator's; the camera's controls act on them as a lens and an amplifier would.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import cv2
import msgspec
import numpy as np

from image_server.simulator.simulator import Simulator
from image_server.v4l2.controls import EXPOSURE_UNIT_S
from numerics.arrays import Field, Grey
from stack.exposure import APERTURES, SHUTTERS_S
from stack.sensor import exposed
from tests.equipment.uvc_model import CameraModel

LARGEST_GAIN = 8.0
"""At the control's maximum, relative to its minimum."""
WIDEST_APERTURE = 2.8
"""f-number of the open iris; the iris control is in proportion to the opening's diameter."""
FIXED_APERTURE = 4.0
FULL_DEFOCUS_PX = 10.0
"""Standard deviation of the blur, iris open, when the focus is off by its whole range."""


class Bench:
    """The picture that falls on the sensor of a camera of some model; `outputs` are the lights' now."""

    def __init__(
        self, simulator: Simulator, model: CameraModel, outputs: Callable[[], Sequence[int]], full: int
    ) -> None:
        self._simulator = simulator
        self._model = model
        self._outputs = outputs
        self._full = full
        self._frames = 0
        self._radiance: tuple[tuple[int, ...], Field] | None = None
        self._best_focus = self._range("focus_absolute")[3]

    def __call__(self, controls: Mapping[str, int]) -> Grey:
        """The frame (H, W) uint8 that an exposure under these values gives."""
        self._frames += 1
        opening = self._fraction("iris_absolute", controls, 1.0)
        image = self._zoomed(self._lit(tuple(self._outputs())), self._magnification(controls))
        low, high, _, _ = self._range("focus_absolute")
        off = abs(controls.get("focus_absolute", self._best_focus) - self._best_focus) / max(1, high - low)
        sensor = self._simulator.sensor
        sensor = msgspec.structs.replace(
            sensor,
            gain=sensor.gain * self._gain(controls),
            apertures=(WIDEST_APERTURE,),
            defocus_sigma_px=sensor.defocus_sigma_px + off * FULL_DEFOCUS_PX,
        )
        aperture = WIDEST_APERTURE / opening if "iris_absolute" in self._model.controls else FIXED_APERTURE
        shutter_s = (
            controls.get("exposure_absolute", round(SHUTTERS_S[2] / EXPOSURE_UNIT_S)) * EXPOSURE_UNIT_S
        )
        return exposed(image, sensor, shutter_s, aperture, (self._frames,))

    def camera_file(self, device: str) -> dict[str, Any]:
        """A camera file for it (docs/hardware.md)."""
        controls = self._model.controls
        automatic = {
            "exposure_auto": 1,
            "exposure_auto_priority": 0,
            "auto_white_balance": 0,
            "focus_auto": 0,
        }
        fixed = {name: value for name, value in automatic.items() if name in controls}
        fixed |= {name: controls[name][0] for name in ("gain", "zoom_absolute") if name in controls}
        if "focus_absolute" in controls:
            fixed["focus_absolute"] = self._best_focus
        file: dict[str, Any] = {
            "device": device,
            "settle_frames": 2,
            "format": {"pixel_format": "YUYV"},
            "controls": fixed,
            "camera": msgspec.to_builtins(self._simulator.describe().camera),
        }
        if "exposure_absolute" in controls:
            values = [round(seconds / EXPOSURE_UNIT_S) for seconds in SHUTTERS_S]
            steps = [[value * EXPOSURE_UNIT_S, value] for value in values]
            file["shutter"] = {"control": "exposure_absolute", "steps": steps}
        low, high, _, _ = self._range("iris_absolute")
        if high > low:
            steps = [[stop, round(high * WIDEST_APERTURE / stop)] for stop in APERTURES]
            file["aperture"] = {"control": "iris_absolute", "steps": steps}
        return file

    def _lit(self, outputs: tuple[int, ...]) -> Field:
        if self._radiance is None or self._radiance[0] != outputs:
            self._radiance = (outputs, self._simulator.radiance_of([value / self._full for value in outputs]))
        return self._radiance[1]

    def _gain(self, controls: Mapping[str, int]) -> float:
        low, high, _, default = self._range("gain")
        value = controls.get("gain", default)
        return 1.0 + (LARGEST_GAIN - 1.0) * (value - low) / max(1, high - low)

    def _magnification(self, controls: Mapping[str, int]) -> float:
        low = self._range("zoom_absolute")[0]
        value = controls.get("zoom_absolute", low)
        return value / low if low > 0 else 1.0 + (value - low)

    def _zoomed(self, image: Field, magnification: float) -> Field:
        if magnification == 1.0:
            return image
        camera = self._simulator.camera
        still_x, still_y = (1 - magnification) * camera.cx, (1 - magnification) * camera.cy
        turn = np.array([[magnification, 0.0, still_x], [0.0, magnification, still_y]])
        return np.asarray(cv2.warpAffine(image, turn, (camera.width, camera.height)), np.float32)

    def _fraction(self, name: str, controls: Mapping[str, int], otherwise: float) -> float:
        """A control as a share of its maximum, never 0."""
        high = self._range(name)[1]
        return max(1, controls.get(name, high)) / high if high > 0 else otherwise

    def _range(self, name: str) -> tuple[int, int, int, int]:
        return self._model.controls.get(name, (0, 0, 0, 0))
