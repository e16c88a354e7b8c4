"""Why an estimate of image files may have found no pose, or one hardly believed, and what to do about it."""

from __future__ import annotations

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from geometry.visibility import visible_samples
from vision_server.matching.match import Anywhere, SearchRange
from vision_server.serve.inputs import picture_px, size_warning
from vision_server.trust.judgement import LEAST_BY_LINES, Estimate

FEWEST_SEGMENTS = 4  # three lines in the image hold a pose, one more tells whether it is right
LOOKED_AT_PX = 4.0  # between samples, when it is asked whether anything of the model is in the frame


def is_out_of_frame(model: Model, camera: Camera, pose: Pose) -> bool:
    """Whether from a pose no line of the model is in the frame."""
    return len(visible_samples(model, camera, pose, LOOKED_AT_PX).line) == 0


def why_no_pose(
    segments: int, model: Model, camera: Camera, start: Pose | Anywhere, reach: SearchRange
) -> list[str]:
    """Sentences for people, the likeliest reason first.

    Parameters
    ----------
    segments
        Straight edges that were found in the images.
    start, reach
        Where the pose was looked for, and how far around.
    """
    edges = f"{segments} straight edge{'' if segments == 1 else 's'}"
    if segments < FEWEST_SEGMENTS:
        return [
            f"the images have {edges}. Are they dark, blown out or blurred, or is the target not in them?"
        ]
    if isinstance(start, Anywhere):
        return [
            f"the images have {edges}, but nowhere do enough of them lie on the model's lines. The model is "
            f"{model.diameter:.3g} m across: check --unit. Check fx and fy of the camera. All of the target "
            "should be in the frame. "
            "A --seed-pose, or range_m in [target] of the camera's file, says where to look."
        ]
    if size_warning(model, camera, start) is not None:
        return [f"the model would look {picture_px(model, camera, start):.3g} px wide, as said above."]
    if is_out_of_frame(model, camera, start):
        return [
            "from the seed pose no line of the model is in the frame. Correct the seed pose, or leave it "
            f"out. The model is {model.diameter:.3g} m across: check --unit."
        ]
    return [
        f"the images have {edges}, but within {reach.rotation_deg:g} degrees and {reach.translation_px:g} px "
        "of the seed pose too few of them lie on the model's lines. Leave out --seed-pose to look "
        "everywhere, or widen --rotation-range-deg and --translation-range-px.",
        f"the model would look {picture_px(model, camera, start):.0f} px wide from the seed pose. If the "
        "target in the image does not, --unit, the seed pose's range, or fx and fy of the camera are wrong.",
    ]


def why_hardly_believed(estimate: Estimate) -> str | None:
    """A sentence for people of a pose whose score is as low as if there were none; else None."""
    if estimate.pose is None or estimate.score * max(1, len(estimate.poses)) >= LEAST_BY_LINES:
        return None
    share = f"{100 * estimate.supported_fraction:.0f} % of the model's visible lines lie on edges"
    return (
        f"the pose is hardly believed: {share}. If --overlay shows it nearly right, fx, fy or distortion "
        "of the camera are wrong, or the model is not quite the part; if not, the target shows too little, "
        "is partly outside the frame, or is not in the image."
    )
