"""Estimates as plain values: the keys that `result.json`, the wire and the command line share."""

from __future__ import annotations

from typing import Any

import numpy as np

from bridge.messages import EstimateTold
from geometry.pose import Pose
from vision_server.pipeline import Estimate


def estimate_result(estimate: Estimate) -> dict[str, Any]:
    """An estimate as JSON values; see docs/pose.md for each key."""
    return {
        "pose": None if estimate.pose is None else estimate.pose.to_dict(),
        "covariance": None if estimate.covariance is None else estimate.covariance.tolist(),
        "rms_px": estimate.rms_px,
        "uncertainty": estimate.uncertainty,
        "supported_fraction": estimate.supported_fraction,
        "score": estimate.score,
        "ambiguity": estimate.ambiguity,
        "lines": [
            {
                "line": line.line,
                "visible_px": line.visible_px,
                "support": line.support,
                "rms_px": line.rms_px,
                "image": line.image,
            }
            for line in estimate.lines
        ],
        "rivals": [{"pose": rival.pose.to_dict(), "share": rival.share} for rival in estimate.rivals],
        "segments": estimate.segments,
        "seconds": dict(estimate.seconds),
    }


def restored_estimate(told: EstimateTold) -> Estimate:
    """An estimate of an earlier process, as far as later decisions depend on it."""
    return Estimate(
        pose=Pose(np.array(told.pose.rotation_vector), np.array(told.pose.translation)),
        covariance=np.array(told.covariance),
        rms_px=told.rms_px,
        uncertainty=told.uncertainty,
        supported_fraction=told.supported_fraction,
        score=told.score,
        ambiguity=told.ambiguity,
    )
