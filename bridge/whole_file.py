"""A file that is replaced as a whole: who reads it meanwhile finds the old one or the new one."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import get_native_id


@contextmanager
def replaced(file: Path) -> Iterator[Path]:
    """Give a name beside ``file`` to write to; at the end what was written there takes the file's place.

    Where that fails, or what is done in between, the old file stays and the new one goes.

    Raises
    ------
    OSError : the new file cannot be moved, or was not written.
    """
    new = file.with_name(f"{file.name}.{get_native_id()}.new")  # two that write at once do not meet
    try:
        yield new
        new.replace(file)
    except BaseException:
        with suppress(OSError):
            new.unlink(missing_ok=True)
        raise
