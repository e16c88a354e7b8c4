"""What `make bench` prints: one JSON object a line, peers measured in the same run.

Everything, or only the parts that are named.
"""

import subprocess
from collections.abc import Callable
from pathlib import Path

from benchmarks.edge_times import all_edge_times
from benchmarks.lines import show
from benchmarks.pose_times import pose_times
from benchmarks.progress import measuring
from benchmarks.simulator_times import simulator
from benchmarks.transport import transport
from bridge.command_line import new_parser
from numerics.memory import keep_freed_memory

ROOT = Path(__file__).resolve().parent.parent


def golog() -> None:
    """Steps of Golog programs; memory of a long run."""
    script = ROOT / "benchmarks" / "golog.pl"
    for words in ([], ["memory", "offline"], ["memory", "online"]):
        command = ["swipl", str(script), *words]
        with subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True
        ) as measured:
            assert measured.stdout is not None
            for line in measured.stdout:
                print(line, end="", flush=True)  # above what is shown of the progress
        if measured.returncode != 0:
            raise subprocess.CalledProcessError(measured.returncode, command)


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
    names = [name for name in PARTS if not named or name in named]
    with measuring(names) as begin:
        for name in names:
            begin(name)
            PARTS[name]()
