"""Fixtures that every test folder may use."""

import os
import shutil
import tempfile
from pathlib import Path

import pytest

from numerics.stale_kernels import remove_stale_kernels

ROOT = Path(__file__).resolve().parent.parent


def pytest_configure(config: pytest.Config) -> None:
    """A kernel that was compiled with an older callee would pass for the one that is tested.

    What tests, and the programs that they start, make in the folder for temporary files is in one that goes.
    """
    remove_stale_kernels()
    if not hasattr(config, "workerinput"):  # the workers of a parallel run have their parent's
        os.environ.setdefault("PYTEST_DEBUG_TEMPROOT", tempfile.gettempdir())  # what tmp_path gives stays
        os.environ["TMPDIR"] = tempfile.mkdtemp(prefix="t")  # short: paths of sockets are in it
        tempfile.tempdir = None


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Say what was left there: a test ends what it starts."""
    left = sorted(entry.name for entry in Path(os.environ["TMPDIR"]).iterdir())
    if left:
        terminalreporter.write_line(f"left in the folder for temporary files: {', '.join(left)}")


def pytest_unconfigure(config: pytest.Config) -> None:
    """Remove it."""
    if not hasattr(config, "workerinput"):
        shutil.rmtree(os.environ["TMPDIR"], ignore_errors=True)


@pytest.fixture(scope="session")
def root() -> Path:
    """The project's own folder."""
    return ROOT


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Real images and recorded light stacks kept beside the project, or a skip that says so."""
    folder = ROOT.parent / "shared" / "data"
    if not folder.is_dir():
        pytest.skip(f"no recorded data beside the project ({folder.parent.name}/{folder.name} is absent)")
    return folder
