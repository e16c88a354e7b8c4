"""Command line of experiments: `python -m experiments run`, `compare` and `page`."""

import signal
import sys
from pathlib import Path
from types import FrameType
from typing import Annotated

import typer

from bridge.errors import BadInput, LightsAndCameraError
from experiments.engine import Pool, cores, run_plan
from experiments.plan import read_plan
from experiments.progress import Progressing

app = typer.Typer(
    help="Plans of many sessions: run them anywhere, continue them, compare strategies.",
    no_args_is_help=True, rich_markup_mode=None, pretty_exceptions_enable=False, add_completion=False,
)  # fmt: skip

Out = Annotated[Path, typer.Option(help="Folder of the table; where there is one, its plan is continued.")]


@app.command()
def run(
    plan: Annotated[Path, typer.Argument(metavar="PLAN.toml")],
    out: Out,
    stacks: Annotated[
        list[Path] | None, typer.Argument(help="Stack folders that join the plan's.", metavar="STACK")
    ] = None,
    workers: Annotated[int | None, typer.Option(help="Processes here (default: cores).")] = None,
    cluster: Annotated[
        str | None, typer.Option(help="A dask scheduler, tcp://HOST:PORT, or local:N.", metavar="ADDRESS")
    ] = None,
    seeds: Annotated[str | None, typer.Option(help="Instead of the plan's, such as 1-5.")] = None,
    keep: Annotated[bool, typer.Option("--keep", help="Keep run folders and reports.")] = False,
    again: Annotated[bool, typer.Option("--again", help="Compute cells that failed once more.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="Show nothing.")] = False,
) -> None:
    """Compute the cells of a plan that have no row yet. The same command again continues."""
    signal.signal(signal.SIGTERM, _stop)
    read = read_plan(plan, stacks or [], seeds)
    if workers is not None and cluster is not None:
        raise BadInput("--workers and --cluster exclude each other.", "A cluster knows its workers.")
    folder = (out / "cells").resolve() if keep else None

    def pool(version: str) -> Pool:
        if cluster is not None:
            from experiments.dask_pool import DaskPool

            return DaskPool(cluster, version, folder)
        from experiments.local_pool import LocalPool

        return LocalPool(count, version, folder)

    def page() -> None:
        from experiments.page import write_page

        write_page(out, running=not ended)

    count, ended = cores(workers), False
    with Progressing(quiet, page) as progress:
        try:
            run_plan(read, out, pool, progress.begun, again)
        except KeyboardInterrupt as stopped:
            progress.end(f"Stopped after {progress.computed} cells; the same command continues.")
            raise typer.Exit(128 + (stopped.args[0] if stopped.args else signal.SIGINT)) from None
        ended = True
        page()
        progress.end(f"{progress.computed} cells computed, {progress.rate()}; table: {out}/results.parquet")


@app.command()
def compare(
    table: Annotated[Path, typer.Argument(help="Folder of a run, finished or not.", metavar="OUT")],
    out: Annotated[Path, typer.Option(help="Folder for tables and plots.")],
    reports: Annotated[
        int, typer.Option(min=0, help="Run so many deciding cells again, for their reports.")
    ] = 0,
) -> None:
    """Which strategy is better, where, and how sure that is: tables and plots."""
    from experiments.compared import compare_table

    compare_table(table, out, reports)


@app.command()
def page(table: Annotated[Path, typer.Argument(help="Folder of a run.", metavar="OUT")]) -> None:
    """Write the page of the results so far, OUT/results.html."""
    from experiments.page import write_page

    print(write_page(table, running=False))


def _stop(signum: int, frame: FrameType | None) -> None:
    signal.signal(signum, signal.SIG_DFL)
    raise KeyboardInterrupt(signum)


def main() -> None:
    """Run a command; it ends with the exit status."""
    try:
        app()
    except LightsAndCameraError as error:
        print(f"experiments: {' '.join(str(error).split())}", file=sys.stderr)
        raise SystemExit(error.exit_status) from None


if __name__ == "__main__":
    main()
