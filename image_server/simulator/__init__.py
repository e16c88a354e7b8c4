"""The simulator: a ray-traced target under lights and a sun, as a device."""

from image_server.simulator.simulator import Simulator

__all__ = ["Simulator"]
