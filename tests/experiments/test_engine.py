"""Running plans: killed and continued, workers that die, rows that are those of single sessions."""

import json
import os
import random
import signal
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest

from bridge.messages import Settings
from experiments.commands import run as run_command
from experiments.computing import OtherVersion, rows_of
from experiments.engine import Start, Watch
from experiments.feed import Feed
from experiments.kinds import empty
from experiments.local_pool import LocalPool
from experiments.page import PAGE
from experiments.plan import Cell, Plan, read_plan
from experiments.table import JOURNAL, RESULTS
from experiments.version import code_version
from experiments.worker import Worker
from tests.commands import command
from tests.experiments.experiment import EMPTY, ROOT, computed, plan_file, rows, run, run_here, started
from tests.session.scenes import small
from tests.session.serving import served
from tests.stack.stack_folders import frames_stack

KILLS = 3


@pytest.mark.slow
def test_killed_at_random_moments_and_continued_it_is_the_same_table(tmp_path: Path) -> None:
    plan, out = plan_file(tmp_path, EMPTY.format(last=10_000)), tmp_path / "out"
    rng = random.Random(7)
    kills, known = 0, {}
    while kills < KILLS:
        process = started(plan, out, "--workers", "1", "--quiet")
        journal = out / JOURNAL
        size = journal.stat().st_size if journal.exists() else 0
        while process.poll() is None and (not journal.exists() or journal.stat().st_size == size):
            time.sleep(0.005)
        time.sleep(rng.uniform(0.0, 0.1))
        process.kill()
        process.communicate()
        if process.returncode == 0:
            pytest.fail(f"it came to its end before kill {kills + 1}")
        kills += 1
        here = {row["key"]: row["cell_seconds"] for row in rows(out, times=True)}
        assert known.items() <= here.items()  # what is finished stays, and is not computed again
        known = here
    assert 0 < len(known) < 20_000
    end = run(plan, out, "--workers", "1")
    assert end.returncode == 0, end.stderr
    assert f"{len(known)} of them finished" in end.stderr
    told = [(row["key"], row["controller"], row["seed"], row["images"], row["status"]) for row in rows(out)]
    whole = [
        (cell.key, cell.controller, cell.seed, cell.seed % 10, "empty") for cell in read_plan(plan).cells()
    ]
    assert sorted(told) == sorted(whole)
    assert known.items() <= {row["key"]: row["cell_seconds"] for row in rows(out, times=True)}.items()


@pytest.mark.slow
def test_a_larger_plan_adds_its_cells_and_a_finished_one_is_not_run_again(tmp_path: Path) -> None:
    out = tmp_path / "out"
    run_here(plan_file(tmp_path, EMPTY.format(last=5)), out, "--workers", "1")
    larger = plan_file(tmp_path, EMPTY.format(last=8))
    assert "6 cells computed" in run_here(larger, out, "--workers", "1").stderr
    assert pq.read_table(out / RESULTS).num_rows == 16
    before = (out / RESULTS).read_bytes()
    again = run_here(larger, out, "--workers", "1")
    assert again.returncode == 0
    assert "0 cells computed" in again.stderr
    assert (out / RESULTS).read_bytes() == before


@pytest.mark.slow
def test_stopped_by_a_signal_it_says_how_to_go_on(tmp_path: Path) -> None:
    plan, out = plan_file(tmp_path, EMPTY.format(last=100_000)), tmp_path / "out"
    process = started(plan, out, "--workers", "1")
    while not (out / JOURNAL).exists() or (out / JOURNAL).stat().st_size == 0:
        time.sleep(0.01)
        assert process.poll() is None
    process.send_signal(signal.SIGTERM)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 143
    assert "the same command continues" in errors
    assert pq.read_table(out / RESULTS).num_rows > 0
    page = (out / PAGE).read_text()
    assert "As of" in page  # and not "Running", which would load itself for ever
    assert 'http-equiv="refresh"' not in page


def cells(folder: Path, text: str) -> list[Cell]:
    return list(read_plan(plan_file(folder, text)).cells())


@pytest.mark.slow
def test_a_cell_that_kills_its_worker_is_found_and_the_others_live(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The worker's process is a fresh one: what it runs is changed by a sitecustomize on its path.
    (tmp_path / "sitecustomize.py").write_text(
        "import os\n"
        "import experiments.computing as computing\n"
        "row_of = computing.row_of\n"
        "def deadly(cell, keep=None):\n"
        "    if cell.seed == 13 and cell.controller == 'a':\n"
        "        os._exit(9)\n"
        "    return row_of(cell, keep)\n"
        "computing.row_of = deadly\n"
    )
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}{os.pathsep}{ROOT}")
    pool = LocalPool(2, code_version())
    try:
        found = [row for part in pool.rows(Feed(cells(tmp_path, EMPTY.format(last=400)))) for row in part]
    finally:
        pool.close()
    assert len({row["key"] for row in found}) == len(found) == 800
    failed = [row for row in found if row["status"] == "failed"]
    assert [(row["controller"], row["seed"]) for row in failed] == [("a", 13)]
    assert "worker's process died" in failed[0]["message"]


def test_a_worker_of_another_version_computes_nothing(tmp_path: Path) -> None:
    with pytest.raises(OtherVersion, match=code_version()[:7]):
        rows_of(cells(tmp_path, EMPTY.format(last=1)), "another")


def test_an_error_in_a_cell_is_a_row(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(cell: Cell, worker: Worker) -> dict[str, object]:
        raise ZeroDivisionError("nothing there")

    monkeypatch.setattr(empty, "run", broken)
    (row, *_) = rows_of(cells(tmp_path, EMPTY.format(last=1)), code_version())
    assert row["status"] == "failed"
    assert row["message"] == "ZeroDivisionError: nothing there"


def same(value: float) -> Any:
    """The last bits of a sum depend on where in memory an array lies."""
    return pytest.approx(value, rel=1e-9)


def session(out: Path, strategy: str, seed: str, most_images: str, *source: str) -> dict[str, Any]:
    """The result of a single session, as a user runs it."""
    served(
        "--controller", strategy, "--seed", seed, "--max-iterations", most_images, *source,
        "--no-report", "--quiet", "--out", out,
    )  # fmt: skip
    found: dict[str, Any] = json.loads((out / "result.json").read_text())
    return found


@pytest.mark.slow
def test_rows_are_those_of_single_sessions(tmp_path: Path) -> None:
    eclipse = str(small("eclipse"))
    plan = plan_file(
        tmp_path,
        f'controllers = ["heuristic", "simple"]\ntargets = ["cube"]\nscenarios = ["{eclipse}"]\nseeds = "3"\n'
        "max_iterations = 3\n",
    )
    for row in rows(computed(plan, tmp_path / "out")):
        folder = tmp_path / row["controller"]
        single = session(folder, row["controller"], "3", "3", "--target", "cube", "--scenario", eclipse)
        assert row["status"] == single["status"]
        assert row["images"] == single["iterations"]
        assert row["kept"] == len(single["kept"])
        assert row["rotation_deg"] == same(single["error"]["rotation_deg"])
        assert row["translation_fraction"] == same(single["error"]["translation_fraction_of_range"])
        assert row["merit"] == same(single["merit_px"])
        assert row["rms_px"] == same(single["rms_px"])


def test_rows_of_a_stack_are_those_of_a_single_session(tmp_path: Path, shared_data: Path) -> None:
    folder = shared_data / "stacks" / "cube-0"
    plan = plan_file(tmp_path, 'controllers = ["greedy"]\nseeds = "2"\nmax_iterations = 2\n')
    single = session(tmp_path / "one", "greedy", "2", "2", "--stack", str(folder))
    (row,) = rows(computed(plan, tmp_path / "out", folder))
    assert row["stack"] == "cube-0"
    assert row["rotation_deg"] == same(single["error"]["rotation_deg"])
    assert row["merit"] == same(single["merit_px"])


@pytest.mark.slow
def test_a_session_that_takes_too_long_is_a_row_and_the_next_one_is_well(tmp_path: Path) -> None:
    text = 'controllers = ["simple"]\ntargets = ["cube"]\nmax_iterations = 1\n'
    (slow,) = cells(tmp_path, text + "deadline_s = 0.05\n")
    (well,) = cells(tmp_path, text)
    version = code_version()
    assert rows_of([slow], version)[0]["status"] == "deadline"
    assert rows_of([well], version)[0]["status"] in ("converged", "exhausted")


@pytest.mark.slow
def test_workers_leave_nothing_behind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with tempfile.TemporaryDirectory(prefix="s") as scratch:  # paths of sockets are in it: short
        monkeypatch.setenv("TMPDIR", scratch)  # of workers, ...
        monkeypatch.setattr(tempfile, "tempdir", scratch)  # ... and of this process
        text = 'controllers = ["simple"]\ntargets = ["cube"]\nmax_iterations = 1\n'
        text += f'scenarios = ["{small()}"]\n'
        done = run_here(plan_file(tmp_path, text), tmp_path / "out", "--workers", "1")
        assert done.returncode == 0, done.stderr
        assert list(Path(scratch).iterdir()) == []


@pytest.mark.parametrize(("statuses", "status", "said"), [
    (["failed", "deadline"], 4, "2 cells computed, 2 of them failed"),
    (["failed", "converged"], 0, "2 cells computed, 1 of them failed"),
    (["exhausted"], 0, "1 cell computed, "),
    ([], 0, "0 cells computed, "),
])  # fmt: skip
def test_a_run_in_which_all_failed_is_no_success(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, statuses: list[str], status: int, said: str
) -> None:
    def told(plan: Plan, out: Path, pool: object, begun: Callable[[Start], Watch], *more: object) -> None:
        watch = begun(Start(len(statuses), 0, "paper"))
        for one in statuses:
            watch([{"status": one}])

    monkeypatch.setattr(run_command, "run_plan", told)
    monkeypatch.setattr(run_command, "_page", lambda out, running: None)
    done = command("experiments", "run", plan_file(tmp_path, EMPTY.format(last=1)), "--out", tmp_path / "out")
    assert done.returncode == status
    assert said in done.stderr


def test_recorded_frames_are_asked_for_as_by_a_session(tmp_path: Path) -> None:
    from experiments.warm_servers import device_of

    stack = frames_stack(tmp_path)
    (cell,) = cells(tmp_path, f'controllers = ["simple"]\nstacks = ["{stack}"]\nseeds = "1"\n')
    device = device_of(cell)
    asked = Settings(lights=(7, 7), shutter_s=0.0166667, aperture=4.0)
    assert not device.capture(asked).verified  # the nearest that was recorded
