"""Straight segments of an edge map."""
