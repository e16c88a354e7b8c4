"""Programs with commands: which one is meant."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence


def chosen_command(server: str, about: str, commands: Mapping[str, str], words: Sequence[str]) -> str:
    """The command that a command line begins with; without one, or for --help, print what there is and end.

    Parameters
    ----------
    commands : one line about each.
    """
    program = f"python -m {server}"
    if not words or words[0] in ("-h", "--help"):
        listed = "\n".join(f"  {name:<11}{summary}" for name, summary in commands.items())
        print(f"Usage: {program} COMMAND ...\n\n{about}\n\nCommands:\n{listed}")
        print(f"\n{program} COMMAND --help tells more.")
        sys.exit(0 if words else 2)
    if words[0] not in commands:
        known = ", ".join(commands)
        print(f"{server}: no command {words[0]!r}; there are {known}.", file=sys.stderr)
        sys.exit(2)
    return words[0]
