"""A warm worker: servers that stay from cell to cell, so that a cell costs what its images cost."""

import atexit
import shutil
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from itertools import count
from pathlib import Path

import msgspec

from bridge.messages import StartArgs
from bridge.serve import Reply, Server
from experiments.plan import Cell, Scene
from experiments.scratch import new_scratch
from image_server.replay import Replay
from image_server.serve.device import Device
from image_server.serve.server import ImageServer
from image_server.simulator import Simulator
from image_server.simulator.scenario import load_scenario
from image_server.simulator.scenario import with_conditions as scenario_under
from numerics.kernels import prepare_kernels
from numerics.memory import keep_freed_memory
from stack.reading import BasisStack, FramesStack, load_stack
from stack.reading import with_conditions as stack_under
from vision_server.serve.server import VisionServer

KEPT_STACKS = 2  # loaded; the cells of a stack follow each other


class Worker:
    """What cells need and should not pay for: one vision server, loaded stacks, a folder for scratch.

    The servers are threads: a session's requests come one at a time, so that they never compete.

    Parameters
    ----------
    keep : folder in which each cell leaves its run folder; None leaves none.
    """

    def __init__(self, keep: Path | None = None) -> None:
        keep_freed_memory()
        prepare_kernels()
        self._keep = keep
        self._scratch = new_scratch()
        atexit.register(shutil.rmtree, self._scratch, ignore_errors=True)
        self._numbers = count()
        self._vision: _Served | None = None

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
            service = VisionServer() if self._keep else _Unrecorded()
            self._vision = _Served(Server(service, self._endpoint("vision")))
        return self._vision.server.endpoint

    def abandon_vision_server(self) -> None:
        """Have the next cell find a fresh one: this one may be busy for ever."""
        self._vision = None

    @contextmanager
    def hosting(self, cell: Cell) -> Iterator[str]:
        """Serve what a cell photographs; the endpoint."""
        name = self._endpoint("images")
        served = _Served(Server(ImageServer(device_of(cell)), name, f"{name}-events"))
        try:
            yield served.server.endpoint
        finally:
            served.stop()

    def close(self) -> None:
        """Stop the servers and leave nothing behind."""
        if self._vision is not None:
            self._vision.stop()
            self._vision = None
        shutil.rmtree(self._scratch, ignore_errors=True)

    def _endpoint(self, name: str) -> str:
        return f"ipc://{self._scratch}/{name}-{next(self._numbers)}"


class _Served:
    """A server in a thread of its own."""

    def __init__(self, server: Server) -> None:
        self.server = server
        self._thread = threading.Thread(target=server.run, daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End it after the request in hand."""
        self.server.stop()
        self._thread.join()


class _Unrecorded(VisionServer):
    """The vision server of sessions that keep nothing: frames need not be written."""

    def __init__(self) -> None:
        super().__init__()
        self.operations = {**self.operations, "start": (StartArgs, self._on_start_unrecorded)}

    def _on_start_unrecorded(self, args: StartArgs) -> Reply:
        return self._on_start(msgspec.structs.replace(args, out=None))


def device_of(cell: Cell) -> Device:
    """The camera and lights of a cell.

    Raises
    ------
    BadInput : a stack, target or scenario that cannot be used.
    """
    if cell.scene.stack is not None:
        return Replay(_stack(cell.scene), cell.seed)
    return simulator_of(cell)


def simulator_of(cell: Cell) -> Simulator:
    """The simulator of a cell; its pose number draws the scene and the noise."""
    assert cell.pose is not None
    target, scenario = cell.scene.source
    described = load_scenario(scenario)
    if cell.scene.condition is not None:
        described = scenario_under(described, *cell.scene.condition.values())
    return Simulator(target, described, cell.pose)


@lru_cache(KEPT_STACKS)
def _stack(scene: Scene) -> BasisStack | FramesStack:
    loaded = load_stack(Path(scene.source[0]))
    if scene.condition is not None and isinstance(loaded, BasisStack):
        return stack_under(loaded, *scene.condition.values())
    return loaded

