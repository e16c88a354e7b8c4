"""`python -m report RUN_FOLDER` writes its page; `live` shows it while it runs, `whatif` chooses anew."""

import sys
from argparse import Namespace, RawDescriptionHelpFormatter
from collections.abc import Callable
from contextlib import closing, suppress
from functools import partial
from pathlib import Path

from bridge.command_line import listed, new_parser, status_of, whole_number
from bridge.lifeline import leave, leave_at_signals
from numerics.memory import collect_rarely

ABOUT = {
    "": "Write RUN_FOLDER/report.html and overlay pictures of its images.",
    "live": "Show a session in a browser while it runs, or one that has ended.",
    "whatif": "Do a session again with one image under other settings, and show both ways side by side.",
}


def main() -> int:
    """Write the report, serve the live view or try another choice; the exit status."""
    words = sys.argv[1:]
    command = words[0] if words[:1] in (["live"], ["whatif"]) else ""
    parser = new_parser(f"python -m report {command}".strip(), ABOUT[command])
    if not command:
        commands = {name: about for name, about in ABOUT.items() if name}
        parser.epilog = f"Commands:\n{listed(commands)}\n\npython -m report COMMAND --help tells more."
        parser.formatter_class = RawDescriptionHelpFormatter
    parser.add_argument("run_folder", type=Path, metavar="RUN_FOLDER", help="Run folder of a session.")
    if not command:
        parser.add_argument(
            "--when-told",
            action="store_true",
            help="Get ready, and write at the first line on standard input.",
        )
    elif command == "live":
        parser.add_argument(
            "--port",
            type=whole_number(0, 65535),
            default=0,
            help="Port on 127.0.0.1; 0 (the default): any free one.",
        )
        parser.add_argument(
            "--parent", type=whole_number(), metavar="PID", help="Stop when this process ends."
        )
    elif command == "whatif":
        parser.add_argument(
            "--at", type=whole_number(1), required=True, metavar="N", help="Number of the image."
        )
        parser.add_argument(
            "--settings",
            required=True,
            help="Such as 'left 7 right 0 top 0, 1/60 s, f/4'; lights that are not named are off.",
        )
        parser.add_argument(
            "--out",
            type=Path,
            metavar="DIR",
            help="Run folder of the other way (default: RUN_FOLDER-whatif-N).",
        )
    options = parser.parse_args(words[1 if command else 0 :])
    collect_rarely()
    does: dict[str, Callable[[Namespace], int]] = {"": _write, "live": _serve, "whatif": _try}
    return status_of("report", partial(does[command], options))


def _write(options: Namespace) -> int:
    from report.following import Journal

    with closing(Journal(options.run_folder, every_reason=True)) as journal:
        with suppress(OSError):  # without swipl there is a page all the same, which says so
            journal.start()
        from report.page import write_report  # late: the reader starts meanwhile

        if not options.when_told or sys.stdin.readline():
            print(write_report(options.run_folder, journal))
    return 0


def _serve(options: Namespace) -> int:
    from report.live import serve_view

    serve_view(options.run_folder, options.port, options.parent)
    return 0


def _try(options: Namespace) -> int:
    from report.whatif import print_what_if, what_if, write_what_if

    done = what_if(options.run_folder, options.at, options.settings, options.out)
    print_what_if(done)
    print(write_what_if(done))
    return 0


if __name__ == "__main__":
    leave_at_signals()
    leave(main())
