"""The gradient of an image some rows at a time: of a large one it is never held as a whole."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from numerics.arrays import Field, Grey
from vision_server.channels.depth import Pixels, is_deep, linear_image, linear_table
from vision_server.channels.gaussian import Kernels
from vision_server.channels.gradient_pixels import Gradient, GradientPixels, gradient, joined, pixels_of_rows
from vision_server.channels.narrow_gradient import narrow_magnitudes, narrow_pixels_of_rows, narrowed

# Chosen by hand where nothing else is said.
BAND_PIXELS = 1 << 20  # an image of no more is one band; 12 bytes of gradient for each
SAMPLED_ROW_STEP = 16  # rows whose magnitudes are sampled, for the noise in flat parts ...
MOST_SAMPLED_ROWS = 64  # ... of an image of several bands no more than that


@dataclass(eq=False)
class GradientRows:
    """Gradient of an image, linear in light, by ``kernels``.

    Attributes
    ----------
    image
        Grey as it came (H, W); ``gamma`` is its tone curve.
    kernels
        Across and along the derivative, see `contrast_kernels`.
    """

    image: Pixels
    gamma: float
    kernels: Kernels
    _narrow: Kernels | None = field(init=False)
    _whole: Gradient | None = field(init=False, default=None)

    def __post_init__(self) -> None:
        self._narrow = narrowed(self.kernels)
        if self._narrow is None and self.image.size <= BAND_PIXELS:
            self._whole = gradient(self._linear(0, len(self.image)), self.kernels)

    def sampled(self) -> tuple[Field, Pixels]:
        """Lengths of the gradient in some rows, float32 (R, W), and the image there."""
        count, reach = len(self.image), len(self.kernels[0]) // 2
        step = SAMPLED_ROW_STEP if self.image.size <= BAND_PIXELS else -(-count // MOST_SAMPLED_ROWS)
        rows = np.arange(step // 2, count, step)
        if self._whole is not None:
            return self._whole.magnitude[rows], self.image[rows]
        magnitude = np.empty((len(rows), self.image.shape[1]), np.float32)
        if self._narrow is not None and self._is_linear:
            return narrow_magnitudes(self.image, *self._narrow, rows), self.image[rows]
        for number, row in enumerate(rows.tolist()):
            top = max(row - reach, 0)
            linear, here = self._linear(top, min(row + reach + 1, count)), row - top
            if self._narrow is not None:
                magnitude[number] = narrow_magnitudes(linear, *self._narrow, np.array([here]))[0]
            else:
                magnitude[number] = gradient(linear, self.kernels).magnitude[here]
        return magnitude, self.image[rows]

    def pixels(self, level: Grey, floor_of: Field, first: int, end: int) -> GradientPixels:
        """The pixels of some rows whose gradient is above the floor, see `pixels_of_rows`."""
        if self._whole is not None:
            return pixels_of_rows(self._whole, level, floor_of, first, end)
        if self._narrow is not None and self._is_linear:
            return narrow_pixels_of_rows(self.image, self._narrow, level, floor_of, first, end)
        high = max(BAND_PIXELS // self.image.shape[1], 1)
        starts = range(first, end, high)
        return joined(*(self._band(level, floor_of, top, min(top + high, end)) for top in starts))

    def _band(self, level: Grey, floor_of: Field, first: int, end: int) -> GradientPixels:
        """The same of a band, from the rows that its gradient and that of the rows beside it are made of."""
        rows, columns = self.image.shape
        reach = len(self.kernels[0]) // 2 + 1
        top, bottom = max(first - reach, 0) & ~1, min(end + reach, rows)  # level has each two rows as one
        linear, there = self._linear(top, bottom), level[top // 2 : (bottom + 1) // 2]
        first, end = first - top, end - top
        if self._narrow is not None:
            found = narrow_pixels_of_rows(linear, self._narrow, there, floor_of, first, end)
        else:
            found = pixels_of_rows(gradient(linear, self.kernels), there, floor_of, first, end)
        return found._replace(places=found.places + np.int32(top * columns))

    @property
    def _is_linear(self) -> bool:
        """Whether the image is linear as it is: of eight bits without a tone curve."""
        return self.gamma == 1.0 and not is_deep(self.image)

    def _linear(self, top: int, bottom: int) -> Grey | Field:
        """Linear intensity of these rows."""
        rows = self.image[top:bottom]
        if self._is_linear:
            return rows
        return linear_image(rows, self.gamma, linear_table(self.gamma).astype(np.float32))
