"""`python -m report RUN_FOLDER`: write the folder's report.html and overlay pictures."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from report.errors import ReportError


def main(
    run_folder: Annotated[Path, typer.Argument(help="Run folder of a session, with its result.json.")],
) -> None:
    """Write RUN_FOLDER/report.html and RUN_FOLDER/images/<id>-overlay.png."""
    from report.page import write_report  # late: --help must not wait for numba

    try:
        path = write_report(run_folder)
    except ReportError as error:
        print(f"report: {error}", file=sys.stderr)
        raise typer.Exit(2) from error
    print(path)


if __name__ == "__main__":
    typer.run(main)
