"""Pinhole camera with the lens distortion of OpenCV's four, five or eight coefficients."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.errors import GeometryError

Array = NDArray[np.float64]

UNDISTORT_ITERATIONS = 30  # at most, chosen by hand: it ends at the tolerance
UNDISTORT_TOLERANCE = 1e-12  # in normalised image coordinates


@dataclass(frozen=True)
class Camera:
    """A calibrated camera; pixel centres are at integer coordinates.

    Parameters
    ----------
    width, height : image size, px.
    fx, fy : focal lengths, px.
    cx, cy : principal point, px.
    distortion : (k1, k2, p1, p2, k3), or those and (k4, k5, k6), as OpenCV orders them.

    Raises
    ------
    GeometryError : a size or focal length that is not positive, a value that is not finite.
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    distortion: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if self.width < 1 or self.height < 1:
            raise GeometryError(f"camera image size must be positive, got {self.width}×{self.height}")
        if not (self.fx > 0 and self.fy > 0):
            raise GeometryError(f"camera focal lengths must be positive, got fx {self.fx}, fy {self.fy}")
        values = np.array([self.fx, self.fy, self.cx, self.cy, *self.distortion])
        if len(self.distortion) not in (5, 8):
            raise GeometryError(
                "camera distortion must be four, five or eight numbers: k1, k2, p1, p2, k3, k4, k5, k6; got "
                f"{len(self.distortion)}. Tilted sensors and fisheye lenses are not read"
            )
        if not np.isfinite(values).all():
            raise GeometryError("camera values must be finite")

    @property
    def distorted(self) -> bool:
        """Whether any distortion coefficient is not zero."""
        return any(self.distortion)

    @property
    def ideal(self) -> "Camera":
        """The same camera without distortion."""
        return Camera(self.width, self.height, self.fx, self.fy, self.cx, self.cy)

    @property
    def intrinsics(self) -> Array:
        """fx, fy, cx, cy as an array (4,), px."""
        return np.array([self.fx, self.fy, self.cx, self.cy])

    def project(self, points_camera: Array) -> Array:
        """Pixels (N, 2) of points (N, 3) in the camera frame; NaN for a point that is not in front."""
        points = np.asarray(points_camera, dtype=np.float64)
        depth = np.where(points[:, 2] > 0, points[:, 2], np.nan)
        normal = self._distort(points[:, :2] / depth[:, None])
        return normal * [self.fx, self.fy] + [self.cx, self.cy]

    def undistort_points(self, pixels: Array) -> Array:
        """Ideal pixels (N, 2), where a lens without distortion would have put pixels (N, 2)."""
        pixels = np.asarray(pixels, dtype=np.float64)
        if not self.distorted:
            return pixels.copy()
        seen = (pixels - [self.cx, self.cy]) / [self.fx, self.fy]
        ideal = seen.copy()
        for _ in range(UNDISTORT_ITERATIONS):
            error = self._distort(ideal) - seen
            ideal -= error
            if not np.abs(error).max(initial=0.0) > UNDISTORT_TOLERANCE:
                break
        return ideal * [self.fx, self.fy] + [self.cx, self.cy]

    def _distort(self, normal: Array) -> Array:
        """Brown–Conrady model, rational from eight coefficients on, in normalised coordinates, (N, 2)."""
        if not self.distorted:
            return normal
        k1, k2, p1, p2, k3, k4, k5, k6 = (*self.distortion, 0.0, 0.0, 0.0)[:8]
        x, y = normal[:, 0], normal[:, 1]
        r2 = x * x + y * y
        radial = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)))
        dx = 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
        dy = p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
        return np.stack([x * radial + dx, y * radial + dy], axis=1)

    def to_dict(self) -> dict[str, Any]:
        """The camera as plain values, for JSON and TOML."""
        return {
            "width": self.width,
            "height": self.height,
            "fx": self.fx,
            "fy": self.fy,
            "cx": self.cx,
            "cy": self.cy,
            "distortion": list(self.distortion),
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> "Camera":
        """Camera of a mapping, or of its `camera` table; keys of other parts (gain, …) are left alone.

        Raises
        ------
        GeometryError : a missing key or a value that is not a number.
        """
        table = data.get("camera", data)
        missing = [key for key in ("width", "height", "fx", "fy", "cx", "cy") if key not in table]
        if missing:
            raise GeometryError(f"[camera] has no {', '.join(missing)}")
        distortion = table.get("distortion") or [0.0] * 5
        try:
            fx, fy, cx, cy = (float(table[key]) for key in ("fx", "fy", "cx", "cy"))
            coefficients = tuple(float(value) for value in distortion)
            width, height = int(table["width"]), int(table["height"])
        except (TypeError, ValueError) as error:
            raise GeometryError(
                f"[camera] needs numbers for its size, fx, fy, cx, cy and distortion: {error}"
            ) from error
        without_k3 = len(coefficients) == 4
        return cls(width, height, fx, fy, cx, cy, (*coefficients, 0.0) if without_k3 else coefficients)
