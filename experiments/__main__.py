"""Command line of experiments: `python -m experiments COMMAND`."""

import sys

from bridge.errors import EXIT_BAD_INPUT
from bridge.lifeline import leave, leave_at_signals
from numerics.blas import use_one_blas_thread

COMMANDS = {
    "run": "Compute the cells of a plan that have no row yet; the same command again continues.",
    "compare": "Which strategy is better, where, and how sure that is: tables and plots.",
    "page": "Write the page of the results so far, OUT/results.html.",
}


def main() -> int:
    """Run a command; the exit status."""
    leave_at_signals()
    from bridge.command_line import run_command  # late: a signal that comes meanwhile ends it, too

    use_one_blas_thread()  # workers inherit it
    about = "Plans of many sessions: run them anywhere, continue them, compare strategies."
    try:
        return run_command("experiments", about, COMMANDS, sys.argv[1:])
    except ModuleNotFoundError as error:
        if error.name != "pyarrow":  # the table is written with it
            raise
        needed = "needs the package pyarrow; install it: pip install 'lights-and-camera[experiments]'"
        print(f"experiments: the table of results {needed}", file=sys.stderr)
        return EXIT_BAD_INPUT


if __name__ == "__main__":
    leave(main())
