"""What the frames so far leave to the next one: where the target was, and how far that was believed."""

from __future__ import annotations

from dataclasses import dataclass

from geometry.pose import Pose
from vision_server.matching.match import Anywhere
from vision_server.tracking.softness import Softness


@dataclass
class History:
    """Of one target; `tracker` says what follows from it."""

    last: Pose | Anywhere  # the last pose that was told; before any, what is known without one
    trusted: Pose | Anywhere  # the last that was believed; before any, the same
    met: bool = False  # whether any pose was told yet
    believed: bool = False  # whether the pose of the last frame was believed
    # Whether the last search that found something believed it. Only searches weigh rivals and stretched
    # models, so that no frame is believed after one that did not.
    search_believed: bool = False
    softness: Softness | None = None  # of the target's lines; None if the last frame was not followed surely
    doubted: int = 0  # frames in a row, since the last search, whose pose was not believed
    lost: int = 0  # frames in a row without a pose
    vain: int = 0  # searches in a row that were not believed
    against: int = 0  # searches that doubted what they found, less those that believed it
    without_s: float = 0.0  # time since the last pose, s

    def told(self, pose: Pose, believed: bool) -> None:
        """The frame has this pose."""
        self.last, self.met, self.believed = pose, True, believed
        self.lost, self.without_s = 0, 0.0
        self.doubted = 0 if believed else self.doubted + 1
        self.trusted = pose if believed else self.trusted

    def missed(self) -> None:
        """The frame has no pose."""
        self.lost, self.believed = self.lost + 1, False

    def search_begins(self) -> None:
        """The frame was not followed surely, and doubts are counted anew."""
        self.softness, self.doubted = None, 0
