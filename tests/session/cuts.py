"""Sessions whose journal is cut: do they come to what they came to?

    .venv/bin/python -m tests.session.cuts          # after every line, and at every byte of the last lines

On servers that stay, so that each of the hundreds of resumed sessions costs little. Prints one JSON
object for each cut that leads elsewhere, and one for each kind of session.
"""

import argparse
import json
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tests.session.cases import CASES, words_of
from tests.session.command import outcome
from tests.session.kills import frames
from tests.session.serving import kept_servers, served

BRIEF = ("--no-report", "--quiet")


def places(journal: bytes, every: int, last_lines: int) -> list[int]:
    """Lengths of the journal to cut it to: after every so manyth line, and byte of the last lines."""
    ends = [number + 1 for number, byte in enumerate(journal) if byte == ord("\n")]
    inside = range(ends[-1 - last_lines] + 1, ends[-1], every) if last_lines else range(0)
    return sorted({*ends[:-1:every], *inside})


def cut_everywhere(case: str, every: int, last_lines: int) -> Iterator[dict[str, Any]]:
    """What comes of each cut of one session of a case: `at`, `after`, and whether it is the `same`."""
    with tempfile.TemporaryDirectory() as folder:
        whole = Path(folder) / "whole"
        done = served(*words_of(case), *BRIEF, "--out", whole)
        assert done.returncode in (0, 3), done.stderr
        expected, pixels, journal = outcome(whole), frames(whole), (whole / "history.pl").read_bytes()
        for at in places(journal, every, last_lines):
            out = Path(folder) / "cut"
            shutil.copytree(whole, out)
            (out / "result.json").unlink()
            (out / "history.pl").write_bytes(journal[:at])
            resumed = served("--resume", out, *BRIEF)
            same = (
                resumed.returncode == done.returncode and outcome(out) == expected and frames(out) == pixels
            )
            after = journal[:at].splitlines()[-1][:60].decode()
            yield {"case": case, "at": at, "after": after, "same": same, "said": resumed.stderr[-300:]}
            shutil.rmtree(out)


def main() -> int:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--case", choices=CASES, action="append", help="Only these sessions; repeatable.")
    parser.add_argument(
        "--every", type=int, default=1, help="Cut after every so manyth line, and byte of the last."
    )
    parser.add_argument("--last-lines", type=int, default=4, help="Lines that are cut at every byte.")
    options = parser.parse_args()
    wrong = 0
    for case in options.case or CASES:
        with kept_servers():
            found = list(cut_everywhere(case, options.every, options.last_lines))
        other = [one for one in found if not one["same"]]
        for one in [*other, {"case": case, "cuts": len(found), "same": len(found) - len(other)}]:
            print(json.dumps(one), flush=True)
        wrong += len(other)
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
