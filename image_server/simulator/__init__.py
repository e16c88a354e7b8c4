"""The simulator: a ray-traced target under lights and a sun, as a device."""

from typing import Any


def __getattr__(name: str) -> Any:
    """The device, when it is asked for: plans and scenarios are read without its kernels."""
    if name == "Simulator":
        from image_server.simulator.simulator import Simulator

        return Simulator
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
