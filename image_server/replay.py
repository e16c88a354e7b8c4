"""The replay device: recorded light stacks answer as if camera and lights were there."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bridge.errors import BadInput, Unsupported
from bridge.messages import Describe, PoseErrorMessage, PoseMessage, Settings
from image_server.serve.device import Change, Device, Frame, checked_settings, sure_frame
from stack.exposure import in_words, level_fraction, light_powers, same_value
from stack.format import FrameTable
from stack.read import BasisStack, FramesStack, describe_stack
from stack.sensor import exposed, mixed

NEAREST_NAMED = 3  # recorded settings that an error lists


class Replay(Device):
    """A stack folder as a device.

    Parameters
    ----------
    stack : a loaded stack.
    seed : session seed; with the capture's number it draws the noise of a basis stack.
    captures_taken : by an earlier process of the same session.
    """

    name = "replay"

    def __init__(self, stack: BasisStack | FramesStack, seed: int = 0, captures_taken: int = 0) -> None:
        self._stack = stack
        self._describe = describe_stack(stack, self.name)
        self.restart(seed, captures_taken)

    def restart(self, seed: int, captures_taken: int) -> None:
        """Draw noise from another seed, and show recorded frames from the first."""
        self._seed = seed
        self._captures = captures_taken
        self._shown: dict[int, int] = {}

    def describe(self) -> Describe:
        """What the stack offers."""
        return self._describe

    def capture(self, settings: Settings) -> Frame:
        """A frame mixed from the basis images, or the recorded frame with these settings.

        Several frames recorded under the same settings come in turn.
        """
        applied = checked_settings(self._describe, settings)
        if isinstance(self._stack, BasisStack):
            pixels = self._basis_frame(self._stack, applied, self._captures + 1)
        else:
            pixels, applied = self._recorded_frame(self._stack, applied)
        self._captures += 1
        return sure_frame(pixels, settings, applied, self._captures, f"replay:{self._stack.folder}")

    def health(self) -> dict[str, Any]:
        """Always sound: the stack was read whole at the start."""
        return {"status": "ok", "stack": str(self._stack.folder), "captures": self._captures}

    def score(self, pose: PoseMessage) -> PoseErrorMessage | None:
        """Error against the stack's true_pose; None where the stack has none."""
        true_pose = self._stack.table.target.true_pose
        return None if true_pose is None else pose_error(pose, true_pose)

    def move(self, range_m: float) -> list[Change]:
        """A recorded scene stays where it was."""
        raise Unsupported("A recorded stack cannot move its target.", "Use the simulator to approach.")

    def _basis_frame(self, stack: BasisStack, settings: Settings, number: int) -> NDArray[np.uint8]:
        weights = [*light_powers(stack.table.lights, settings.lights), stack.table.ambient_scale]
        radiance = mixed([*stack.radiances, stack.ambient], weights)
        return exposed(
            radiance, stack.table.camera, settings.shutter_s, settings.aperture, (self._seed, number)
        )

    def _recorded_frame(self, stack: FramesStack, settings: Settings) -> tuple[NDArray[np.uint8], Settings]:
        frames = stack.table.frames
        matching = [index for index, frame in enumerate(frames) if _recorded_under(frame, settings)]
        if not matching:
            nearest = sorted(frames, key=lambda frame: self._distance(frame, settings))[:NEAREST_NAMED]
            raise BadInput(
                f"The stack {stack.folder} has no frame recorded under {in_words(settings)}.",
                f"Nearest: {'; '.join(in_words(frame) for frame in nearest)}.",
            )
        turn = self._shown.get(matching[0], 0)
        self._shown[matching[0]] = turn + 1
        index = matching[turn % len(matching)]
        return stack.images[index], frames[index].settings()

    def _distance(self, frame: FrameTable, settings: Settings) -> float:
        """How unlike two settings are: fractions of full level, and stops of shutter, aperture, lens."""
        distance = sum(
            abs(level_fraction(a, light.levels) - level_fraction(b, light.levels))
            for a, b, light in zip(frame.lights, settings.lights, self._describe.lights, strict=True)
        )
        for ours, theirs, stops in (
            (frame.shutter_s, settings.shutter_s, 1.0),
            (frame.aperture, settings.aperture, 2.0),
            (frame.focal_length_mm, settings.focal_length_mm, 1.0),
            (frame.focus_m, settings.focus_m, 1.0),
        ):
            if ours is not None and theirs is not None:
                distance += stops * abs(float(np.log2(ours / theirs)))
        return distance


def pose_error(pose: PoseMessage, true_pose: PoseMessage) -> PoseErrorMessage:
    """Error of a pose against the true one."""
    from geometry.pose import Pose

    error = Pose(np.array(pose.rotation_vector), np.array(pose.translation)).error_to(
        Pose(np.array(true_pose.rotation_vector), np.array(true_pose.translation))
    )
    return PoseErrorMessage(
        rotation_deg=error.rotation_deg,
        translation_m=error.translation_m,
        translation_fraction_of_range=error.translation_fraction_of_range,
    )


def _recorded_under(frame: FrameTable, settings: Settings) -> bool:
    return (
        frame.lights == settings.lights
        and same_value(frame.shutter_s, settings.shutter_s)
        and same_value(frame.aperture, settings.aperture)
        and _same_or_free(frame.focal_length_mm, settings.focal_length_mm)
        and _same_or_free(frame.focus_m, settings.focus_m)
    )


def _same_or_free(recorded: float | None, asked: float | None) -> bool:
    return asked is None or (recorded is not None and same_value(recorded, asked))
