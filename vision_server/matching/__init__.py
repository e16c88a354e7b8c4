"""Matching: from image segments and a seed pose to hypotheses of the pose."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from vision_server.matching.match import Anywhere, Hypothesis, SearchRange
from vision_server.matching.search import match_search
from vision_server.rivals.genetic import match_genetic

Floats = NDArray[np.float64]
Matcher = Callable[[Floats, Model, Camera, Pose, int, SearchRange], list[Hypothesis]]

MATCHERS: dict[str, Matcher] = {"search": match_search, "genetic": match_genetic}

__all__ = ["MATCHERS", "Anywhere", "Hypothesis", "SearchRange", "match_genetic", "match_search"]
