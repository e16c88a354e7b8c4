"""Poses of the target in the camera frame, and draws from a search range around one."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from geometry.errors import GeometryError
from geometry.rotation import cross_matrix, euler_matrix, matrix_of, vector_of
from numerics.arrays import Flags, Floats

RIGHT = (1.0, 0.01)
"""A pose is called right within so many degrees and this share of the range (docs/architecture.md)."""
TIGHT = (0.2, 0.002)
"""The same for a pose that is right and fine, in tables of results."""
SEARCH_ROTATION_DEG = 25.0
"""How far each rotation of the pose may be from the seed pose: the paper's range."""
SEARCH_TRANSLATION_PX = 40.0
"""How far each component of the translation may be, in pixels at the seed's depth: the paper's range."""
PAPER_WIDTH_PX = 640
"""Width of the frames that this is meant for; see `search_translation_px`."""


@dataclass(frozen=True)
class PoseError:
    """How far a pose is from another one.

    Attributes
    ----------
    rotation_deg : angle between the two rotations, degrees.
    translation_m : distance between the two target origins, metres.
    translation_fraction_of_range : that distance divided by the range of the true target origin.
    """

    rotation_deg: float
    translation_m: float
    translation_fraction_of_range: float

    def within(self, rotation_deg: float, fraction_of_range: float) -> bool:
        """Whether both errors are under the given limits (degrees, fraction of range)."""
        return self.rotation_deg < rotation_deg and self.translation_fraction_of_range < fraction_of_range


def _vector(value: ArrayLike, name: str, size: int = 3) -> Floats:
    try:
        out = np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise GeometryError(f"{name} must be {size} numbers, got {value!r}") from error
    if out.shape != (size,):
        raise GeometryError(f"{name} must be {size} numbers, got {out.tolist()!s:.80}")
    if not np.isfinite(out).all():
        raise GeometryError(f"{name} must be finite, got {out.tolist()}")
    out.setflags(write=False)
    return out


class PoseNumbers(Protocol):
    """What has the numbers of a pose: rotation vector, rad, and translation, metres."""

    @property
    def rotation_vector(self) -> Sequence[float]: ...

    @property
    def translation(self) -> Sequence[float]: ...


@dataclass(frozen=True, eq=False)
class Pose:
    """camera_T_target: a point of the target frame goes to the camera frame by R·x + t.

    Parameters
    ----------
    rotation_vector : (3,) float64, axis times angle, rad.
    translation : (3,) float64, metres, the target's origin in the camera frame.

    Raises
    ------
    GeometryError : a wrong shape, NaN or infinity.
    """

    rotation_vector: Floats
    translation: Floats

    def __post_init__(self) -> None:
        object.__setattr__(self, "rotation_vector", _vector(self.rotation_vector, "pose rotation_vector"))
        object.__setattr__(self, "translation", _vector(self.translation, "pose translation"))

    @classmethod
    def of(cls, told: PoseNumbers) -> "Pose":
        """Pose of a message or record of it."""
        return cls(np.array(told.rotation_vector), np.array(told.translation))

    @classmethod
    def from_matrix(cls, rotation: Floats, translation: Floats) -> "Pose":
        """Pose of a rotation matrix (3, 3) and a translation (3,) in metres."""
        rotation = np.ascontiguousarray(rotation, dtype=np.float64)
        if rotation.shape != (3, 3) or not np.isfinite(rotation).all():
            raise GeometryError("pose rotation must be a finite 3×3 matrix")
        return cls(vector_of(rotation), translation)

    @cached_property
    def matrix(self) -> Floats:
        """Rotation matrix, (3, 3); shared, not to be written to."""
        out: Floats = matrix_of(self.rotation_vector)
        return out

    def apply(self, points: Floats) -> Floats:
        """Points (N, 3) of the target frame in the camera frame, metres."""
        return np.asarray(points, dtype=np.float64) @ self.matrix.T + self.translation

    def compose(self, other: "Pose") -> "Pose":
        """a_T_b.compose(b_T_c) is a_T_c."""
        rotation = self.matrix
        return Pose.from_matrix(rotation @ other.matrix, rotation @ other.translation + self.translation)

    @classmethod
    def turn_about(cls, centre: Floats, turn: Floats) -> "Pose":
        """A turn, rotation matrix (3, 3), that leaves a point (3,) where it is."""
        return cls.from_matrix(turn, centre - turn @ centre)

    def inverse(self) -> "Pose":
        """target_T_camera."""
        return Pose(-self.rotation_vector, -(self.matrix.T @ self.translation))

    def stepped(self, delta: ArrayLike) -> "Pose":
        """The pose after a small left-multiplied step: R' = exp(dr)·R, t' = exp(dr)·t + dt.

        Parameters
        ----------
        delta : (6,), dr in rad, then dt in metres.
        """
        step = _vector(delta, "pose step", 6)
        turn = matrix_of(step[:3])
        return Pose.from_matrix(turn @ self.matrix, turn @ self.translation + step[3:])

    def step_from(self, other: "Pose") -> Floats:
        """The left-multiplied step (6,) that leads from the other pose to this one, see `stepped`."""
        turn = self.matrix @ other.matrix.T
        return np.concatenate([vector_of(turn), self.translation - turn @ other.translation])

    def error_to(self, true: "Pose") -> PoseError:
        """Difference of this pose from the true one; the fraction is of the true range."""
        angle = math.hypot(*vector_of(self.matrix @ true.matrix.T).tolist())
        distance = math.dist(self.translation.tolist(), true.translation.tolist())
        distance_to_true = math.hypot(*true.translation.tolist())
        fraction = distance / distance_to_true if distance_to_true > 0 else math.inf
        return PoseError(math.degrees(angle), distance, fraction)

    def to_dict(self) -> dict[str, list[float]]:
        """The pose as plain lists, for JSON and TOML."""
        return {"rotation_vector": self.rotation_vector.tolist(), "translation": self.translation.tolist()}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> "Pose":
        """Pose of a mapping with `rotation_vector` and `translation`; other keys are left alone.

        Raises
        ------
        GeometryError : a missing key, a wrong shape, NaN or infinity.
        """
        for key in ("rotation_vector", "translation"):
            if key not in data:
                raise GeometryError(f"pose has no {key}; it needs rotation_vector (rad) and translation (m)")
        return cls(data["rotation_vector"], data["translation"])


def near(
    rotations: Floats, translations: Floats, pose: Pose, rotation_deg: float, fraction_of_range: float
) -> Flags:
    """Which of the poses (N, 3, 3), (N, 3) are within both limits of one: `PoseError.within`, at once."""
    twice_cosine_and_one = np.sum(rotations * pose.matrix, axis=(1, 2))
    apart = np.linalg.norm(translations - pose.translation, axis=1)
    close = apart < fraction_of_range * np.linalg.norm(pose.translation)
    turned_alike = twice_cosine_and_one > 1.0 + 2.0 * math.cos(math.radians(rotation_deg))
    return np.asarray(close & turned_alike)


def origin_jacobian(translation: Floats) -> Floats:
    """How the target's origin moves with a small left-multiplied step of a pose (dr rad, dt m), (3, 6).

    The origin goes from t to exp(dr)·t + dt: its step is dt - t x dr.
    """
    return np.hstack([-cross_matrix(translation), np.eye(3)])


def search_translation_px(width: int) -> float:
    """The paper's range on a frame of that width, px: in proportion on frames that are wider than its own."""
    return SEARCH_TRANSLATION_PX * max(1.0, width / PAPER_WIDTH_PX)


def disturbed(
    pose: Pose,
    rng: np.random.Generator,
    rotation_deg: float,
    translation_px: float,
    focal_px: float,
    middle: Floats | None = None,
) -> Pose:
    """Draw a pose uniformly from the search range around a seed pose.

    R = R_seed·Rx·Ry·Rz with each angle within ±rotation_deg; each component of the place of the target's
    ``middle``, (3,) in its frame (None: its origin), moves within ±translation_px·Z/focal_px metres
    (docs/architecture.md).
    """
    middle = np.zeros(3) if middle is None else middle
    place = pose.apply(middle[None])[0]
    angles = np.radians(rng.uniform(-rotation_deg, rotation_deg, 3))
    reach = translation_px * place[2] / focal_px
    place = place + rng.uniform(-1.0, 1.0, 3) * reach
    turned = pose.matrix @ euler_matrix(angles[0], angles[1], angles[2])
    return Pose.from_matrix(turned, place - turned @ middle)
