"""What the vision server does for one session: inputs, image set and estimates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from bridge.arrays import FramePixels
from bridge.errors import BadInput
from bridge.messages import Describe, Settings
from geometry.camera import Camera
from geometry.errors import GeometryError
from geometry.model import Model
from geometry.pose import Pose
from stack.exposure import light_powers, relative_exposure
from vision_server.channels.depth import Raw
from vision_server.edges.edge_map import EdgeMap
from vision_server.image_set import ImageSet, SetImage
from vision_server.matching.match import Anywhere
from vision_server.pipeline import PipelineSettings, estimate_pose
from vision_server.prediction.response import LitImage
from vision_server.serve import parameters
from vision_server.serve.inputs import checked_tolerance
from vision_server.serve.recorder import Recorder
from vision_server.serve.statistics import frame_statistics, lit_region, target_region
from vision_server.trust.judgement import Estimate, stated

if TYPE_CHECKING:
    from vision_server.tracking.tracker import Tracker

RATHER_RIGHT = 0.5  # score from which a pose is rather right than wrong
ANOTHER_SCENE = "target_moved", "sun_changed"  # events
REMEMBERED = 6  # discarded images: of no more `prediction.causes` asks what has happened


class Happened(NamedTuple):
    """What was found to have happened: a cause, and the lights that it is about.

    ``before`` are the images of the set that were taken before it.
    """

    cause: str
    lights: tuple[int, ...]
    before: frozenset[str]


@dataclass(eq=False)
class PoseTask:
    """What the operations of the server work on.

    Attributes
    ----------
    images
        The set, and with it what was computed for each image.
    retired
        Names of images of earlier sets, which went when the scene's geometry changed; they stay taken.
    edge_radius_m
        Of the target's rounded edges, where the camera's file tells it.
    raw
        What the pixels of frames are, as they come.
    seed_pose
        About where the target is; `anywhere` when there is no such pose, and each set of images is looked at
        by first sight.
    anywhere
        What is known of it without a seed pose.
    best
        The estimate with the best score of the present set so far.
    applied
        What each image of the scene was taken under, in order of time: of the set, and of the last ones that
        were discarded since the first forecast.
    lit
        Images as readings of brightness, of those that something was predicted from, and of discarded ones.
    foresees
        Whether a forecast was asked for: images are held against those before, discarded ones among them.
    tracker
        What follows the target since its first frame, where a client has it followed.
    expected
        Where the target was taken to be when something was predicted last; None where that was unsure.
    doubted
        The image before which something may have happened, while that is not sure.
    happened
        What images that were not as foreseen have told, in order of time.
    """

    describe: Describe
    model: Model
    camera: Camera
    gain: float
    gamma: float
    seed_pose: Pose | Anywhere
    settings: PipelineSettings
    anywhere: Anywhere = field(default_factory=Anywhere)
    recorder: Recorder | None = None
    raw: Raw = field(default_factory=lambda: Raw(16))
    edge_radius_m: float | None = None
    images: ImageSet = field(init=False)
    retired: set[str] = field(default_factory=set)
    best: Estimate | None = None
    applied: dict[str, Settings] = field(default_factory=dict)
    lit: dict[str, LitImage] = field(default_factory=dict)
    tracker: Tracker | None = None
    foresees: bool = False
    expected: Pose | None = None
    doubted: str | None = None
    happened: list[Happened] = field(default_factory=list)
    _known: dict[tuple[str, ...], Estimate] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.images = ImageSet(self.camera.width, self.camera.height)

    def exposure(self, settings: Settings) -> float:
        """Exposure relative to the reference of `describe`, sensor gain included."""
        return self.gain * relative_exposure(settings.shutter_s, settings.aperture, self.describe.reference)

    def check_name(self, image: str) -> None:
        """Raise BadInput when an image's name is taken."""
        if image in self.images.images or image in self.retired:
            raise BadInput(
                f"The name {image} is taken by another image.", "Give each image a name of its own."
            )

    def add(self, image: str, pixels: FramePixels, applied: Settings) -> dict[str, Any]:
        """Add a frame, as it came, to the set; its statistics."""
        self.images.add(image, self.raw.grey(pixels), self.exposure(applied), self.gamma)
        self.applied[image] = applied
        pose, shown = self.likely_pose(), self.images.images
        if pose is None:
            region = lit_region(one.statistics.image for one in shown.values())
        else:
            region = target_region(self.model, self.camera, pose)
        return frame_statistics(shown[image].statistics, region, self.gamma)

    def to_be_judged(self, image: str) -> bool:
        """Whether an image can be held against a forecast, a doubt, or another one of its settings."""
        settings = self.applied[image]
        if len(settings.lights) != len(self.describe.lights):  # a given frame
            return False
        again = any(one == settings for name, one in self.applied.items() if name != image)
        return again or self.expected is not None or self.doubted is not None

    def likely_pose(self) -> Pose | None:
        """About where the target is: the best pose so far, or the seed pose; None without one to believe."""
        seed_pose = None if isinstance(self.seed_pose, Anywhere) else self.seed_pose
        if self.best is None or (seed_pose is None and self.best.score < RATHER_RIGHT):
            return seed_pose
        return self.best.pose

    def discard(self, image: str) -> None:
        """Take an image out of the set; its name stays taken, what it shows of light is remembered."""
        if image in self.retired:
            return
        removed = self.images.remove(image)
        if self.foresees and image not in self.lit:
            self.lit[image] = self._read(removed)
        self.retired.add(image)
        dropped = [name for name in self.applied if name not in self.images.images]
        for name in dropped[: max(len(dropped) - REMEMBERED, 0)] if self.foresees else dropped:
            del self.applied[name]
            self.lit.pop(name, None)

    def reading(self, image: str) -> LitImage:
        """An image of the scene as readings of brightness; its lights are those that were asked for."""
        if image not in self.lit:
            self.lit[image] = self._read(self.images.images[image])
        return self.lit[image]

    def _read(self, image: SetImage) -> LitImage:
        settings, channel = self.applied[image.name], image.statistics
        powers = np.array(light_powers(self.describe.lights, settings.lights))
        linear = channel.linear / np.float32(255.0)
        blur_px = channel.lone_blur_px or channel.blur_px
        return LitImage(linear, self.exposure(settings), powers, blur_px)

    def expect(self, found: Estimate | None) -> None:
        """Take the target to be where it was found, if that is rather right: images are held against it."""
        self.foresees = True
        self.expected = None if found is None or found.score < RATHER_RIGHT else found.pose

    def hear(self, events: Sequence[str], image: str) -> None:
        """Know what was published with an image: it is not held against those from before another scene."""
        for event in events:
            if event in ANOTHER_SCENE:
                self.learn(Happened(event, (), frozenset(self.applied) - {image}))

    def learn(self, happened: Happened) -> None:
        """Know from now on what has happened; a target that moved is where no estimate has seen it yet."""
        self.happened = [*self.happened, happened]
        if happened.cause == "target_moved":
            self.expected = self.best = None

    def estimate(self, names: Sequence[str]) -> Estimate:
        """Pose from the named images; the same question is answered once."""
        key = self.images.distinct(names)
        if key not in self._known:
            try:
                images, named = self._fused(key) if self.settings.fusion else (self.images, key)
                found = stated(estimate_pose(
                    images, named, self.model, self.camera, self.seed_pose, self.settings,
                    lambda edges: self._show(key[-1], edges),
                ))  # fmt: skip
            except GeometryError as error:
                raise BadInput(str(error)) from error
            self._known[key] = found
            if self.recorder is not None and found.pose is not None:
                self.recorder.outline(self.model, self.camera, found.pose)
        estimate = self._known[key]
        self.note(estimate)
        return estimate

    def _fused(self, names: tuple[str, ...]) -> tuple[ImageSet, tuple[str, ...]]:
        """A set of one image, fused from the named ones, under the last one's name."""
        from vision_server.baselines.exposures import exposure_fusion  # only for comparison

        one = ImageSet(self.camera.width, self.camera.height)
        pixels = exposure_fusion([self.images.images[name].pixels for name in names])
        one.add(names[-1], pixels, 1.0, 1.0)
        return one, names[-1:]

    def _show(self, image: str, edges: EdgeMap) -> None:
        if self.recorder is not None:
            self.recorder.draw(image, edges)

    def note(self, estimate: Estimate) -> None:
        """Make an estimate the best one if it is."""
        if estimate.pose is not None and (self.best is None or estimate.score > self.best.score):
            self.best = estimate

    def estimate_of(self, names: Sequence[str]) -> Estimate | None:
        """The best estimate with a pose from some of the named images; None where none has one."""
        of_these = [found for key, found in self._known.items() if set(key) <= set(names)]
        known = [found for found in of_these if found.pose is not None]
        return max(known, key=lambda found: found.score, default=None if of_these else self.best)

    def set_parameters(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Set parameters by name, all or none; all of them afterwards."""
        values = dict(values)
        wanted = values.pop(parameters.SEED_POSE, None)
        if "tolerance_m" in values:
            values.setdefault("untold_tolerance_m", 0.0)
        settings = parameters.changed(self.settings, values)
        checked_tolerance(settings.tolerance_m, self.model)
        checked_tolerance(settings.untold_tolerance_m, self.model, "Parameter untold_")
        if wanted is not None:
            best = None if self.best is None else self.best.pose
            pose = parameters.new_seed_pose(wanted, best, self.seed_pose, self.anywhere, self.model)
            if isinstance(wanted, Mapping) and "best_at_range_m" in wanted:
                self._new_set()
            self.seed_pose = pose
            self._known.clear()
        if settings != self.settings:
            self.settings = settings
            self._known.clear()
        return {
            **parameters.as_dict(self.settings),
            parameters.SEED_POSE: parameters.seed_pose_value(self.seed_pose),
        }

    def _new_set(self) -> None:
        """The target has moved: what was seen before says nothing about where it is now."""
        self.retired |= set(self.images.images)
        self.images = ImageSet(self.camera.width, self.camera.height)
        self.applied.clear()
        self.lit.clear()
        self.expected = None
        self.best = None
