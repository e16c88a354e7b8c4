"""The images of one set with what is computed once for each of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from bridge.errors import BadInput
from bridge.reply_memory import give_back_freed
from numerics.arrays import Grey
from vision_server.channels.channel import ChannelStatistics, channel_statistics
from vision_server.channels.depth import Pixels
from vision_server.channels.gradients import GradientChannel, gradient_channel
from vision_server.edges.edge_map import EdgeMap
from vision_server.edges.merging import ImageSetStatistics
from vision_server.edges.moved import Movement, SureEdgels, moved_since, sure_edgels

# Chosen by hand: sums take 4 bytes a pixel and 80 where there is a gradient, nearly half of what four large
# images take, and to sum an image again costs a third of what its statistics do.
KEPT_PIXELS = 2_000_000


# Scale of the gradient that is looked at where the finer one shows no pose. A sharp step stands out of white
# noise by three standard deviations from 1.5 / scale times it on: half of it here, twice of it at 0.7 px. Of
# 34 sets of dark or glaring images 5 px show 19 right poses for 20, and 6 px 13.
COARSE_SCALE_PX = 3.0


@dataclass(frozen=True, eq=False)
class SetImage:
    """One image and its views: for the merged edge map, fine and coarse, and for refinement.

    ``repeats`` is the first image of the set that is the very same picture, if there is one.
    """

    name: str
    statistics: ChannelStatistics
    repeats: str | None = None

    @property
    def pixels(self) -> Grey:
        """The image as a picture, uint8 (H, W)."""
        return self.statistics.image

    def coarse(self) -> ChannelStatistics:
        """Its statistics at COARSE_SCALE_PX, or at a coarser scale that its blur asks for, made anew."""
        known = self.statistics
        scale = max(COARSE_SCALE_PX, known.sigma_px)
        return channel_statistics(known.pixels, known.exposure, known.gamma, sigma_px=scale)

    @cached_property
    def gradient(self) -> GradientChannel:
        """What refinement sees; made when it first asks."""
        return gradient_channel(self.name, self.statistics)

    @cached_property
    def sure_edgels(self) -> SureEdgels:
        """Where its sure edges are, see `edges.moved`."""
        return sure_edgels(self.statistics)


class ImageSet:
    """Images by name; any subset of them can be merged.

    A channel's statistics are computed when it is added. The merged sums follow the subsets that are asked
    for, so that asking for one image more costs one image; those of large images are not kept.

    Parameters
    ----------
    width, height
        Every image's size, px.
    """

    def __init__(self, width: int, height: int) -> None:
        self.size = (width, height)
        self._large = width * height > KEPT_PIXELS
        self.images: dict[str, SetImage] = {}
        self._merged = {coarse: ImageSetStatistics() for coarse in (False, True)}
        self._coarse: dict[str, ChannelStatistics] = {}

    def add(self, name: str, pixels: Pixels, exposure: float, gamma: float) -> None:
        """Add an image; exposure is relative to the reference, gamma the tone curve to undo.

        Raises
        ------
        BadInput
            The name is taken, the image is no grey one or has another size than the camera.
        """
        if name in self.images:
            raise BadInput(f"Image {name} is in the set already.", "Give each image a name of its own.")
        if pixels.ndim != 2 or (pixels.shape[1], pixels.shape[0]) != self.size:
            shape = "x".join(map(str, pixels.shape[1::-1]))
            raise BadInput(
                f"Image {name} has {shape} px, the camera {self.size[0]}x{self.size[1]}.",
                "Give the camera model of the image's size.",
            )
        statistics = channel_statistics(pixels, exposure, gamma)
        same = (one for one in self.images.values() if statistics.same_picture(one.statistics))
        first = next((one.repeats or one.name for one in same), None)
        self.images[name] = SetImage(name, statistics, first)
        if self._large:
            give_back_freed()

    def remove(self, name: str) -> SetImage:
        """Take an image out.

        Raises
        ------
        BadInput
            No image of that name.
        """
        self.check([name])
        self._coarse.pop(name, None)
        for merged in self._merged.values():
            if name in merged.channels:
                merged.remove(name)
        return self.images.pop(name)

    def distinct(self, names: Sequence[str]) -> tuple[str, ...]:
        """The named images without those that repeat another one of them.

        No two frames have the same noise: a picture that comes again is no second witness.

        Raises
        ------
        BadInput
            An unknown image.
        """
        self.check(names)
        pictures: dict[str, str] = {}
        for name in names:
            pictures.setdefault(self.images[name].repeats or name, name)
        return tuple(pictures.values())

    def edge_map(self, names: Sequence[str], coarse: bool = False) -> EdgeMap:
        """The merged edge map of the named images, by their fine or their coarse statistics.

        Raises
        ------
        BadInput
            No images, or an unknown one.
        """
        self.check(names)
        wanted = set(names)
        merged = self._merged[coarse]
        if not wanted & set(merged.channels):
            merged = self._merged[coarse] = ImageSetStatistics()
        for name in [name for name in merged.channels if name not in wanted]:
            merged.remove(name)
        for name in names:
            if name not in merged.channels:
                merged.add(name, self._statistics(name, coarse))
        edges = merged.merge()
        if self._large:
            self._merged[coarse] = ImageSetStatistics()
            give_back_freed()
        return edges

    def _statistics(self, name: str, coarse: bool) -> ChannelStatistics:
        """An image's fine statistics, or its coarse ones, which are kept unless it is large."""
        if not coarse:
            return self.images[name].statistics
        if self._large:
            return self.images[name].coarse()
        if name not in self._coarse:
            self._coarse[name] = self.images[name].coarse()
        return self._coarse[name]

    def gradients(self, names: Sequence[str]) -> list[GradientChannel]:
        """The named images as refinement sees them."""
        self.check(names)
        return [self.images[name].gradient for name in names]

    def moved(self, name: str) -> Movement | None:
        """What this image shows elsewhere than all that were added before it; None if nothing, or no others.

        Raises
        ------
        BadInput
            No image of that name.
        """
        self.check([name])
        names = list(self.images)
        before = [self.images[one].sure_edgels for one in names[: names.index(name)]]
        return moved_since(before, self.images[name].sure_edgels)

    def check(self, names: Sequence[str]) -> None:
        """Raise BadInput when one of the names is of no image in the set."""
        for name in names:
            if name not in self.images:
                known = ", ".join(self.images) or "no images"
                raise BadInput(f"No image {name} in the set.", f"It has {known}.")
