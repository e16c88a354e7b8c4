"""Command line of the bridge: `python -m bridge COMMAND`."""

import sys

from bridge.command_line import run_command

COMMANDS = {
    "keys": "Make keys for servers that are reached over a network: for both servers and the controller.",
    "new-controller": "Make a strategy of your own, with its tests and a plan to compare it.",
    "schema": "Print the JSON Schema of result.json (session/result.schema.json).",
    "results": "Print the types of all results as Prolog terms (bridge/prolog/results.pl).",
}

if __name__ == "__main__":
    sys.exit(run_command("bridge", "What the three programs share.", COMMANDS, sys.argv[1:]))
