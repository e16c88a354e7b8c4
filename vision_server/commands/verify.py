"""`python -m vision_server verify`: whether the pose in a run folder is what its images show."""

from __future__ import annotations

import json
from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vision_server.serve.verification import Verified

EXIT_DIFFERS = 1
SHOWN = 5  # rivals


def add_options(parser: ArgumentParser) -> None:
    """Options of the command."""
    parser.description = (
        f"{parser.description} Exit status: 0 all is as stated, 1 something differs, 2 bad input."
    )
    parser.add_argument("folder", metavar="RUN_FOLDER", type=Path, help="Run folder of a session that ended.")
    parser.add_argument("--json", action="store_true", help="One JSON object on stdout.")


def run(options: Namespace) -> int:
    """Verify and print; the exit status."""
    from vision_server.serve.verification import verified

    found = verified(options.folder)
    if options.json:
        print(json.dumps(_values(found), allow_nan=False))
    else:
        _print(found)
    return 0 if found.as_stated else EXIT_DIFFERS


def _values(found: Verified) -> dict[str, Any]:
    from vision_server.serve.results import estimate_result

    return {
        "as_stated": found.as_stated,
        "images": list(found.images),
        "differences": list(found.differences),
        "estimate": {**estimate_result(found.estimate), "seconds": {}},
    }


def _print(found: Verified) -> None:
    print(f"Estimated again from {len(found.images)} of its images: {' '.join(found.images)}")
    if found.as_stated:
        print("Images, model, settings, pose, covariance, score and merit are as stated.")
    for difference in found.differences:
        print(f"Differs: {difference}.")
    pose = found.estimate.pose
    if pose is None:
        return
    print(f"Other poses that were looked at: {len(found.estimate.rivals) or 'none'}")
    for rival in sorted(found.estimate.rivals, key=lambda one: -one.share)[:SHOWN]:
        apart = pose.compose(found.to_middle).error_to(rival.pose.compose(found.to_middle))
        print(
            f"  turned by {apart.rotation_deg:.1f} degrees, moved by {1e3 * apart.translation_m:.1f} mm:"
            f" {100.0 * max(rival.share, 0.0):.0f} % as well supported"
        )
