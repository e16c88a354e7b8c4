"""What changes by itself between captures: the sun turns, the target drifts; and when it is told."""

import math

import numpy as np

from geometry.camera import Camera
from geometry.pose import Pose
from geometry.rotation import matrix_of
from image_server.serve.device import Change
from image_server.simulator.motion import smeared
from image_server.simulator.scenario_tables import Time
from numerics.arrays import Field, Floats


class Drift:
    """The clock of a scene.

    Parameters
    ----------
    time : what changes, and how much of it makes an event.
    pose, sun : at the first capture.
    axis : (3,) unit vector about which the sun turns.
    """

    def __init__(self, time: Time, pose: Pose, sun: Floats, axis: Floats) -> None:
        self._time = time
        self._axis = axis
        self.tell(pose, sun)

    def tell(self, pose: Pose, sun: Floats) -> None:
        """Count changes from here."""
        self._told_pose, self._told_sun = pose, sun

    def advanced(self, pose: Pose, sun: Floats) -> tuple[Pose, Floats, list[Change]]:
        """Pose and sun one capture later, and what is published of it."""
        time = self._time
        seconds = time.seconds_per_capture
        turn = matrix_of(np.radians(time.spin_deg_per_s) * seconds)
        pose = Pose.from_matrix(
            turn @ pose.matrix, pose.translation + np.array(time.velocity_m_per_s) * seconds
        )
        sun = matrix_of(self._axis * math.radians(time.sun_deg_per_s) * seconds) @ sun
        changes = []
        error = pose.error_to(self._told_pose)
        if (
            error.translation_fraction_of_range >= time.target_event_fraction
            or error.rotation_deg >= time.target_event_deg
        ):
            changes.append(Change("target_moved", {"range_m": float(np.linalg.norm(pose.translation))}))
            self._told_pose = pose
        if math.degrees(math.acos(min(1.0, float(sun @ self._told_sun)))) >= time.sun_event_deg:
            changes.append(Change("sun_changed"))
            self._told_sun = sun
        return pose, sun, changes

    @property
    def moves_target(self) -> bool:
        """Whether the target moves by itself."""
        return any(self._time.velocity_m_per_s) or any(self._time.spin_deg_per_s)

    @property
    def stands_still(self) -> bool:
        """Whether nothing changes by itself."""
        return self._time.seconds_per_capture == 0 or not (self.moves_target or self._time.sun_deg_per_s)

    def smeared(self, radiance: Field, camera: Camera, pose: Pose, target: Field, shutter_s: float) -> Field:
        """Radiance (H, W) of an exposure in which the target moves; `target` (H, W) is its 1/depth."""
        if not self.moves_target:
            return radiance
        velocity, spin = np.array(self._time.velocity_m_per_s), np.radians(self._time.spin_deg_per_s)
        return smeared(radiance, camera, pose.translation, velocity, spin, target, shutter_s)
