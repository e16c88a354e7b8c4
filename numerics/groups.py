"""Groups of items that pairs join: union-find, as kernels take it."""

from __future__ import annotations

from numerics.arrays import Ints
from numerics.kernels import kernel


@kernel()
def root(parent: Ints, item: int) -> int:
    """The item that a group is named after; each item (N,) has a parent in its group, this one itself."""
    while parent[item] != item:
        parent[item] = parent[parent[item]]
        item = parent[item]
    return item
