"""`python -m experiments compare`: strategies beside each other."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

from bridge.command_line import whole_number


def add_options(parser: ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument("table", type=Path, metavar="RUN_OUT", help="The --out of a run, finished or not.")
    parser.add_argument(
        "--out", type=Path, required=True, metavar="FOLDER", help="Another folder, for tables and plots."
    )
    parser.add_argument(
        "--reports", type=whole_number(least=0), default=0, metavar="N",
        help="Run the N cells that decide most again, and link their reports.",
    )  # fmt: skip
    parser.add_argument(
        "--renew", type=Path, metavar="PAGE.md", help="Renew this plan's tables and pictures in a page."
    )


def run(options: Namespace) -> None:
    """Compare."""
    from experiments.comparison_folder import compare_table

    compare_table(options.table, options.out, options.reports, options.renew)
