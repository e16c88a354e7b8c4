"""What can be seen of a model at each pose that was found, as lines of a file in a run folder."""

from collections.abc import Mapping, Sequence

import msgspec
import numpy as np

from geometry.pose import Pose
from geometry.wireframe import Run

WIREFRAMES = "wireframes.jsonl"  # beside the images of the run folder
DECIMALS = 2  # of a px: a hundredth of one is less than any screen shows


_Pose = frozenset[tuple[str, tuple[float, ...]]]


class _Stretch(msgspec.Struct, frozen=True):
    line: int
    points: list[tuple[float, float]]


class _Wireframe(msgspec.Struct, frozen=True):
    pose: dict[str, list[float]]
    runs: list[_Stretch]


def wireframe_line(pose: Pose, runs: Sequence[Run]) -> bytes:
    """A line of the file: the model's visible stretches at a pose (`geometry.wireframe.visible_runs`)."""
    drawn = [_Stretch(run.line, run.points.round(DECIMALS).tolist()) for run in runs]
    return msgspec.json.encode(_Wireframe(pose.to_dict(), drawn)) + b"\n"


class Wireframes:
    """Lines of the file, oldest first; each is read but once, when it is needed."""

    def __init__(self, lines: Sequence[bytes]) -> None:
        self._unread = list(lines)
        self._runs: dict[_Pose, list[Run]] = {}

    def at(self, pose: Pose) -> list[Run] | None:
        """What the newest line for this very pose tells; None where there is none.

        A line that is not whole, as the last one while it is written, is passed over.
        """
        wanted = _same(pose.to_dict())
        while wanted not in self._runs and self._unread:
            try:
                found = msgspec.json.decode(self._unread.pop(), type=_Wireframe)
            except msgspec.MsgspecError:
                continue
            runs = [Run(one.line, np.array(one.points)) for one in found.runs]
            self._runs.setdefault(_same(found.pose), runs)
        return self._runs.get(wanted)


def _same(pose: Mapping[str, Sequence[float]]) -> _Pose:
    return frozenset((name, tuple(values)) for name, values in pose.items())
