"""What `make bench` prints: one JSON object a line, peers measured in the same run.

Everything, or only the parts that are named.
"""

import subprocess
from collections.abc import Callable
from pathlib import Path

from benchmarks.edge_times import all_edge_times
from benchmarks.lines import show
from benchmarks.pose_times import pose_times
from benchmarks.simulator_times import simulator
from benchmarks.transport import transport
from bridge.command_line import new_parser
from numerics.memory import keep_freed_memory

ROOT = Path(__file__).resolve().parent.parent


def golog() -> None:
    """Steps of Golog programs; memory of a long run."""
    script = ROOT / "benchmarks" / "golog.pl"
    for words in ([], ["memory", "offline"], ["memory", "online"]):
        subprocess.run(["swipl", str(script), *words], check=True, stdin=subprocess.DEVNULL)


PARTS: dict[str, Callable[[], None]] = {
    "edges": lambda: all_edge_times(show),
    "poses": lambda: pose_times(show),
    "golog": golog,
    "simulator": lambda: simulator(show),
    "transport": lambda: transport(show),
}

if __name__ == "__main__":
    parser = new_parser("python -m benchmarks", __doc__)
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"{', '.join(PARTS)} (default: all)")
    named = parser.parse_args().parts
    if unknown := [part for part in named if part not in PARTS]:
        parser.error(f"no part {unknown[0]!r}; there are {', '.join(PARTS)}")
    keep_freed_memory()  # as the servers do
    for name, measure in PARTS.items():
        if not named or name in named:
            measure()
