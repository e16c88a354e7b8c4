"""`python -m experiments run`: the cells of a plan."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace
from contextlib import suppress
from functools import partial
from pathlib import Path

from bridge.command_line import counted, whole_number
from bridge.errors import EXIT_DEVICE, BadInput, DeviceError, LightsAndCameraError
from bridge.stopping import Stopped, Stopping
from experiments.engine import Pool, cores, run_plan
from experiments.plan import read_plan
from experiments.progress import Progressing
from experiments.units import unit_doubts


def add_options(parser: ArgumentParser) -> None:
    """Options of the command."""
    parser.description = (
        f"{parser.description} Exit status: 0 computed, 2 bad input, "
        "4 every cell that was computed failed, or the workers or the disk did."
    )
    parser.add_argument("plan", type=Path, metavar="PLAN.toml", help="Axes whose product is cells.")
    parser.add_argument(
        "stacks", type=Path, nargs="*", metavar="STACK", help="Stack folders that join the plan's."
    )
    parser.add_argument(
        "--out", type=Path, required=True, metavar="OUT", help="Folder of the table; it is continued."
    )
    parser.add_argument(
        "--workers", type=whole_number(least=1), metavar="N", help="Processes here (default: cores)."
    )
    parser.add_argument(
        "--cluster", metavar="ADDRESS", help="A dask scheduler, tcp://HOST:PORT, or local:N processes."
    )
    parser.add_argument("--seeds", metavar="A-B", help="Instead of the plan's, such as 1-5.")
    parser.add_argument("--keep", action="store_true", help="Keep run folders and reports, under OUT/cells.")
    parser.add_argument("--again", action="store_true", help="Compute cells that failed once more.")
    parser.add_argument("--quiet", action="store_true", help="Show nothing.")


def run(options: Namespace) -> int:
    """Run the plan; the exit status."""
    plan = read_plan(options.plan, options.stacks, options.seeds)
    if options.workers is not None and options.cluster is not None:
        raise BadInput("--workers and --cluster exclude each other.", "A cluster knows its workers.")
    for doubt in () if options.quiet else unit_doubts(plan):
        print(doubt, file=sys.stderr)
    with Stopping() as stopping, Progressing(options.quiet, partial(_page, options.out, True)) as progress:
        try:
            run_plan(plan, options.out, partial(_pool, options), progress.begun, stopping.each, options.again)
        except Stopped as stopped:
            _page(options.out, False)
            progress.end(f"Stopped after {counted(progress.computed, 'cell')}; the same command continues.")
            return stopped.status
        except DeviceError:
            with suppress(LightsAndCameraError):
                _page(options.out, False)
            raise
        _page(options.out, False)
        computed, failed = progress.computed, progress.failed
        words = f"{counted(computed, 'cell')} computed" + (f", {failed} of them failed" if failed else "")
        progress.end(f"{words}, {progress.rate()}; table: {options.out}/results.parquet")
    return EXIT_DEVICE if 0 < computed == failed else 0


def _pool(options: Namespace, version: str) -> Pool:
    keep = (options.out / "cells").resolve() if options.keep else None
    if options.cluster is not None:
        from experiments.dask_pool import DaskPool

        return DaskPool(options.cluster, version, keep)
    from experiments.local_pool import LocalPool

    return LocalPool(options.workers or cores(), version, keep)


def _page(out: Path, running: bool) -> None:
    from experiments.page import write_page  # late: it loads what draws

    write_page(out, running)
