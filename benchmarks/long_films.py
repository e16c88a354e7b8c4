"""Is a frame ever sure and wrong? Simulated films without end, as `benchmarks.tracking` makes them.

    .venv/bin/python -m benchmarks.long_films ROWS.jsonl [--frames 100000] [--kind NAME ...] [--first 0]
        [--gear dish ...]

Each film adds a line to ROWS.jsonl: its kind and number, how many frames were sure, unsure and lost, and each
frame that was sure and more than 1 degree or 1 % off. Films that are in it are not made again, so that it can
be stopped and continued. At the end one JSON object: the frames of all films, those that were sure and wrong,
that is, more than 3 degrees or 2 % off, an upper limit of their share (97.5 %, exact), and those beyond 1.
"""

from __future__ import annotations

import itertools
import json
from pathlib import Path
from typing import Annotated

import typer

from benchmarks.docking_gear import GEAR
from benchmarks.films import KINDS, film
from benchmarks.tracking import GONE, LOOSE, followed, is_right, losses, truth
from experiments.kinds.estimate import normalised_error_squared
from experiments.statistics import exact_interval
from vision_server.pose.covariance import uncertainty

LENGTH = 120  # frames of a film
SLOW = ("printed", "calm", "stretched")  # to draw, or not of exact models
LIGHT = tuple(kind for kind in KINDS if kind not in SLOW)


def row_of(kind: str, number: int, gear: str = "") -> dict[str, object]:
    """One film, followed; of docking gear where it is named."""
    model, shown = film(number, kind, LENGTH, gear)
    frames = followed(model, shown)
    wrong = []
    for seen, told in frames:
        if told.state != "sure" or told.pose is None or told.covariance is None:
            continue
        if seen.visible >= GONE and is_right(seen, told):
            continue
        true = truth(seen, told.pose)
        error = told.pose.error_to(true)
        near = seen.visible >= GONE and error.within(*LOOSE)
        wrong.append(
            {
                "frame": told.frame, "off": not near, "visible": round(seen.visible, 3),
                "degrees": error.rotation_deg,
                "metres": error.translation_m, "stated": uncertainty(told.covariance, told.pose.translation),
                "squared": normalised_error_squared(told.pose, told.covariance, true),
            }
        )  # fmt: skip
    counts = {state: sum(told.state == state for _, told in frames) for state in ("sure", "unsure", "lost")}
    said, again = losses(frames)
    return {
        "kind": kind, "number": number, "gear": gear, "frames": len(frames), **counts, "wrong": wrong,
        "not_sure_after": said, "found_after": again, "seconds": sum(told.seconds for _, told in frames),
    }  # fmt: skip


def main(
    rows: Path,
    frames: int = 100_000,
    kind: Annotated[
        list[str] | None, typer.Option(help=f"Of {', '.join(KINDS)}; given twice, twice as many.")
    ] = None,
    first: Annotated[int, typer.Option(help="Number of the first film of each kind.")] = 0,
    gear: Annotated[
        list[str] | None, typer.Option(help=f"Instead of the project's targets: {', '.join(GEAR)}.")
    ] = None,
) -> None:
    """Go on from where the file ends."""
    shown = tuple(itertools.product(kind or LIGHT, gear or [""]))
    numbers = {one: itertools.count(first) for one in shown}
    with rows.open("a+") as file:
        file.seek(0)
        found = [json.loads(line) for line in file]
        done = {(row["kind"], row.get("gear", ""), row["number"]) for row in found}
        for one in itertools.cycle(shown):
            if sum(row["frames"] for row in found) >= frames:
                break
            if (*one, number := next(numbers[one])) not in done:
                found.append(row_of(one[0], number, one[1]))
                print(json.dumps(found[-1]), file=file, flush=True)
    sure, beyond = sum(row["sure"] for row in found), sum(len(row["wrong"]) for row in found)
    wrong = sum(frame["off"] for row in found for frame in row["wrong"])
    print(
        json.dumps(
            {
                "name": "long films", "value": wrong, "unit": "frames sure and wrong",
                "frames": sum(row["frames"] for row in found), "sure": sure, "sure_and_beyond_1": beyond,
                **{state: sum(row[state] for row in found) for state in ("unsure", "lost")},
                "most_of_sure": exact_interval(wrong, sure)[1] if sure else 1.0,
            }
        )
    )  # fmt: skip


if __name__ == "__main__":
    typer.run(main)
