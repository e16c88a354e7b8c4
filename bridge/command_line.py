"""Command lines of the Python programs: `python -m PROGRAM COMMAND OPTIONS`.

A program names its commands, each a file `PROGRAM/commands/COMMAND.py` with `add_options(parser)` and
`run(options)`, which returns the exit status where that is not 0. What cannot be used or fails is raised, and
told here: one line, and the error's own exit status (`bridge.errors`). Only the file of the command that is
asked for is imported, and what computes is imported when it runs: a session waits for it.
"""

from __future__ import annotations

import math
import os
import sys
from argparse import ArgumentParser, ArgumentTypeError
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import TypeVar

from bridge import __version__
from bridge.errors import EXIT_BAD_INPUT, EXIT_DEVICE, BadInput, LightsAndCameraError
from bridge.stopping import Stopped

Number = TypeVar("Number", int, float)
MOST_SEED = 2**63 - 1  # as in `bridge.messages`, which takes longer to load
EXIT_READER_GONE = 141  # as a shell says of a program that SIGPIPE ends


def run_command(name: str, about: str, commands: Mapping[str, str], words: Sequence[str]) -> int:
    """Run the command that a command line begins with; the exit status.

    Parameters
    ----------
    name, about
        The program's package, and one line about it.
    commands
        One line about each command.
    words
        The command line, without the program.
    """
    return status_of(name, lambda: _run_command(name, about, commands, words))


def status_of(name: str, does: Callable[[], int]) -> int:
    """The exit status of what a program does; what that raises is told."""
    _open_what_is_closed()
    try:
        status = does()
        sys.stdout.flush()
    except BrokenPipeError:  # its reader has seen enough; nothing more can be said there
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return EXIT_READER_GONE
    except Stopped as stopped:
        return stopped.status
    except (LightsAndCameraError, OSError) as error:
        print(f"{name}: {' '.join(str(error).split())}", file=sys.stderr)
        return error.exit_status if isinstance(error, LightsAndCameraError) else EXIT_DEVICE
    return status


def _open_what_is_closed() -> None:
    """Open standard output and error that a shell has closed (`>&-`), or files take their places.

    To write there is an error on output, as it is where a disk is full; what is said on error goes nowhere.
    """
    for place, name, mode in ((1, "stdout", os.O_RDONLY), (2, "stderr", os.O_WRONLY)):
        if getattr(sys, name) is None:
            opened = os.open(os.devnull, mode)
            if opened != place:
                os.dup2(opened, place)
                os.close(opened)
            setattr(sys, name, os.fdopen(place, "w", encoding="utf-8", closefd=False))


def _run_command(name: str, about: str, commands: Mapping[str, str], words: Sequence[str]) -> int:
    installed = name.replace("_", "-")
    program = installed if Path(sys.argv[0]).name == installed else f"python -m {name}"
    if not words or words[0] in ("-h", "--help"):
        print(f"Usage: {program} COMMAND ...\n\n{about}\n\nCommands:\n{listed(commands)}")
        print(f"\n{program} COMMAND --help tells more.")
        return 0 if words else EXIT_BAD_INPUT
    if words[0] == "--version":
        print(f"{name} {__version__}")
        return 0
    if words[0] not in commands:
        from difflib import get_close_matches

        near = get_close_matches(words[0], commands, 1)
        hint = f" Did you mean {near[0]}?" if near else ""
        print(f"{name}: no command {words[0]!r}; there are {', '.join(commands)}.{hint}", file=sys.stderr)
        return EXIT_BAD_INPUT
    command = import_module(f"{name}.commands.{words[0].replace('-', '_')}")
    parser = new_parser(f"{program} {words[0]}", commands[words[0]])
    command.add_options(parser)
    try:
        options = parser.parse_intermixed_args(words[1:])
    except SystemExit as end:  # help, or what cannot be read, is written
        return EXIT_BAD_INPUT if end.code else 0
    return command.run(options) or 0


def listed(commands: Mapping[str, str]) -> str:
    """Commands and what is said of each, no wider than the terminal."""
    from shutil import get_terminal_size
    from textwrap import fill

    width = max(get_terminal_size().columns, 40)
    return "\n".join(
        fill(about, width, initial_indent=f"  {name:<16}", subsequent_indent=18 * " ", break_on_hyphens=False)
        for name, about in commands.items()
    )


def new_parser(program: str, about: str) -> ArgumentParser:
    """A parser that knows --help and --version, and takes no option for another that begins like it."""
    parser = ArgumentParser(prog=program, description=about, allow_abbrev=False)
    parser.add_argument(
        "--version", action="version", version=f"{program.removeprefix('python -m ')} {__version__}"
    )
    return parser


def add_serving(parser: ArgumentParser) -> None:
    """Where a server listens, and what ends it."""
    parser.add_argument(
        "--endpoint", required=True, help="Where to listen: ipc:///path or tcp://127.0.0.1:PORT."
    )
    add_keys(parser)
    parser.add_argument("--parent", type=whole_number(), metavar="PID", help="Stop when this process ends.")
    parser.add_argument(
        "--idle-s",
        type=number(0),
        metavar="S",
        help="Stop when for so long no request has come and nobody was connected.",
    )


def add_keys(parser: ArgumentParser) -> None:
    """Keys for a connection over a network."""
    parser.add_argument(
        "--keys", type=Path, metavar="DIR",
        help="CURVE keys (python -m bridge keys DIR), for servers on a network.",
    )  # fmt: skip


def number(least: float = -math.inf, most: float = math.inf) -> Callable[[str], float]:
    """What reads a finite number in these bounds."""
    return _reader(float, "a number", least, most)


def whole_number(least: float = -math.inf, most: float = math.inf) -> Callable[[str], int]:
    """What reads a whole number in these bounds."""
    return _reader(int, "a whole number", least, most)


def output_file(word: str) -> Path:
    """Read the name of a file to write at the end; what keeps it from that is said at once.

    Raises
    ------
    BadInput
        It is a folder, its folder is not there, or it may not be written.
    """
    file = Path(word)
    if file.is_dir():
        raise BadInput(f"Cannot write {file}: it is a folder.", "Name a file in it.")
    if not file.parent.is_dir():
        raise BadInput(f"Cannot write {file}: there is no folder {file.parent}.", "Make it, or name another.")
    if not os.access(file if file.exists() else file.parent, os.W_OK):
        raise BadInput(f"Cannot write {file}: you may not.", "Name another place.")
    return file


def counted(count: int, name: str) -> str:
    """So many, in the plural where they are not one."""
    return f"{count} {name}{'' if count == 1 else 's'}"


def _bounds(least: float, most: float) -> str:
    if math.isinf(least) and math.isinf(most):
        return "a finite number"
    lower, upper = (f"{bound}" if isinstance(bound, int) else f"{bound:g}" for bound in (least, most))
    if math.isinf(most):
        return f"at least {lower}"
    return f"at most {upper}" if math.isinf(least) else f"{lower} to {upper}"


def _reader(kind: Callable[[str], Number], words: str, least: float, most: float) -> Callable[[str], Number]:
    def read(word: str) -> Number:
        try:
            value = kind(word)
        except ValueError:
            raise ArgumentTypeError(f"{word!r} is not {words}") from None
        if not (math.isfinite(value) and least <= value <= most):
            raise ArgumentTypeError(f"must be {_bounds(least, most)}, not {word}")
        return value

    return read
