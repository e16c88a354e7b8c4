"""`python -m bridge keys`: keys for servers that are reached over a network."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path


def add_options(parser: ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument("folder", type=Path, metavar="DIR", help="New folder for the keys.")


def run(options: Namespace) -> None:
    """Make the keys and print their files."""
    from bridge.keys import make_keys

    for file in make_keys(options.folder):
        print(file)
