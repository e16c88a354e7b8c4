"""A laboratory as a device: a V4L2 camera, and lights on a serial line or none."""

from collections.abc import Callable
from typing import Any

import msgspec

from bridge.errors import DeviceError
from bridge.messages import CameraDescription, Describe, Settings, TargetDescription
from image_server.lights.rig import LightRig, Lit
from image_server.serve.device import Change, Device, Frame, checked_settings
from image_server.v4l2.camera import V4L2Camera

NO_LIGHTS = Lit(levels=(), verified=True, steady_at=0.0)


class Hardware(Device):
    """Camera and lights.

    A light that dies is told as `light_fault` and stays off; frames that ask for it say so in their
    applied settings, and tell it again. A camera that fails is told as `camera_fault`, and the capture is an
    error.

    Parameters
    ----------
    camera : an open camera.
    lights : open lights; None is a laboratory with its own light only.
    description : calibration of the camera, where the camera file has none.
    target : what to look for, where that is known here.
    """

    name = "hardware"

    def __init__(
        self,
        camera: V4L2Camera,
        lights: LightRig | None = None,
        description: CameraDescription | None = None,
        target: TargetDescription | None = None,
    ) -> None:
        self._camera = camera
        self._lights = lights
        self._captures = 0
        self._notify: Callable[[Change], None] = lambda _change: None
        self._camera_fault: str | None = None
        file = camera.file
        self._describe = Describe(
            device=self.name,
            lights=() if lights is None else lights.lights,
            shutters_s=camera.shutters_s,
            apertures=file.aperture.values,
            focal_lengths_mm=None if file.focal_length is None else file.focal_length.values,
            focuses_m=None if file.focus is None else file.focus.values,
            camera=description if description is not None else file.camera,
            target=target,
            ranges=camera.ranges(),
        )
        self._devices = {"camera": camera.identity}
        if lights is not None:
            self._devices["lights"] = lights.identity

    def listen(self, notify: Callable[[Change], None]) -> None:
        """Tell of lights that die and of a camera that fails."""
        self._notify = notify
        if self._lights is not None:
            self._lights.listen(lambda name, why: notify(_light_fault(name, why)))

    def describe(self) -> Describe:
        """What camera file and lights file offer."""
        self._heard()
        return self._describe

    def capture(self, settings: Settings) -> Frame:
        """Set lights and camera, wait until both are steady, and take a fresh frame."""
        self._heard()
        asked = checked_settings(self._describe, settings)
        lit = NO_LIGHTS if self._lights is None else self._lights.light(asked.lights)
        try:
            exposure = self._camera.capture(asked, lit.steady_at)
        except DeviceError as error:
            self._camera_fault = error.message
            self._notify(Change("camera_fault", {"reason": error.message}))
            raise
        self._camera_fault = None
        self._captures += 1
        self._heard()
        still = lit if self._lights is None else self._lights.present()
        self._tell_again(asked)
        applied = msgspec.structs.replace(asked, lights=still.levels, **exposure.applied)
        return Frame(
            pixels=exposure.pixels,
            requested=settings,
            applied=applied,
            verified=exposure.verified and lit.verified and still == lit,
            sequence=self._captures,
            timestamp=exposure.timestamp,
            devices=self._devices,
        )

    def health(self) -> dict[str, Any]:
        """State of both; `status` is "ok" when all is well, else it says what is not."""
        self._heard()
        lights = None if self._lights is None else self._lights.health()
        status = "ok"
        if lights is not None and lights["dead_lights"]:
            status = f"dead lights: {', '.join(lights['dead_lights'])}"
        if self._camera_fault is not None:
            status = self._camera_fault
        return {
            "status": status,
            "captures": self._captures,
            "camera": self._camera.health(),
            "lights": lights,
        }

    def close(self) -> None:
        """Lights out, camera free."""
        if self._lights is not None:
            self._lights.close()
        self._camera.close()

    def _tell_again(self, asked: Settings) -> None:
        """Who asks for a dead light was not there when it died: an event reaches only those who listen."""
        dead = {} if self._lights is None else self._lights.dead
        for light, level in zip(self._describe.lights, asked.lights, strict=True):
            if level and light.name in dead:
                self._notify(_light_fault(light.name, dead[light.name]))

    def _heard(self) -> None:
        if self._lights is not None:
            self._lights.heard()


def _light_fault(name: str, why: str) -> Change:
    return Change("light_fault", {"light": name, "reason": why})
