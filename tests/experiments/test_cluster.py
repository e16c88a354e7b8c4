"""Plans on a dask cluster whose scheduler and workers are processes of their own."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest

from tests.experiments.experiment import EMPTY, ROOT, computed, plan_file, rows, run, run_here, started
from tests.session.scenes import small

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(find_spec("distributed") is None, reason="no package distributed"),
]

SLOW = EMPTY.format(last=50) + "threshold = 0.02\n"  # a cell of this test takes 0.02 s
SESSION = 'controllers = ["auto_exposed"]\ntargets = ["cube"]\nseeds = "1"\nmax_iterations = 1\n'


class Cluster:
    """A scheduler and workers, each a process."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        (folder / "sitecustomize.py").write_text(
            "import time\n"
            "import experiments.computing as computing\n"
            "row_of = computing.row_of\n"
            "def slow(cell, keep=None):\n"
            "    if cell.settings.kind == 'empty':\n"
            "        time.sleep(cell.settings.threshold or 0.0)\n"
            "    return row_of(cell, keep)\n"
            "computing.row_of = slow\n"
        )
        self.port = 0
        self.processes: list[subprocess.Popen[bytes]] = []
        self.scheduler = self.start_scheduler()

    @property
    def address(self) -> str:
        return f"tcp://127.0.0.1:{self.port}"

    def start_scheduler(self) -> "subprocess.Popen[bytes]":
        file = self._folder / "scheduler.json"
        file.unlink(missing_ok=True)
        scheduler = self._start(
            "scheduler", "--host", "127.0.0.1", "--port", str(self.port), "--scheduler-file", str(file),
            "--no-dashboard",
        )  # fmt: skip
        deadline = time.monotonic() + 60
        while not file.exists() or '"address"' not in file.read_text():
            assert time.monotonic() < deadline
            assert scheduler.poll() is None
            time.sleep(0.05)
        self.port = int(file.read_text().split('"address"')[1].split('"')[1].rpartition(":")[2])
        return scheduler

    def start_worker(self) -> "subprocess.Popen[bytes]":
        return self._start("worker", self.address, "--nthreads", "1", "--no-nanny", "--no-dashboard")

    def _start(self, *words: str) -> "subprocess.Popen[bytes]":
        environment = {
            "PYTHONPATH": f"{self._folder}{os.pathsep}{ROOT}", "DASK_TEMPORARY_DIRECTORY": str(self._folder)
        }  # fmt: skip
        process = subprocess.Popen(
            [sys.executable, "-m", "dask", *words], cwd=self._folder, env={**os.environ, **environment},
            stdout=subprocess.DEVNULL, stderr=(self._folder / "dask.log").open("a"),
        )  # fmt: skip
        self.processes.append(process)
        return process

    def close(self) -> None:
        for process in self.processes:
            process.kill()
        for process in self.processes:
            process.wait()


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[Cluster]:
    (tmp_path / "cluster").mkdir()
    made = Cluster(tmp_path / "cluster")
    yield made
    made.close()


def wait_for_rows(out: Path, count: int) -> None:
    deadline = time.monotonic() + 120
    while not (out / "rows.jsonl").exists() or (out / "rows.jsonl").read_bytes().count(b"\n") < count:
        assert time.monotonic() < deadline
        time.sleep(0.02)


def test_a_worker_killed_and_the_scheduler_restarted_give_the_same_table(
    tmp_path: Path, cluster: Cluster
) -> None:
    plan, out = plan_file(tmp_path, SLOW), tmp_path / "out"
    workers = [cluster.start_worker(), cluster.start_worker()]
    process = started(plan, out, "--cluster", cluster.address)
    wait_for_rows(out, 10)
    workers[0].send_signal(signal.SIGKILL)
    wait_for_rows(out, 30)
    cluster.scheduler.kill()
    cluster.scheduler.wait()
    workers[1].kill()
    cluster.scheduler = cluster.start_scheduler()
    cluster.start_worker()
    _, errors = process.communicate(timeout=180)
    assert process.returncode == 0, errors
    assert "dashboard" in errors
    assert len(rows(out)) == 100
    assert rows(out) == rows(computed(plan, tmp_path / "alone"))


def approx(value: float) -> object:
    """To the last bits of a sum, which depend on where in memory an array lies."""
    return pytest.approx(value, rel=1e-8, abs=1e-12)


def test_processes_of_this_machine_as_a_cluster(tmp_path: Path) -> None:
    plan = plan_file(tmp_path, f'{SESSION}scenarios = ["{small()}"]\n')
    done = run_here(plan, tmp_path / "out", "--cluster", "local:2")
    assert done.returncode == 0, done.stderr
    ((row,), (expected,)) = (rows(tmp_path / "out"), rows(computed(plan, tmp_path / "alone")))
    assert row["status"] == "converged"
    assert row == {
        key: approx(value) if isinstance(value, float) else value for key, value in expected.items()
    }


def test_rows_that_went_with_the_scheduler_are_computed_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    distributed = pytest.importorskip("distributed")
    gathered, asked = distributed.Future.result, []

    def result(future: object) -> object:
        asked.append(future)
        if len(asked) == 1:
            raise distributed.comm.CommClosedError("Stream is closed")
        return gathered(future)

    monkeypatch.setattr(distributed.Future, "result", result)
    plan = plan_file(tmp_path, EMPTY.format(last=3))
    done = run_here(plan, tmp_path / "out", "--cluster", "local:1")
    assert done.returncode == 0, done.stderr
    assert len(asked) > 1
    assert rows(tmp_path / "out") == rows(computed(plan, tmp_path / "alone"))


def test_workers_of_another_version_are_refused(tmp_path: Path, cluster: Cluster) -> None:
    custom = tmp_path / "cluster" / "sitecustomize.py"
    custom.write_text("import experiments.version as v\nv.code_version = lambda: 'another'\n")
    cluster.start_worker()
    done = run(plan_file(tmp_path, EMPTY.format(last=3)), tmp_path / "out", "--cluster", cluster.address)
    assert done.returncode == 4
    assert "has version another of the project" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    ("address", "says"),
    [
        ("tcp://127.0.0.1:9", "No dask scheduler answers at tcp://127.0.0.1:9"),
        ("local:x", "no number of processes"),
        ("nonsense", "No dask scheduler answers at nonsense"),
    ],
)
def test_an_address_that_does_not_answer(tmp_path: Path, address: str, says: str) -> None:
    done = run_here(plan_file(tmp_path, EMPTY.format(last=3)), tmp_path / "out", "--cluster", address)
    assert done.returncode == 2
    assert says in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
