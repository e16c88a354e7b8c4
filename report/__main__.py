"""`python -m report RUN_FOLDER`: write the folder's report.html and overlay pictures."""

import sys
from pathlib import Path

from bridge.command_line import new_parser
from bridge.lifeline import leave
from numerics.memory import collect_rarely
from report.errors import ReportError


def main() -> int:
    """Write RUN_FOLDER/report.html and RUN_FOLDER/images/<id>-overlay.png; the exit status."""
    parser = new_parser(
        "python -m report", "Write RUN_FOLDER/report.html and overlay pictures of its images."
    )
    parser.add_argument(
        "run_folder", type=Path, metavar="RUN_FOLDER", help="Run folder of a session, with its result.json."
    )
    folder = parser.parse_args().run_folder

    collect_rarely()
    from report.page import write_report  # late: --help must not wait for numba

    try:
        path = write_report(folder)
    except ReportError as error:
        print(f"report: {error}", file=sys.stderr)
        return 2
    print(path)
    return 0


if __name__ == "__main__":
    leave(main())
