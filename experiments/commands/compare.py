"""`python -m experiments compare`: strategies beside each other."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

from bridge.command_line import whole_number


def add_options(parser: ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument("table", type=Path, metavar="OUT", help="Folder of a run, finished or not.")
    parser.add_argument("--out", type=Path, required=True, metavar="FOLDER", help="For tables and plots.")
    parser.add_argument(
        "--reports", type=whole_number(least=0), default=0, metavar="N",
        help="Run the N cells that decide most again, and link their reports.",
    )  # fmt: skip


def run(options: Namespace) -> int:
    """Compare; the exit status."""
    from experiments.compared import compare_table

    compare_table(options.table, options.out, options.reports)
    return 0
