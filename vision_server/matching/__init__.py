"""Matching: from image segments, and a seed pose or none, to hypotheses of the pose.

`search` is the way around a seed pose: `draws` of poses, scored and aligned with the `nearest_edges` by
`icp`. `first_sight` is the way without one: `templates` of `looks` at the model from all over the sphere,
then the same. `views` is what can be seen from each direction, `region` where in a large frame the target can
be, `match` what every matcher takes and gives.
"""

from vision_server.matching.match import Anywhere, Hypothesis, SearchRange
from vision_server.matching.search import match_search

__all__ = ["Anywhere", "Hypothesis", "SearchRange", "match_search"]
