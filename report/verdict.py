"""The outcome of a session in words: what happened. What may help the session has told (`advice`)."""

import math
from dataclasses import dataclass

from bridge.command_line import counted
from bridge.messages import PoseMessage
from bridge.result_file import HoldRecord, Result
from geometry.pose import RIGHT
from report.words import angle, length, percent

RIGHT_DEG, RIGHT_FRACTION = RIGHT
SURE = 0.999  # no probability is told that is nearer to 1: that many cases were never tried
HOLD_PASSED = frozenset({"converged", "fixed", "reached"})


@dataclass(frozen=True)
class Verdict:
    """A headline.

    Attributes
    ----------
    tone : "good", "warn" or "bad".
    label : the status in a word or two.
    headline, detail : plain sentences.
    """

    tone: str
    label: str
    headline: str
    detail: str


def verdict_of(result: Result) -> Verdict:
    """Say what came of the session, and whether that was right where the truth is known."""
    images = counted(len(result.steps) or result.iterations or 0, "image")
    if result.holds:
        return _approach(result, result.holds)
    if result.planned_holds_m and result.status == "stopped":
        points = counted(len(result.planned_holds_m), "hold point")
        detail = f"None of {points} was passed; the first is at {result.planned_holds_m[0]:g} m."
        return Verdict("warn", "stopped", "Approach stopped early", detail)
    if result.pose is None:
        return _no_pose(result, images)
    right = is_right(result)
    checked = _checked(result)
    if result.status == "converged":
        if right is False:
            return Verdict("bad", "wrong", "A wrong pose was taken for right", checked)
        detail = f"{checked or f'Certain enough after {images}.'} {_free(result)}".strip()
        return Verdict("good", "converged", "Pose found", detail)
    if result.status == "exhausted":
        used = f"All {images} were used" if len(result.steps) != 1 else "Its one image was used"
        detail = (
            f"{used} and the merit stayed above the threshold. This is the best estimate{_score(result)}."
        )
        return Verdict("warn", "exhausted", "No certain pose", f"{detail} {checked} {_free(result)}".strip())
    if result.status == "stopped":
        detail = f"Stopped after {images}, before the session had ended. This is the best estimate so far."
        return Verdict("warn", "stopped", "Stopped early", f"{detail} {checked}".strip())
    return Verdict("warn", result.status, f"Session ended: {result.status}", checked)


def is_right(result: Result) -> bool | None:
    """Whether the pose is within `RIGHT_DEG` and `RIGHT_FRACTION` of the true one; None if unknown."""
    if result.error is None:
        return None
    error = result.error
    return error.rotation_deg < RIGHT_DEG and error.translation_fraction_of_range < RIGHT_FRACTION


def range_of(pose: PoseMessage) -> float:
    """Distance of the target's origin from the camera, metres."""
    return math.sqrt(sum(value * value for value in pose.translation))


def _checked(result: Result) -> str:
    if result.error is None:
        return ""
    error = result.error
    off = f"{length(error.translation_m)} ({percent(error.translation_fraction_of_range)} of the range)"
    return f"Checked against the true pose, it is off by {off} and {angle(error.rotation_deg)}."


def _free(result: Result) -> str:
    """Of round targets."""
    axes = " and ".join("({:.2f}, {:.2f}, {:.2f})".format(*axis) for axis in result.free or ())
    return f"No image clearly tells how it is turned about its axis {axes}." if axes else ""


def _score(result: Result) -> str:
    if result.score is None:
        return ""
    sure = result.score > SURE
    return (
        f", right with a probability of {'more than ' if sure else ''}{percent(min(result.score, SURE), 3)}"
    )


def _no_pose(result: Result, images: str) -> Verdict:
    if not result.steps:
        what = "iteration was complete" if result.iterations else "image"
        detail = f"The session ended before its first {what}."
    elif any(step.pose and step.decision == "keep" for step in result.steps):
        detail = "A pose was found and lost again: the target moved, or an image kept later shows none."
    elif any(step.pose for step in result.steps):
        detail = "A pose was found, but the strategy discarded every image that shows one."
    else:
        detail = f"None of the {images} gave a pose." if len(result.steps) > 1 else "Its image gave no pose."
    headline = "Stopped early, with no pose" if result.status == "stopped" else "No pose"
    return Verdict("bad", result.status, headline, detail)


def _approach(result: Result, holds: list[HoldRecord]) -> Verdict:
    passed = sum(hold.status in HOLD_PASSED for hold in holds)
    last = holds[-1]
    points = f"{passed} of {counted(len(result.planned_holds_m or holds), 'hold point')} passed"
    if result.status == "stopped":
        detail = f"{points}; the last was at {last.range_m:g} m."
        if result.pose is None:
            detail += " What is shown was fixed there: no pose was found since."
        return Verdict("warn", "stopped", "Approach stopped early", detail)
    if passed == len(holds):
        checked = _checked(result)
        if is_right(result) is False:
            return Verdict("bad", "wrong", "A wrong pose was taken for right", checked)
        headline = f"Approach reached {last.range_m:g} m"
        return Verdict("good", "reached", headline, f"{points}. {checked}".strip())
    headline = f"Approach aborted at {last.range_m:g} m"
    detail = (
        f"{points}. At the last one no pose was certain enough to come closer, so it was not taken for good."
    )
    return Verdict("warn", "aborted", headline, detail)
