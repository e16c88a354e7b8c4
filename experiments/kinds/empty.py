"""Cells that do nothing: what is left is what the engine itself costs."""

from experiments.kinds import Row
from experiments.plan import Cell
from experiments.worker import Worker


def run(cell: Cell, worker: Worker) -> Row:
    """A row that is the same for the same cell."""
    return {"status": "empty", "images": cell.seed % 10, "kept": 0}
