"""Estimates and what tracking tells as plain values: keys that files, wire and command line share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from bridge.start_messages import EstimateTold
from geometry.pose import Pose
from vision_server.trust.judgement import Estimate

if TYPE_CHECKING:
    from vision_server.tracking.referee import Judgement
    from vision_server.tracking.tracked import Tracked


def estimate_result(estimate: Estimate) -> dict[str, Any]:
    """An estimate as JSON values; see docs/pose.md for each key."""
    told: dict[str, Any] = {
        "pose": None if estimate.pose is None else estimate.pose.to_dict(),
        "covariance": None if estimate.covariance is None else estimate.covariance.tolist(),
        "rms_px": estimate.rms_px,
        "uncertainty": estimate.uncertainty,
        "supported_fraction": estimate.supported_fraction,
        "score": estimate.score,
        "ambiguity": estimate.ambiguity,
        "lines": [asdict(line) for line in estimate.lines],
        "rivals": [{"pose": rival.pose.to_dict(), "share": rival.share} for rival in estimate.rivals],
        "segments": estimate.segments,
        "seconds": dict(estimate.seconds),
    }
    if estimate.poses:
        told["poses"] = [
            {"pose": one.pose.to_dict(), "probability": one.probability} for one in estimate.poses
        ]
    if estimate.free:
        told["free"] = [axis.tolist() for axis in estimate.free]
    return told


def model_wrong(estimate: Estimate) -> dict[str, Any] | None:
    """What is surely wrong with the model of an estimate from two images or more, as `ModelExcess`."""
    found = None if estimate.misfit is None else estimate.misfit.excess
    return None if found is None else {"axis": "xyz"[found.axis], "share": found.share}


def restored_estimate(told: EstimateTold) -> Estimate:
    """An estimate of an earlier process, as far as later decisions depend on it."""
    return Estimate(
        pose=Pose.of(told.pose),
        covariance=np.array(told.covariance),
        rms_px=told.rms_px,
        uncertainty=told.uncertainty,
        supported_fraction=told.supported_fraction,
        score=told.score,
        ambiguity=told.ambiguity,
    )


def tracked_result(told: Tracked) -> dict[str, Any]:
    """What one frame says; see docs/tracking.md for each key."""
    return {
        "frame": told.frame,
        "state": told.state,
        "pose": None if told.pose is None else told.pose.to_dict(),
        "covariance": None if told.covariance is None else told.covariance.tolist(),
        "seconds": told.seconds,
    }


def judgement_result(found: Judgement, disagreeing: Sequence[str]) -> dict[str, Any]:
    """What is said of a pose from elsewhere; see docs/check.md for each key."""
    better = found.better
    return {
        "probability": found.probability,
        "state": found.state,
        "better": None if better is None else better.to_dict(),
        "better_probability": found.better_probability,
        "covariance": None if found.covariance is None else found.covariance.tolist(),
        "difference": None if found.difference is None else asdict(found.difference),
        "disagreeing_lines": list(found.disagreeing),
        "disagreeing_images": list(disagreeing),
    }
