"""Servers as threads of a worker, and the camera and lights of a cell."""

from __future__ import annotations

import threading
from functools import lru_cache
from pathlib import Path

import msgspec

from bridge.serve import Reply, Server
from bridge.start_messages import StartArgs
from experiments.plan import Cell, PlanScene
from image_server.replay import Replay
from image_server.serve.device import Device
from image_server.serve.server import ImageServer
from image_server.simulator.scenario import load_scenario
from image_server.simulator.scenario import with_conditions as scenario_under
from image_server.simulator.simulator import Simulator
from stack.read import BasisStack, FramesStack, load_stack
from stack.read import with_conditions as stack_under
from vision_server.serve.server import VisionServer

KEPT = 2  # stacks, and simulators; the cells of a scene follow each other


class Served:
    """A server in a thread of its own.

    The servers of a worker never compete: the requests of a session come one at a time.
    """

    def __init__(self, server: Server) -> None:
        self.endpoint = server.endpoint
        self._server = server
        self._thread = threading.Thread(target=server.run, daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End it after the request in hand."""
        self._server.stop()
        self._thread.join()


def served_vision(endpoint: str, recorded: bool) -> Served:
    """A vision server; it writes frames to the run folders of sessions if they are to be `recorded`."""
    return Served(Server(VisionServer() if recorded else _Unrecorded(), endpoint))


def served_images(endpoint: str, cell: Cell) -> Served:
    """An image server for what a cell photographs."""
    return Served(Server(ImageServer(device_of(cell)), endpoint, f"{endpoint}-events"))


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
        return Replay(_stack(cell.scene), cell.seed, nearest=True)  # as a session starts it
    return simulator_of(cell)


def simulator_of(cell: Cell) -> Simulator:
    """The simulator of a cell; its pose number draws the scene and the noise.

    It is that of the cell before where this one's scene is the same: what was traced stays.
    """
    assert cell.pose is not None
    simulator = _simulator(cell.scene, cell.pose)
    simulator.listen(lambda change: None)  # the server before is gone
    simulator.restart(cell.pose, 0)
    return simulator


@lru_cache(KEPT)
def _simulator(scene: PlanScene, pose: int) -> Simulator:
    target, scenario = scene.source
    described = load_scenario(scenario)
    if scene.condition is not None:
        described = scenario_under(described, *scene.condition.values())
    return Simulator(target, described, pose, scene.unit)


@lru_cache(KEPT)
def _stack(scene: PlanScene) -> BasisStack | FramesStack:
    loaded = load_stack(Path(scene.source[0]))
    if scene.condition is not None and isinstance(loaded, BasisStack):
        return stack_under(loaded, *scene.condition.values())
    return loaded
