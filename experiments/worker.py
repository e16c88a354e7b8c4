"""A warm worker: servers that stay from cell to cell, so that a cell costs what its images cost."""

from __future__ import annotations

import atexit
import gc
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

from experiments.plan import Cell
from experiments.scratch import new_scratch
from numerics.memory import collect_rarely, keep_freed_memory
from numerics.two_cores import use_one_core

if TYPE_CHECKING:
    from experiments.warm_servers import Served
    from image_server.serve.device import Device


class Worker:
    """What cells need and should not pay for: one vision server, loaded stacks, a folder for scratch.

    It computes on one core: the others have workers of their own.

    Parameters
    ----------
    keep : folder in which each cell leaves its run folder; None leaves none.
    """

    def __init__(self, keep: Path | None = None) -> None:
        keep_freed_memory()
        collect_rarely()
        use_one_core()
        self._keep = keep
        self._scratch = new_scratch()
        atexit.register(shutil.rmtree, self._scratch, ignore_errors=True)
        self._numbers, self._scenes = count(), count()
        self._vision: Served | None = None

    @property
    def keeps_folders(self) -> bool:
        """Whether cells leave their run folders."""
        return self._keep is not None

    def run_folder(self, cell: Cell) -> Path:
        """An unused folder for what a cell writes."""
        if self._keep is None:
            return self._scratch / f"run-{next(self._numbers)}"
        folder = self._keep / f"{cell.key:016x}"
        shutil.rmtree(folder, ignore_errors=True)
        return folder

    def vision_server(self) -> str:
        """Endpoint of the vision server."""
        if self._vision is None:
            from experiments.warm_servers import served_vision  # loads all that computes

            self._vision = served_vision(self._endpoint("vision"), self.keeps_folders)
        return self._vision.endpoint

    def abandon_vision_server(self) -> None:
        """Have the next cell find a fresh one: this one may be busy for ever."""
        self._vision = None

    @contextmanager
    def hosting(self, cell: Cell) -> Iterator[str]:
        """Serve what a cell photographs; the endpoint."""
        from experiments.warm_servers import served_images

        self._forget_scenes()
        served = served_images(self._endpoint("images"), cell)
        try:
            yield served.endpoint
        finally:
            served.stop()

    def device(self, cell: Cell) -> Device:
        """The camera and lights of a cell, for kinds that need no servers."""
        from experiments.warm_servers import device_of

        self._forget_scenes()
        return device_of(cell)

    def _forget_scenes(self) -> None:
        """Free the scenes of cells before: a server and its device hold each other.

        What is loaded after the first cell is what stays, and need not be looked through again.
        """
        gc.collect()
        if next(self._scenes) == 1:
            gc.freeze()

    def close(self) -> None:
        """Stop the servers and leave nothing behind."""
        if self._vision is not None:
            self._vision.stop()
            self._vision = None
        shutil.rmtree(self._scratch, ignore_errors=True)

    def _endpoint(self, name: str) -> str:
        return f"ipc://{self._scratch}/{name}-{next(self._numbers)}"
