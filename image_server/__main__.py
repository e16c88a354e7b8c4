"""Command line of the image server: `python -m image_server COMMAND`.

A command's file is loaded when it is asked for: a session waits for it."""

from __future__ import annotations

import sys
from argparse import ArgumentParser
from collections.abc import Callable, Sequence
from importlib import import_module

from bridge.subcommands import chosen_command
from image_server.command_line import add_options, call

COMMANDS = {
    "replay": "Serve a recorded light stack.",
    "simulator": "Serve a ray-traced target under lights and a sun.",
    "hardware": "Serve a V4L2 camera, with lights on a serial line or without.",
    "cameras": "List the cameras of this machine with their formats and controls.",
    "calibrate": "Measure a camera in front of a steadily lit scene, and write its camera file.",
    "record": "Write a stack folder from a camera with lights, a stack or the simulator.",
    "warm": "Compile the simulator's kernels, once.",
}
FILES = {"simulator": "simulate", "cameras": "hardware"}  # of commands that are not called like theirs


def main(words: Sequence[str]) -> None:
    """Run a command; it ends with the exit status."""
    name = chosen_command("image_server", "A camera and lights: settings in, frame out.", COMMANDS, words)
    file = import_module(f"image_server.commands.{FILES.get(name, name)}")
    command: Callable[..., None] = getattr(file, name)
    program = f"python -m image_server {name}"
    parser = ArgumentParser(prog=program, description=command.__doc__, allow_abbrev=False)
    add_options(parser, command)
    call(command, parser.parse_intermixed_args(words[1:]))


def command() -> None:
    """`image-server`, the installed command."""
    main(sys.argv[1:])


if __name__ == "__main__":
    command()
