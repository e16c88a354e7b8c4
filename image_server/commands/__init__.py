"""Commands of `python -m image_server`, one file each."""
