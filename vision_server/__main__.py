"""Command line of the vision server: `python -m vision_server COMMAND`.

A command's file is loaded when it is asked for, and what computes when it runs: a session waits for it."""

from __future__ import annotations

import sys
from argparse import ArgumentParser
from collections.abc import Sequence
from importlib import import_module

from bridge.lifeline import leave
from geometry.kernels import use_library

PROGRAM = "python -m vision_server"
COMMANDS = {
    "serve": "Serve pose estimation to a controller.",
    "estimate": "Estimate the pose of a target from image files of one set.",
    "edges": "Merge image files of one set into one edge map.",
    "warm": "Compile every numeric kernel, once.",
}
BUILDER = "warm"  # builds the library of kernels that the others use


def main(words: Sequence[str]) -> int:
    """Run a command; the exit status."""
    if not words or words[0] in ("-h", "--help"):
        listed = "\n".join(f"  {name:<10}{summary}" for name, summary in COMMANDS.items())
        print(f"Usage: {PROGRAM} COMMAND ...\n\nImages in, edges and poses out.\n\nCommands:\n{listed}")
        print(f"\n{PROGRAM} COMMAND --help tells more.")
        return 0 if words else 2
    name = words[0]
    if name not in COMMANDS:
        print(f"vision_server: no command {name!r}; there are {', '.join(COMMANDS)}.", file=sys.stderr)
        return 2
    if name != BUILDER:
        use_library("vision_server")
    command = import_module(f"vision_server.commands.{name}")
    parser = ArgumentParser(prog=f"{PROGRAM} {name}", description=COMMANDS[name], allow_abbrev=False)
    command.add_options(parser)
    status: int = command.run(parser.parse_intermixed_args(words[1:]))
    return status


if __name__ == "__main__":
    leave(main(sys.argv[1:]))
