"""The replay device: recorded light stacks answer as if camera and lights were there."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from bridge.arrays import FramePixels
from bridge.errors import BadInput, Unsupported
from bridge.image_messages import MoveDone, PoseErrorMessage
from bridge.messages import Describe, PoseMessage, Settings
from image_server.serve.device import Change, Device, Frame, checked_settings, sure_frame
from numerics.arrays import Grey
from stack.exposure import in_words, level_fraction, light_powers, same_value
from stack.format import FrameTable
from stack.read import BasisStack, FramesStack, describe_stack
from stack.sensor import check_blur, exposed, mixed

if TYPE_CHECKING:
    from geometry.model import Model

NEAREST_NAMED = 3  # recorded settings that an error lists


class Replay(Device):
    """A stack folder as a device.

    Parameters
    ----------
    stack : a loaded stack.
    seed : session seed; with the capture's number it draws the noise of a basis stack.
    captures_taken : by an earlier process of the same session.
    nearest : answer a request for settings that were not recorded with the frame whose settings are nearest,
        rather than with an error. One that was not shown yet comes first: the same image twice would be taken
        for two witnesses.
    shown : settings of the recorded frames that an earlier process of the same session has shown, in order;
        the first `captures_taken` of them count.

    Raises
    ------
    BadInput : a blur that is larger than the frame.
    """

    name = "replay"

    def __init__(
        self,
        stack: BasisStack | FramesStack,
        seed: int = 0,
        captures_taken: int = 0,
        nearest: bool = False,
        shown: Sequence[Settings] = (),
    ) -> None:
        if isinstance(stack, BasisStack):
            check_blur(stack.table.camera, f"The stack {stack.folder}")
        self._stack = stack
        self._describe = describe_stack(stack, self.name)
        self._nearest = nearest
        self._shown: list[int] = []
        if isinstance(stack, FramesStack):
            for settings in shown[:captures_taken]:
                self._recorded_frame(stack, settings)
        self.restart(seed, captures_taken)

    def restart(self, seed: int, captures_taken: int, moves: Sequence[MoveDone] = ()) -> list[Change]:
        """Draw noise from another seed, and forget what recorded frames were shown after these captures."""
        self._seed = seed
        self._captures = captures_taken
        del self._shown[captures_taken:]
        return []

    def come_to(self, number: int) -> None:
        """As before the capture of this number."""
        if number != self._captures + 1:
            self.restart(self._seed, number - 1)

    def describe(self) -> Describe:
        """What the stack offers."""
        return self._describe

    def capture(self, settings: Settings) -> Frame:
        """A frame mixed from the basis images, or the recorded frame with these settings.

        Several frames recorded under the same settings come in turn. A frame under other settings than those
        that were asked for is not verified.
        """
        asked = checked_settings(self._describe, settings)
        if isinstance(self._stack, BasisStack):
            pixels: FramePixels = self._basis_frame(self._stack, asked, self._captures + 1)
            applied = asked
        else:
            pixels, applied = self._recorded_frame(self._stack, asked)
        self._captures += 1
        frame = sure_frame(pixels, settings, applied, self._captures, f"replay:{self._stack.folder}")
        return dataclasses.replace(frame, verified=_recorded_under(applied, asked))

    def health(self) -> dict[str, Any]:
        """Always sound: the stack was read whole at the start."""
        return {"status": "ok", "stack": str(self._stack.folder), "captures": self._captures}

    def score(self, pose: PoseMessage, moves: int | None = None) -> PoseErrorMessage | None:
        """Error against the stack's true_pose; None where the stack has none."""
        true_pose = self._stack.table.target.true_pose
        return None if true_pose is None else pose_error(pose, true_pose, self._model)

    @cached_property
    def _model(self) -> Model:
        from geometry.model import load_model

        target = self._stack.table.target
        return load_model(self._stack.folder / target.model, target.unit)

    def move(self, range_m: float) -> list[Change]:
        """A recorded scene stays where it was."""
        raise Unsupported("A recorded stack cannot move its target.", "Use the simulator to approach.")

    def _basis_frame(self, stack: BasisStack, settings: Settings, number: int) -> Grey:
        weights = [*light_powers(stack.table.lights, settings.lights), stack.table.ambient_scale]
        radiance = mixed([*stack.radiances, stack.ambient], weights)
        return exposed(
            radiance, stack.table.camera, settings.shutter_s, settings.aperture, (self._seed, number)
        )

    def _recorded_frame(self, stack: FramesStack, settings: Settings) -> tuple[FramePixels, Settings]:
        frames = stack.table.frames
        matching = [n for n, frame in enumerate(frames) if self._nearest or _recorded_under(frame, settings)]
        if not matching:
            nearest = sorted(frames, key=lambda frame: self._distance(frame, settings))[:NEAREST_NAMED]
            raise BadInput(
                f"The stack {stack.folder} has no frame recorded under {in_words(settings)}.",
                f"Nearest: {'; '.join(in_words(frame) for frame in nearest)}.",
            )
        shown = Counter(self._shown)
        index = min(matching, key=lambda n: (shown[n], self._distance(frames[n], settings)))
        self._shown.append(index)
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


def pose_error(pose: PoseMessage, true_pose: PoseMessage, model: Model) -> PoseErrorMessage:
    """Error of a pose against the true one; how a round model is turned about its axis does not count."""
    from geometry.pose import Pose
    from geometry.symmetries import if_round, turned_towards

    told = Pose.of(pose)
    error = told.error_to(turned_towards(Pose.of(true_pose), told, if_round(model)))
    return PoseErrorMessage(
        rotation_deg=error.rotation_deg,
        translation_m=error.translation_m,
        translation_fraction_of_range=error.translation_fraction_of_range,
    )


def _recorded_under(frame: Settings, settings: Settings) -> bool:
    return (
        frame.lights == settings.lights
        and same_value(frame.shutter_s, settings.shutter_s)
        and same_value(frame.aperture, settings.aperture)
        and _same_or_free(frame.focal_length_mm, settings.focal_length_mm)
        and _same_or_free(frame.focus_m, settings.focus_m)
    )


def _same_or_free(recorded: float | None, asked: float | None) -> bool:
    return asked is None or (recorded is not None and same_value(recorded, asked))
