"""Fixtures that every test folder may use."""

from pathlib import Path

import pytest

from numerics.stale_kernels import remove_stale_kernels

ROOT = Path(__file__).resolve().parent.parent


def pytest_configure() -> None:
    """A kernel that was compiled with an older callee would pass for the one that is tested."""
    remove_stale_kernels()


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
