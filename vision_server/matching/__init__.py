"""Matching: from image segments and a seed pose to candidate poses."""

from vision_server.matching.genetic import match_genetic
from vision_server.matching.match import Candidate, Match, SearchRange
from vision_server.matching.search import match_search

MATCHERS = {"search": match_search, "genetic": match_genetic}

__all__ = ["MATCHERS", "Candidate", "Match", "SearchRange", "match_genetic", "match_search"]
