"""A photograph of a camera that was held on its side."""

from pathlib import Path

import cv2

from numerics.arrays import Grey

ON_ITS_SIDE = b"Exif\0\0II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0"


def write_turned_jpeg(file: Path, pixels: Grey) -> None:
    """Write pixels as they lie on the sensor; EXIF says to turn them right by a quarter."""
    jpeg = cv2.imencode(".jpg", pixels)[1].tobytes()
    length = (len(ON_ITS_SIDE) + 2).to_bytes(2, "big")
    file.write_bytes(jpeg[:2] + b"\xff\xe1" + length + ON_ITS_SIDE + jpeg[2:])
