"""An approach as a strip of its hold points."""

from collections.abc import Callable, Collection
from dataclasses import dataclass

from bridge.messages import PoseMessage
from bridge.result_file import HoldRecord, Result
from report.strokes import Strokes
from report.verdict import HOLD_PASSED


@dataclass(frozen=True)
class Stop:
    """A hold point, with its last kept image, or its last where none was kept.

    Attributes
    ----------
    range_m : planned, m.
    outcome : how it ended; `here` where the session is at it, empty where it was not come to.
    hold : what is recorded of it, once it has ended.
    image : its name; None where there is none to show.
    strokes : the model at the pose that was found there.
    """

    range_m: float
    outcome: str = ""
    hold: HoldRecord | None = None
    image: str | None = None
    strokes: Strokes | None = None

    @property
    def decision(self) -> str:
        """As of an image: keep where the hold point was passed, discard where it ended the approach."""
        if self.hold is None:
            return ""
        return "keep" if self.hold.status in HOLD_PASSED else "discard"


def strip_of(
    result: Result,
    shown: Collection[str],
    strokes: Callable[[PoseMessage | None], Strokes | None],
    runs: bool = False,
) -> list[Stop]:
    """The hold points from the first to the last, those that were planned and not come to included.

    Parameters
    ----------
    result : of an approach, or of a session without hold points, which has none.
    shown : names of the images that can be shown.
    strokes : draws the model at a pose.
    runs : whether the session is at the first hold point that has not ended.
    """
    holds = result.holds or []
    stops = []
    for number, hold in enumerate(holds, start=1):
        image = _image(result, number, shown)
        stops.append(Stop(hold.range_m, hold.status or "–", hold, image, strokes(hold.pose)))
    for number, range_m in enumerate((result.planned_holds_m or [])[len(holds) :], start=len(holds) + 1):
        if runs and number == len(holds) + 1:
            poses = [step.pose for step in result.steps if step.hold == number]
            here = strokes(poses[-1]) if poses else None
            stops.append(Stop(range_m, "here", None, _image(result, number, shown), here))
        else:
            stops.append(Stop(range_m))
    return stops


def _image(result: Result, number: int, shown: Collection[str]) -> str | None:
    taken = [step for step in result.steps if step.hold == number and step.image in shown]
    kept = [step for step in taken if step.decision == "keep"]
    return (kept or taken)[-1].image if taken else None
