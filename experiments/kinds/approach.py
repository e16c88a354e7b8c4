"""Approaches: sessions that come closer by hold points, each on a trustworthy pose."""

from experiments.kinds import Row, session
from experiments.plan import Cell
from experiments.worker import Worker


def run(cell: Cell, worker: Worker) -> Row:
    """Run one approach; how many hold points it came to, and at how many of them the pose was fixed."""
    row = session.run(cell, worker, "--approach")
    holds = row.pop("holds", None)
    if holds is not None:
        row |= {"holds": len(holds), "fixed": sum(hold["status"] != "aborted" for hold in holds)}
    return row
