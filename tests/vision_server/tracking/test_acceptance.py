"""How much of a target has to be seen for it to be followed, and to be found again."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import pytest

from vision_server.pose.support import PoseSupport
from vision_server.tracking.acceptance import is_partly_whole, is_whole


def supported(*lines: tuple[float, float]) -> PoseSupport:
    """Lines of so many px and such support."""
    seen = [SimpleNamespace(visible_px=px, support=share) for px, share in lines]
    return cast("PoseSupport", SimpleNamespace(lines=seen))


@pytest.mark.parametrize(
    ("lines", "partly", "wholly"),
    [
        ([(100.0, 1.0)], True, True),
        ([(80.0, 0.5), (20.0, 0.75)], True, True),
        ([(81.0, 0.5), (19.0, 0.75)], False, True),
        ([(85.0, 0.3), (15.0, 0.29)], False, True),
        ([(84.0, 0.9), (16.0, 0.29)], True, False),
        ([], True, True),
    ],
)
def test_lines_count_by_their_length(lines: list[tuple[float, float]], partly: bool, wholly: bool) -> None:
    assert is_partly_whole(supported(*lines)) == partly
    assert is_whole(supported(*lines)) == wholly
