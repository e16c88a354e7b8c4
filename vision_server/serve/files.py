"""Which files a session of the vision server may name: those under its roots, and no devices."""

from __future__ import annotations

import os
import stat
from dataclasses import dataclass
from pathlib import Path

from bridge.errors import BadInput
from bridge.messages import Describe
from bridge.start_messages import StartArgs
from stack.format import STACK_FILE
from stack.read import recorded_frames
from stack.tables import read_toml

MOST_BYTES = 64 * 1024 * 1024  # of a model, camera or seed pose file


@dataclass(frozen=True)
class Files:
    """What may be read, and where frames may be written.

    Parameters
    ----------
    roots
        Folders in which all of it lies; ``None`` for any place.
    image_server
        Endpoint of an image server whose model file is taken wherever it is.
    """

    roots: tuple[Path, ...] | None = None
    image_server: str | None = None

    def check(self, args: StartArgs, describe: Describe) -> None:
        """Look at every file that `start` reads.

        Raises
        ------
        BadInput
            Outside of the roots, no regular file, too large, or not there.
        """
        for file in (args.model, args.camera_file, args.seed_pose_file):
            if file is not None:
                self.check_place(file)
                _check_regular(Path(file))
        if args.model is None and describe.target is not None:
            if args.image_server is None or args.image_server != self.image_server:
                self.check_place(describe.target.model)
            _check_regular(Path(describe.target.model))
        if args.out is not None:
            self.check_place(args.out)

    def check_new(self, folder: Path) -> None:
        """See to it that a new session writes over nothing: its folder of frames has none yet."""
        self.check_place(str(folder))
        file = folder / STACK_FILE
        if os.path.exists(file) and (
            read_toml(file, "stack file").get("kind") != "frames" or recorded_frames(folder)
        ):
            raise BadInput(f"{folder} has frames already.", "Give another folder, or restore the session.")

    def check_place(self, file: str) -> None:
        """Look at where a file or a folder of frames lies; raises as `check`."""
        try:
            place = Path(file).resolve()
            place.is_dir()
        except (OSError, RuntimeError) as error:  # a name that is too long, links in a circle
            raise BadInput(f"{file[:200]} cannot be a file: {error}."[:400], "Give another name.") from error
        if self.roots is not None and not any(place.is_relative_to(root.resolve()) for root in self.roots):
            raise BadInput(
                f"{file} is outside of the folders that this vision server may use.",
                f"They are {', '.join(map(str, self.roots))}; more are given at its start, with --root DIR.",
            )


ANY_FILES = Files()


def _check_regular(path: Path) -> None:
    try:
        found = path.stat()
    except OSError as error:
        why = error.strerror or error
        raise BadInput(f"Cannot read {path.absolute()}: {why}.", "Check the path.") from error
    if not stat.S_ISREG(found.st_mode):
        raise BadInput(f"{path} is not a regular file.", "Give a file.")
    if found.st_size > MOST_BYTES:
        raise BadInput(f"{path} has {found.st_size} bytes; at most {MOST_BYTES} are read.")
