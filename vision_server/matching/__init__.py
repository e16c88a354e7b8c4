"""Matching: from image segments and a seed pose to hypotheses of the pose."""

from vision_server.matching.match import Anywhere, Hypothesis, SearchRange
from vision_server.matching.search import match_search

__all__ = ["Anywhere", "Hypothesis", "SearchRange", "match_search"]
