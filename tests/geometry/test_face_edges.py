"""The edges of random polygons beside a plain loop over their sides."""

import numpy as np
import pytest

from geometry.face_edges import edges_of
from numerics.arrays import Ints


def plainly(faces: list[Ints]) -> dict[tuple[int, int], list[tuple[int, bool]]]:
    """For each edge its faces, and whether each runs from the lower index to the higher."""
    out: dict[tuple[int, int], list[tuple[int, bool]]] = {}
    for number, face in enumerate(faces):
        for a, b in zip(face.tolist(), np.roll(face, -1).tolist(), strict=True):
            if a != b:
                out.setdefault((min(a, b), max(a, b)), []).append((number, a < b))
    return out


@pytest.mark.parametrize("seed", range(20))
def test_edges_are_those_of_a_plain_loop_in_its_order(seed: int) -> None:
    rng = np.random.default_rng(seed)
    faces = [rng.integers(0, 9, rng.integers(1, 7)) for _ in range(rng.integers(0, 12))]
    edges, plain = edges_of(faces), plainly(faces)
    assert list(map(tuple, edges.ends.tolist())) == list(plain)
    for sharers, begin, uses in zip(edges.sharers, edges.begin, plain.values(), strict=True):
        own = slice(begin, begin + sharers)
        assert list(zip(edges.face[own].tolist(), edges.up[own].tolist(), strict=True)) == uses
    of_two = edges.sharers == 2
    pairs, same_run = edges.pairs(of_two)
    told = [uses for uses in plain.values() if len(uses) == 2]
    assert pairs.tolist() == [[one[0] for one in uses] for uses in told]
    assert same_run.tolist() == [uses[0][1] == uses[1][1] for uses in told]
