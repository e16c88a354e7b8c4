"""Camera with the lens distortion of OpenCV: four, five, eight or twelve coefficients, or fisheye."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from geometry.errors import GeometryError
from numerics.arrays import Floats

Region = tuple[int, int, int, int]  # left, top, right, bottom, px; right and bottom are one past

UNDISTORT_ITERATIONS = 30  # at most, chosen by hand: it ends at the tolerance
UNDISTORT_TOLERANCE = 1e-12  # in normalised image coordinates
COEFFICIENT_COUNTS = {"pinhole": (5, 8, 12), "fisheye": (4,)}
MOST_FISHEYE_RAD = 1.4  # from its axis (80 degrees), to which a fisheye is used: beyond, no plane holds it
LEAST_FX = 0.125  # of the width: a lens of 152 degrees, which only a fisheye is (by hand)
MOST_PX = 1e6  # of focal lengths and principal points: far beyond lenses on large sensors
FISHEYE_HALVINGS = 48  # of that angle: to 1e-14 rad
MOST_APART_PX = 1.0  # between a point of the border and where the ideal point that was found is seen


@dataclass(frozen=True)
class Camera:
    """A calibrated camera; pixel centres are at integer coordinates.

    Parameters
    ----------
    width, height : image size, px.
    fx, fy : focal lengths, px.
    cx, cy : principal point, px.
    distortion : (k1, k2, p1, p2, k3), perhaps with (k4, k5, k6), perhaps with (s1, s2, s3, s4) after them, as
        OpenCV orders them; (k1, k2, k3, k4) of a fisheye.
    lens : "pinhole", or "fisheye" (equidistant: OpenCV's fisheye module, Kannala and Brandt 2006).

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
    lens: str = "pinhole"

    def __post_init__(self) -> None:
        if self.width < 1 or self.height < 1:
            raise GeometryError(f"camera image size must be positive, got {self.width}×{self.height}")
        if not (self.fx > 0 and self.fy > 0):
            raise GeometryError(f"camera focal lengths must be positive, got fx {self.fx}, fy {self.fy}")
        values = np.array([self.fx, self.fy, self.cx, self.cy, *self.distortion])
        if self.lens not in COEFFICIENT_COUNTS:
            raise GeometryError(f"camera lens must be {' or '.join(COEFFICIENT_COUNTS)}, got {self.lens!r}")
        if len(self.distortion) not in COEFFICIENT_COUNTS[self.lens]:
            raise GeometryError(
                "camera distortion must be four, five, eight or twelve numbers (k1, k2, p1, p2, k3, k4, k5,"
                " k6, s1, s2, s3, s4), four of a fisheye; "
                f"got {len(self.distortion)}. Tilted sensors are not read"
            )
        if not np.isfinite(values).all():
            raise GeometryError("camera values must be finite")

    def _check_border(self) -> None:
        """Some ray is seen at each point of the frame: its corners, and what is between two, stand for it.

        Raises
        ------
        GeometryError : the distortion cannot be undone there.
        """
        right, low = self.width - 1.0, self.height - 1.0
        border = np.array([(x, y) for y in (0.0, 0.5 * low, low) for x in (0.0, 0.5 * right, right)])
        with np.errstate(all="ignore"):
            rays = (self.undistort_points(border) - [self.cx, self.cy]) / [self.fx, self.fy]
            off = np.abs(self.project(np.column_stack([rays, np.ones(len(rays))])) - border).max(axis=1)
        lost = border[~(off < MOST_APART_PX)]
        if len(lost):
            u, v = lost[0]
            raise GeometryError(
                f"camera distortion cannot be undone at {u:.0f}, {v:.0f} px, as where a picture is folded. "
                "Check the signs and the order of its numbers; a calibration holds where its boards have been"
            )

    @property
    def distorted(self) -> bool:
        """Whether any distortion coefficient is not zero."""
        return any(self.distortion) or self.lens == "fisheye"

    @property
    def ideal(self) -> "Camera":
        """The same camera without distortion."""
        return Camera(self.width, self.height, self.fx, self.fy, self.cx, self.cy)

    def part(self, region: Region) -> "Camera":
        """The camera that would have taken just this part of the image."""
        left, top, right, bottom = region
        return replace(self, width=right - left, height=bottom - top, cx=self.cx - left, cy=self.cy - top)

    def scaled(self, factor: float) -> "Camera":
        """The camera whose image is that many times as wide and high, to whole pixels."""
        return replace(
            self,
            width=max(1, round(self.width * factor)),
            height=max(1, round(self.height * factor)),
            fx=self.fx * factor,
            fy=self.fy * factor,
            cx=(self.cx + 0.5) * factor - 0.5,
            cy=(self.cy + 0.5) * factor - 0.5,
        )

    @property
    def intrinsics(self) -> Floats:
        """fx, fy, cx, cy as an array (4,), px."""
        return np.array([self.fx, self.fy, self.cx, self.cy])

    def project(self, points_camera: Floats) -> Floats:
        """Pixels (N, 2) of points (N, 3) in the camera frame; NaN for a point that is not in front."""
        points = np.asarray(points_camera, dtype=np.float64)
        depth = np.where(points[:, 2] > 0, points[:, 2], np.nan)
        normal = self._distort(points[:, :2] / depth[:, None])
        return normal * [self.fx, self.fy] + [self.cx, self.cy]

    def undistort_points(self, pixels: Floats) -> Floats:
        """Ideal pixels (N, 2), where a lens without distortion would have put pixels (N, 2)."""
        pixels = np.asarray(pixels, dtype=np.float64)
        if not self.distorted:
            return pixels.copy()
        seen = (pixels - [self.cx, self.cy]) / [self.fx, self.fy]
        if self.lens == "fisheye":
            return self._straightened(seen) * [self.fx, self.fy] + [self.cx, self.cy]
        ideal = seen.copy()
        for _ in range(UNDISTORT_ITERATIONS):
            error = self._distort(ideal) - seen
            ideal -= error
            if not np.abs(error).max(initial=0.0) > UNDISTORT_TOLERANCE:
                break
        return ideal * [self.fx, self.fy] + [self.cx, self.cy]

    def _distort(self, normal: Floats) -> Floats:
        """Brown–Conrady model, rational from eight coefficients on, with thin prisms from twelve; or fisheye.

        In normalised coordinates, (N, 2).
        """
        if not self.distorted:
            return normal
        if self.lens == "fisheye":
            radius = np.linalg.norm(normal, axis=1)
            angle = np.arctan(radius)
            return normal * (self._bent(angle) / np.where(radius > 0.0, radius, 1.0))[:, None]
        k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4 = (*self.distortion, *[0.0] * 7)[:12]
        x, y = normal[:, 0], normal[:, 1]
        r2 = x * x + y * y
        radial = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)))
        dx = 2 * p1 * x * y + p2 * (r2 + 2 * x * x) + r2 * (s1 + s2 * r2)
        dy = p1 * (r2 + 2 * y * y) + 2 * p2 * x * y + r2 * (s3 + s4 * r2)
        return np.stack([x * radial + dx, y * radial + dy], axis=1)

    def _bent(self, angle: Floats) -> Floats:
        """Distance from the middle, in focal lengths, of rays (N,) at these angles, rad, of a fisheye."""
        k1, k2, k3, k4 = self.distortion
        t2 = angle * angle
        bent: Floats = angle * (1 + t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * k4))))
        return bent

    def _straightened(self, seen: Floats) -> Floats:
        """Normalised coordinates (N, 2) without a fisheye; what is beyond MOST_FISHEYE_RAD is put there."""
        radius = np.linalg.norm(seen, axis=1)
        low, high = np.zeros_like(radius), np.full_like(radius, MOST_FISHEYE_RAD)
        for _ in range(FISHEYE_HALVINGS):
            angle = 0.5 * (low + high)
            beyond = self._bent(angle) > radius
            low, high = np.where(beyond, low, angle), np.where(beyond, angle, high)
        straight: Floats = seen * (np.tan(0.5 * (low + high)) / np.where(radius > 0.0, radius, 1.0))[:, None]
        return straight

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
        } | ({} if self.lens == "pinhole" else {"lens": self.lens})

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> "Camera":
        """Camera of a mapping, or of its `camera` table; keys of other parts (gain, …) are left alone.

        Raises
        ------
        GeometryError : a missing key, a value that is not a number, one beyond MOST_PX; fx that is
            too small for the width; a distortion that cannot be undone within the frame.
        """
        table = data.get("camera", data)
        missing = [key for key in ("width", "height", "fx", "fy", "cx", "cy") if key not in table]
        if missing:
            raise GeometryError(f"[camera] has no {', '.join(missing)}")
        lens = str(table.get("lens", "pinhole"))
        try:
            fx, fy, cx, cy = (float(table[key]) for key in ("fx", "fy", "cx", "cy"))
            coefficients = tuple(float(value) for value in table.get("distortion") or cls.distortion)
            width, height = int(table["width"]), int(table["height"])
        except (TypeError, ValueError, OverflowError) as error:
            raise GeometryError(
                f"[camera] needs numbers for its size, fx, fy, cx, cy and distortion: {error}"
            ) from error
        for name, value in (("fx", fx), ("fy", fy), ("cx", cx), ("cy", cy)):
            if math.isfinite(value) and abs(value) > MOST_PX:
                raise GeometryError(f"camera {name} must be at most {MOST_PX:g} px, got {value:g}")
        if lens == "pinhole" and 0.0 < fx < LEAST_FX * width:
            raise GeometryError(
                f"camera fx is {fx:g} px of a frame {width} px wide, which no pinhole camera sees. It is the"
                " focal length in px: that in mm over the size of a pixel in mm"
            )
        if lens == "pinhole" and len(coefficients) == 4:
            coefficients = (*coefficients, 0.0)
        if lens == "fisheye" and coefficients == cls.distortion:  # it was not told
            coefficients = coefficients[:4]
        camera = cls(width, height, fx, fy, cx, cy, coefficients, lens)
        if lens == "pinhole" and camera.distorted:
            camera._check_border()  # once: it holds for parts of its frame, and for these scaled, as well
        return camera
