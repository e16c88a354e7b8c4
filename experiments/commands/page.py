"""`python -m experiments page`: the page of the results so far."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path


def add_options(parser: ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument("table", type=Path, metavar="OUT", help="Folder of a run, finished or not.")


def run(options: Namespace) -> None:
    """Write the page and say where."""
    from experiments.page import write_page

    print(write_page(options.table, running=False))
