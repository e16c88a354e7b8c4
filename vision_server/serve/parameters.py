"""Parameters of the vision server that a controller may set, with their ranges."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from typing import Any

import msgspec

from bridge.errors import BadInput
from bridge.messages import PoseMessage
from bridge.start_messages import MATCHER_NAMES
from geometry.errors import GeometryError
from geometry.model import Model
from geometry.pose import Pose
from vision_server.channels.gradients import SCALES_PX
from vision_server.matching.match import Anywhere
from vision_server.pipeline import PipelineSettings
from vision_server.serve.inputs import checked_pose

SEED_POSE = "seed_pose"
ANYWHERE = "anywhere"
MOST_RANGE_M = 1e6


def _number(name: str, least: float, most: float, whole: bool = False) -> Callable[[Any], Any]:
    def check(value: Any) -> Any:
        kinds = (int,) if whole else (int, float)
        if isinstance(value, bool) or not isinstance(value, kinds) or not least <= value <= most:
            kind = "a whole number" if whole else "a number"
            raise BadInput(f"Parameter {name} must be {kind} from {least:g} to {most:g}, not {value!r}.")
        return value if whole else float(value)

    return check


def _one_of(name: str, choices: tuple[Any, ...]) -> Callable[[Any], Any]:
    def check(value: Any) -> Any:
        if isinstance(value, bool) or value not in choices:
            raise BadInput(f"Parameter {name} must be one of {', '.join(map(str, choices))}, not {value!r}.")
        return choices[choices.index(value)]

    return check


def _flag(name: str) -> Callable[[Any], Any]:
    def check(value: Any) -> Any:
        if not isinstance(value, bool):
            raise BadInput(f"Parameter {name} must be true or false, not {value!r}.")
        return value

    return check


CHECKS: dict[str, Callable[[Any], Any]] = {
    "matcher": _one_of("matcher", MATCHER_NAMES),
    "seed": _number("seed", 0, 2**63 - 1, whole=True),
    "rotation_range_deg": _number("rotation_range_deg", 0.0, 180.0),
    "translation_range_px": _number("translation_range_px", 0.0, 2000.0),
    "generations": _number("generations", 1, 1000, whole=True),
    "population": _number("population", 20, 5000, whole=True),
    "edge_contrast_grey": _number("edge_contrast_grey", 0.0, 255.0),
    "tone_sd_px": _number("tone_sd_px", 1e-4, 1.0),
    "tolerance_m": _number("tolerance_m", 0.0, MOST_RANGE_M),
    "untold_tolerance_m": _number("untold_tolerance_m", 0.0, MOST_RANGE_M),
    "refinement_scale_px": _one_of("refinement_scale_px", SCALES_PX),
    "fusion": _flag("fusion"),
    "coarse": _flag("coarse"),
}


def changed(settings: PipelineSettings, values: Mapping[str, Any]) -> PipelineSettings:
    """Settings with new values by name.

    Raises
    ------
    BadInput
        An unknown name, a wrong type or a value out of range; nothing is clipped.
    """
    unknown = sorted(set(values) - set(CHECKS))
    if unknown:
        raise BadInput(
            f"Unknown vision parameter {unknown[0]!r}.", f"Known: {', '.join([*CHECKS, SEED_POSE])}."
        )
    return replace(settings, **{name: CHECKS[name](value) for name, value in values.items()})


def as_dict(settings: PipelineSettings) -> dict[str, Any]:
    """All parameters by name."""
    return {field.name: getattr(settings, field.name) for field in fields(settings)}


def seed_pose_value(seed_pose: Pose | Anywhere) -> Any:
    """A seed pose as the parameter's value."""
    return seed_pose.to_dict() if isinstance(seed_pose, Pose) else ANYWHERE


def new_seed_pose(
    value: Any, best: Pose | None, seed_pose: Pose | Anywhere, anywhere: Anywhere, model: Model
) -> Pose | Anywhere:
    """The seed pose that a controller asks for.

    Parameters
    ----------
    value
        A pose; "best" for the best estimate; "anywhere" for none; or {"best_at_range_m": r}, the best
        estimate moved along its line of sight to that range (without one: the seed pose, moved likewise).
    anywhere
        What is known without a seed pose.

    Raises
    ------
    BadInput
        None of these, or there is no estimate yet.
    """
    if value == "best":
        if best is None:
            raise BadInput("There is no estimate that could become the seed pose.", "Estimate a pose first.")
        return best
    if value == ANYWHERE:
        return anywhere
    if isinstance(value, Mapping) and set(value) == {"best_at_range_m"}:
        wanted = value["best_at_range_m"]
        if (
            isinstance(wanted, bool)
            or not isinstance(wanted, (int, float))
            or not 0.0 < wanted <= MOST_RANGE_M
        ):
            raise BadInput(
                f"The value of best_at_range_m must be a positive number of metres, not {wanted!r}."
            )
        start = seed_pose if best is None else best
        if isinstance(start, Anywhere):
            return start
        moved = start.translation * (float(wanted) / math.hypot(*start.translation))
        value = start.to_dict() | {"translation": moved.tolist()}
    try:
        told = msgspec.convert(value, PoseMessage)
        return checked_pose(Pose.of(told), model)
    except (GeometryError, msgspec.ValidationError, ValueError) as error:
        raise BadInput(
            f"Parameter seed_pose: {error}.",
            'Give a pose, "best", "anywhere" or {"best_at_range_m": metres}.',
        ) from error
