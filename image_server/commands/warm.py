"""`warm`: compile the simulator's kernels into numba's cache."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from numerics.stale_kernels import remove_stale_kernels
from numerics.warming import warming

WARMING = ("earth-limb", "camera")
"""Scenarios that between them use every kernel but that of folds: sky, blooming."""


def add_options(_: ArgumentParser) -> None:
    """It has none."""


def run(_: Namespace) -> None:
    """Compile what has changed, so that the first session does not wait for it."""
    remove_stale_kernels()
    with warming("simulator", "numerics", "geometry", "stack", "image_server"):
        take_frames()


def take_frames() -> None:
    """Small frames of a folded cube."""
    from msgspec.structs import replace

    from bridge.messages import Settings
    from image_server.simulator.scenario import load_scenario
    from image_server.simulator.simulator import Simulator

    for name in WARMING:
        scenario = load_scenario(name)
        camera = replace(scenario.camera, width=96, height=72, fx=120.0, fy=120.0, cx=47.5, cy=35.5)
        folded = replace(scenario.target, crinkle=0.1)
        simulator = Simulator("cube", replace(scenario, camera=camera, target=folded))
        simulator.capture(Settings(lights=(4, 4, 4), shutter_s=1 / 60, aperture=4.0))
