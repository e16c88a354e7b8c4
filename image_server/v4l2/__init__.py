"""A V4L2 camera: controls, formats, streaming, and the mapping from settings to what the camera offers."""
