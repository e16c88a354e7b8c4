"""What `make bench` prints: one JSON object a line, peers measured in the same run."""

import subprocess
from pathlib import Path

from benchmarks.edge_times import all_edge_times
from benchmarks.lines import show
from benchmarks.pose_times import pose_times
from benchmarks.simulator_times import simulator
from benchmarks.transport import transport
from numerics.memory import keep_freed_memory

ROOT = Path(__file__).resolve().parent.parent


def golog() -> None:
    """Steps of Golog programs, against the published interpreter; memory of a long run."""
    script = ROOT / "benchmarks" / "golog.pl"
    for words in ([], ["memory", "offline"], ["memory", "online"]):
        subprocess.run(["swipl", str(script), *words], check=True, stdin=subprocess.DEVNULL)


if __name__ == "__main__":
    keep_freed_memory()  # as the servers do
    all_edge_times(show)
    pose_times(show)
    golog()
    simulator(show)
    transport(show)
