"""Command line of the vision server: `python -m vision_server COMMAND`."""

import sys

from bridge.lifeline import leave, leave_at_signals
from numerics.blas import use_one_blas_thread
from numerics.memory import collect_rarely, keep_freed_memory

COMMANDS = {
    "serve": "Serve pose estimation to a controller.",
    "estimate": "Estimate the pose of a target from image files of one set.",
    "track": "Follow a moving target through frames, a video or a camera.",
    "verify": "Make the estimate of a run folder again, and say whether it is as stated.",
    "check": "Say whether a pose from elsewhere is right.",
    "seed": "Make a seed pose from corners of the model and their places in an image.",
    "edges": "Merge image files of one set into one edge map.",
    "calibrate": "Make a camera file from images of a chessboard.",
    "warm": "Compile every numeric kernel, once.",
}


def main() -> None:
    """`python -m vision_server`, and `vision-server` where it is installed."""
    leave_at_signals()
    from bridge.command_line import run_command  # late: a signal that comes meanwhile ends it, too

    use_one_blas_thread()
    keep_freed_memory()
    collect_rarely()
    leave(run_command("vision_server", "Images in, edges and poses out.", COMMANDS, sys.argv[1:]))


if __name__ == "__main__":
    main()
