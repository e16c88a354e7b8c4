"""The simulator: a ray-traced target under lights and a sun, as a device."""
