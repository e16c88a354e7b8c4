"""What a strategy senses and hears of by itself, beside what the servers tell it."""

import shutil
from pathlib import Path

import pytest

from tests.session.command import cut, steps_of
from tests.session.scenes import small
from tests.session.serving import served

pytestmark = pytest.mark.slow

AT_RANDOM = """fun_fluent(celsius).
prim_action(read_celsius).
poss(read_celsius, true).
senses(read_celsius, celsius).
execute(read_celsius, C) :- random_between(40, 80, C).
fun_fluent(bumps).
initially(bumps, 0).
exog_action(bump).
causes_val(bump, bumps, N, N is bumps + 1).
exog_occurs(bump) :- random(R), R < 0.2.
proc(control, while(neg(exhausted), [read_celsius, choose_random, take_image, measure, keep_image])).
"""


def test_a_session_goes_on_where_it_draws_at_random(tmp_path: Path) -> None:
    (tmp_path / "mine.pl").write_text(AT_RANDOM)
    options = ("--controller", tmp_path / "mine.pl", "--scenario", small(), "--threshold", "0.000001")
    whole = tmp_path / "whole"
    done = served(*options, "--max-iterations", "3", "--out", whole, "--no-report", "--quiet")
    assert done.returncode == 3, done.stderr
    for image in ("i1", "i2"):
        out = tmp_path / image
        shutil.copytree(whole, out)
        (out / "result.json").unlink()
        cut(out / "history.pl", f"capture({image},")
        resumed = served("--resume", out, "--no-report", "--quiet")
        assert resumed.returncode == 3, (image, resumed.stderr)
        assert [step[:4] for step in steps_of(out)] == [step[:4] for step in steps_of(whole)]
