"""Baselines: what the project's own ways are compared with.

`merge_rules`: other rules that make one edge map of several images (`--method mean`, `max-image`, …).
`linking`, `splitting`: the paper's segments (`split_segments`, in `python -m benchmarks.edge_segments`).
`genetic`: the paper's matcher (`--matcher genetic`).
"""

from typing import Literal, get_args

MergeRule = Literal["mean", "max-image", "max-gradient", "di-zenzo", "mertens"]
MERGE_RULES: tuple[MergeRule, ...] = get_args(MergeRule)
"""Names of the rules that `merge_rules` has."""
