"""Command line of the vision server: `python -m vision_server COMMAND`.

A command's file is loaded when it is asked for, and what computes when it runs: a session waits for it."""

from __future__ import annotations

import sys
from argparse import ArgumentParser
from collections.abc import Sequence
from importlib import import_module

from bridge.lifeline import leave
from bridge.subcommands import chosen_command
from numerics.kernels import use_library
from numerics.memory import keep_freed_memory

COMMANDS = {
    "serve": "Serve pose estimation to a controller.",
    "estimate": "Estimate the pose of a target from image files of one set.",
    "edges": "Merge image files of one set into one edge map.",
    "warm": "Compile every numeric kernel, once.",
}
BUILDER = "warm"  # builds the library of kernels that the others use


def main(words: Sequence[str]) -> int:
    """Run a command; the exit status."""
    name = chosen_command("vision_server", "Images in, edges and poses out.", COMMANDS, words)
    keep_freed_memory()
    if name != BUILDER:
        use_library("vision_server")
    command = import_module(f"vision_server.commands.{name}")
    parser = ArgumentParser(
        prog=f"python -m vision_server {name}", description=COMMANDS[name], allow_abbrev=False
    )
    command.add_options(parser)
    status: int = command.run(parser.parse_intermixed_args(words[1:]))
    return status


def command() -> None:
    """`vision-server`, the installed command."""
    leave(main(sys.argv[1:]))


if __name__ == "__main__":
    command()
