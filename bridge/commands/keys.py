"""`python -m bridge keys`: keys for servers that are reached over a network."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace
from pathlib import Path

from bridge.errors import LightsAndCameraError


def add_options(parser: ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument("folder", type=Path, metavar="DIR", help="New folder for the keys.")


def run(options: Namespace) -> int:
    """Make the keys and print their files; the exit status."""
    from bridge.keys import make_keys

    try:
        for file in make_keys(options.folder):
            print(file)
    except LightsAndCameraError as error:
        print(f"bridge: {error}", file=sys.stderr)
        return error.exit_status
    return 0
