"""Constant-velocity motion of the target: an error-state Kalman filter that adapts to its innovations."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from geometry.camera import Camera
from geometry.pose import Pose
from geometry.rotation import cross_matrix, matrix_of, vector_of
from numerics.arrays import Floats

# How much the velocity changes in a second, one sd, at agility 1. From one frame to the next, at 30 a second,
# that moves a target from rest by 3 degrees and 1 % of the range, some 8 px.
TURN_RATE_CHANGE_RAD_S2, SPEED_CHANGE_RANGES_S2 = 47.0, 9.0
# By hand. Agility follows smaller and larger innovations with these powers, one of which counts for so many
# times its expectation at most: a target that starts to move is met at once, one that stops slowly.
LEAST_AGILITY, MOST_AGILITY = 0.02, 1.0
CALMED_POWER, STARTLED_POWER, MOST_SURPRISE_RATIO = 0.15, 1.0, 9.0
FIRST_TURN_RATE_RAD_S, FIRST_SPEED_RANGES_S = 2.0, 0.5  # one sd, of a target that was just found


class Innovation(NamedTuple):
    """A measured pose beside the one that was expected.

    Attributes
    ----------
    step, spread : (6,), from the expected rotation (rad) and middle (m), and its covariance (6, 6).
    measured : (6, 6), the part of that which is the measured pose's.
    squared : the step's square in units of its covariance: 6 on average (NIS).
    """

    step: Floats
    spread: Floats
    measured: Floats
    squared: float


@dataclass(frozen=True, eq=False)
class Motion:
    """Where a target is and how it moves.

    Attributes
    ----------
    rotation : (3, 3), of camera_T_target.
    centre : (3,), the target's middle in the camera frame, m.
    velocity : (6,), turn rate rad/s and velocity of the middle m/s, camera frame.
    covariance : (12, 12), of errors of rotation (left-multiplied, rad), middle (m) and both velocities.
    agility : how much the velocity changes, as a share of the most that is expected.
    """

    rotation: Floats
    centre: Floats
    velocity: Floats
    covariance: Floats
    agility: float = MOST_AGILITY

    @classmethod
    def at_rest(cls, pose: Pose, covariance: Floats, middle: Floats) -> Motion:
        """A target that was just found: its velocity is not known.

        Parameters
        ----------
        covariance : (6, 6), of a left-multiplied step of the pose.
        middle : (3,), of the target, in its own frame, m.
        """
        centre = pose.apply(middle[None])[0]
        speed = FIRST_SPEED_RANGES_S * float(np.linalg.norm(centre))
        full = np.diag(np.repeat([0.0, FIRST_TURN_RATE_RAD_S**2, speed**2], [6, 3, 3]))
        full[:6, :6] = about(centre, covariance)
        return cls(pose.matrix, centre, np.zeros(6), full)

    def pose(self, middle: Floats) -> Pose:
        """camera_T_target, of a target with this middle (3,)."""
        return Pose.from_matrix(self.rotation, self.centre - self.rotation @ middle)

    def spread_px(self, camera: Camera, radius_m: float) -> float:
        """How exactly the pose is foreseen: one sd in the image of points so far from the middle."""
        variance = self.covariance.diagonal()
        total = radius_m**2 * variance[:3].sum() + variance[3:6].sum()
        return camera.fy / float(np.linalg.norm(self.centre)) * math.sqrt(total / 3.0)

    def after(self, seconds: float) -> Motion:
        """The target so much later, at the same velocity."""
        step = self.velocity * seconds
        carry = np.eye(12)
        carry[:6, 6:] = seconds * np.eye(6)
        range_m = float(np.linalg.norm(self.centre))
        change = self.agility * np.repeat([TURN_RATE_CHANGE_RAD_S2, SPEED_CHANGE_RANGES_S2 * range_m], 3)
        push = np.vstack([np.diag(0.5 * seconds**2 * change), np.diag(seconds * change)])
        return replace(
            self,
            rotation=matrix_of(step[:3]) @ self.rotation,
            centre=self.centre + step[3:],
            covariance=carry @ self.covariance @ carry.T + push @ push.T,
        )

    def innovation(self, pose: Pose, covariance: Floats, middle: Floats) -> Innovation:
        """Of a pose that was measured now, of this covariance (6, 6)."""
        centre = pose.apply(middle[None])[0]
        step = np.concatenate([vector_of(pose.matrix @ self.rotation.T), centre - self.centre])
        measured = about(centre, covariance)
        spread = self.covariance[:6, :6] + measured
        return Innovation(step, spread, measured, float(step @ np.linalg.solve(spread, step)))

    def corrected(self, by: Innovation) -> Motion:
        """With the pose that an innovation is of."""
        gain = np.linalg.solve(by.spread, self.covariance[:6]).T
        correction = gain @ by.step
        left = np.eye(12)
        left[:, :6] -= gain
        ratio = min(by.squared / 6.0, MOST_SURPRISE_RATIO)
        power = STARTLED_POWER if ratio > 1.0 else CALMED_POWER
        agility = self.agility * max(ratio, 1.0 / MOST_SURPRISE_RATIO) ** (0.5 * power)
        return Motion(
            matrix_of(correction[:3]) @ self.rotation,
            self.centre + correction[3:6],
            self.velocity + correction[6:],
            left @ self.covariance @ left.T + gain @ by.measured @ gain.T,
            min(max(agility, LEAST_AGILITY), MOST_AGILITY),
        )


def about(centre: Floats, covariance: Floats) -> Floats:
    """Covariance (6, 6) of steps about a centre (3,), camera frame, from that of steps about the camera.

    The latter turn a point at the centre by w and move it by v + w x centre; with -centre it leads back.
    """
    turn = np.eye(6)
    turn[3:, :3] = -cross_matrix(centre)
    return np.asarray(turn @ covariance @ turn.T)
