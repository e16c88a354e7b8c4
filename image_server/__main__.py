"""Command line of the image server: `python -m image_server COMMAND`."""

import sys

from bridge.lifeline import leave, leave_at_signals
from numerics.memory import collect_rarely, keep_freed_memory

COMMANDS = {
    "replay": "Serve a recorded light stack.",
    "simulator": "Serve a ray-traced target under lights and a sun; the seed draws its true pose.",
    "hardware": "Serve a V4L2 camera, with lights on a serial line or without.",
    "cameras": "List the cameras of this machine with their formats and controls.",
    "calibrate": "Measure a camera in front of a steadily lit scene, and write its camera file.",
    "record": "Write a stack folder from a camera with lights, a stack or the simulator.",
    "warm": "Compile the simulator's kernels, once.",
}


def main() -> None:
    """`python -m image_server`, and `image-server` where it is installed."""
    leave_at_signals()
    from bridge.command_line import run_command  # late: a signal that comes meanwhile ends it, too

    keep_freed_memory()
    collect_rarely()
    leave(run_command("image_server", "A camera and lights: settings in, frame out.", COMMANDS, sys.argv[1:]))


if __name__ == "__main__":
    main()
