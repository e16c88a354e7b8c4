"""Matching: from image segments and a seed pose to candidate poses."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from vision_server.matching.match import Candidate, Match, SearchRange
from vision_server.matching.search import match_search
from vision_server.rivals.genetic import match_genetic

Floats = NDArray[np.float64]
Matcher = Callable[[Floats, Floats | None, Model, Camera, Pose, int, SearchRange], Match]

MATCHERS: dict[str, Matcher] = {"search": match_search, "genetic": match_genetic}

__all__ = ["MATCHERS", "Candidate", "Match", "SearchRange", "match_genetic", "match_search"]
