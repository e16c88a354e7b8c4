"""Command line of the bridge: `python -m bridge COMMAND`."""

import sys

from bridge.lifeline import leave, leave_at_signals

COMMANDS = {
    "keys": "Make keys for servers that are reached over a network: for both servers and the controller.",
    "new-controller": "Make a strategy of your own, with its tests and a plan to compare it.",
    "schema": "Print the JSON Schema of result.json (session/result.schema.json).",
    "results": "Print the types of all results as Prolog terms (bridge/prolog/results.pl).",
}


def main() -> None:
    """`python -m bridge`."""
    leave_at_signals()
    from bridge.command_line import run_command  # late: a signal that comes meanwhile ends it, too

    leave(run_command("bridge", "What the three programs share.", COMMANDS, sys.argv[1:]))


if __name__ == "__main__":
    main()
