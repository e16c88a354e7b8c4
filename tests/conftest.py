"""Fixtures that every test folder may use."""

import os
import shutil
import tempfile
from pathlib import Path

import pytest

from numerics.blas import use_one_blas_thread
from numerics.memory import collect_rarely
from numerics.stale_kernels import remove_stale_kernels
from tests.session.command import end_sessions
from tests.session.serving import end_kept_servers

ROOT = Path(__file__).resolve().parent.parent

use_one_blas_thread()  # as the servers do; here, before the folders' own conftests load NumPy


def pytest_configure(config: pytest.Config) -> None:
    """A kernel that was compiled with an older callee would pass for the one that is tested.

    What tests, and the programs that they start, make in the folder for temporary files is in one that goes;
    so are the sockets of servers that stay between sessions.
    """
    collect_rarely()  # what thousands of tests load stays
    if not hasattr(config, "workerinput"):  # the workers of a parallel run have their parent's
        remove_stale_kernels()
        os.environ.setdefault("PYTEST_DEBUG_TEMPROOT", tempfile.gettempdir())  # what tmp_path gives stays
        os.environ["TMPDIR"] = tempfile.mkdtemp(prefix="t")  # short: paths of sockets are in it
        tempfile.tempdir = None
        os.environ["XDG_RUNTIME_DIR"] = tempfile.mkdtemp(prefix="r")


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown() -> None:
    """A session that cannot converge would take a core until the last test."""
    end_sessions()


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    """End the servers that sessions of the tests have left to each other."""
    if not hasattr(session.config, "workerinput"):
        runtime = Path(os.environ["XDG_RUNTIME_DIR"])
        end_kept_servers(runtime / "lights-and-camera")
        shutil.rmtree(runtime)


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
