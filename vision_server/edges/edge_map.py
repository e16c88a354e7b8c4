"""What an edge map is: a list of edgels, which knows where in the image each of them is."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from numerics.arrays import Field, Flags, Ints
from numerics.kernels import kernel
from vision_server.channels.channel import ChannelStatistics


@dataclass(frozen=True, eq=False)
class EdgeMap:
    """Edgels of an image set after non-maximum suppression, before any threshold and hysteresis.

    Attributes
    ----------
    shape
        Height and width of the image, px.
    places
        int32 (N,), flat indices of the edgels, ascending.
    strength
        float32 (N,), merged magnitude: mass times the share that the mixture's main component has in it.
    mass
        float32 (N,), weighted mean contrast of the channels, grey at reference exposure.
    axis
        float32 (N,), direction across the edge, rad in [0, pi), 0 along x.
    offset
        float32 (N,), position of the edge along ``axis`` from the pixel's centre, px.
    floor
        float32 (N,), standard deviation of ``mass`` from sensor noise.
    blur_px
        Blur of the most blurred channel, px.
    channels
        What was merged; empty when the map is not a merge of channels.
    """

    shape: tuple[int, int]
    places: NDArray[np.int32]
    strength: Field
    mass: Field
    axis: Field
    offset: Field
    floor: Field
    blur_px: float
    channels: tuple[ChannelStatistics, ...]

    @classmethod
    def from_fields(cls, ridge: Field, axis: Field, offset: Field, floor: float) -> EdgeMap:
        """A map of one image: fields float32 (H, W), of which only the pixels with a ridge above 0 count."""
        places = np.flatnonzero(ridge).astype(np.int32)
        strength, axis, offset = (field.ravel()[places] for field in (ridge, axis, offset))
        shape = (ridge.shape[0], ridge.shape[1])
        return cls(shape, places, strength, strength, axis, offset, np.full_like(strength, floor), 0.0, ())

    def __len__(self) -> int:
        return len(self.places)

    def field(self, values: Field) -> Field:
        """Values of the edgels as an image: float32 (H, W), 0 off the edgels."""
        image = np.zeros(self.shape, np.float32)
        image.ravel()[self.places] = values
        return image

    @property
    def ridge(self) -> Field:
        """Merged magnitude as an image: float32 (H, W), 0 off the ridges."""
        return self.field(self.strength)

    @cached_property
    def normals(self) -> Field:
        """Unit vectors across the edges, float32 (N, 2), x and y."""
        normals = np.empty((len(self.axis), 2), np.float32)
        np.cos(self.axis, out=normals[:, 0])
        np.sin(self.axis, out=normals[:, 1])
        return normals

    @cached_property
    def points(self) -> Field:
        """Sub-pixel positions, float32 (N, 2), x and y, px."""
        return _points(self.places, self.offset, self.normals, self.shape[1])

    @cached_property
    def index(self) -> NDArray[np.int32]:
        """Number of the edgel at each pixel, -1 where there is none, int32 (H, W)."""
        numbers = np.full(self.shape, -1, np.int32)
        numbers.ravel()[self.places] = np.arange(len(self.places), dtype=np.int32)
        return numbers

    def strongest_first(self, chosen: Flags) -> Ints:
        """Numbers (M,) of the chosen edgels (N,)."""
        numbers = np.flatnonzero(chosen)
        return numbers[np.argsort(-self.strength[numbers], kind="stable")]

    def free(self, chosen: Flags) -> FreeEdgels:
        """The chosen edgels (N,) for a kernel that groups them."""
        return FreeEdgels(self.index, self.places, self.points, self.normals, chosen.copy())


@kernel()
def _points(places: NDArray[np.int32], offset: Field, normals: Field, columns: int) -> Field:
    """As `EdgeMap.points`, of an image so wide."""
    points, width = np.empty_like(normals), np.int32(columns)
    for i in range(len(places)):
        y = places[i] // width
        points[i, 0] = np.float32(places[i] - y * width) + offset[i] * normals[i, 0]
        points[i, 1] = np.float32(y) + offset[i] * normals[i, 1]
    return points


class FreeEdgels(NamedTuple):
    """An edge map as the kernels that group edgels take it, and which edgels are in no group yet.

    Attributes
    ----------
    number_at, places, points, normals
        As `index`, `places`, `points` and `normals` of `EdgeMap`.
    free
        bool (N,), changed by the kernels.
    """

    number_at: NDArray[np.int32]
    places: NDArray[np.int32]
    points: Field
    normals: Field
    free: Flags
