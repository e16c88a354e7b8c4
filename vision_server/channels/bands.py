"""The gradient of an image some rows at a time: of a large one it is never held as a whole."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from numerics.arrays import Field, Grey
from vision_server.channels.depth import Pixels, is_deep, linear_image, linear_table
from vision_server.channels.gaussian import Kernels
from vision_server.channels.gradient_pixels import Gradient, GradientPixels, gradient, joined, pixels_of_rows

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
    _whole: Gradient | None = field(init=False, default=None)

    def __post_init__(self) -> None:
        if self.image.size <= BAND_PIXELS:
            self._whole = self._of(0, len(self.image))

    def sampled(self) -> tuple[Field, Pixels]:
        """Lengths of the gradient in some rows, float32 (R, W), and the image there."""
        count, reach = len(self.image), len(self.kernels[0]) // 2
        if self._whole is not None:
            rows = np.s_[SAMPLED_ROW_STEP // 2 :: SAMPLED_ROW_STEP]
            return self._whole.magnitude[rows], self.image[rows]
        step = -(-count // MOST_SAMPLED_ROWS)
        chosen = list(range(step // 2, count, step))
        magnitude = np.empty((len(chosen), self.image.shape[1]), np.float32)
        for number, row in enumerate(chosen):
            top = max(row - reach, 0)
            magnitude[number] = self._of(top, min(row + reach + 1, count)).magnitude[row - top]
        return magnitude, self.image[chosen]

    def pixels(self, level: Grey, floor_of: Field, first: int, end: int) -> GradientPixels:
        """The pixels of some rows whose gradient is above the floor, see `pixels_of_rows`."""
        if self._whole is not None:
            return pixels_of_rows(self._whole, level, floor_of, first, end)
        high = max(BAND_PIXELS // self.image.shape[1], 1)
        starts = range(first, end, high)
        return joined(*(self._band(level, floor_of, top, min(top + high, end)) for top in starts))

    def _band(self, level: Grey, floor_of: Field, first: int, end: int) -> GradientPixels:
        """The same of a band, from the rows that its gradient and that of the rows beside it are made of."""
        rows, columns = self.image.shape
        reach = len(self.kernels[0]) // 2 + 1
        top, bottom = max(first - reach, 0) & ~1, min(end + reach, rows)  # level has each two rows as one
        found = pixels_of_rows(
            self._of(top, bottom), level[top // 2 : (bottom + 1) // 2], floor_of, first - top, end - top
        )
        return found._replace(places=found.places + np.int32(top * columns))

    def _of(self, top: int, bottom: int) -> Gradient:
        """Gradient of these rows; near their ends as if the image ended there."""
        rows = self.image[top:bottom]
        # images of eight bits without a tone curve are linear as they are
        if self.gamma == 1.0 and not is_deep(rows):
            return gradient(rows, self.kernels)
        table = linear_table(self.gamma).astype(np.float32)
        return gradient(linear_image(rows, self.gamma, table), self.kernels)
