"""Fixtures of the vision server's tests."""

from pathlib import Path

import pytest

from geometry.model import Model
from tests.vision_server.synthetic import cuboid


@pytest.fixture(scope="session")
def model(tmp_path_factory: pytest.TempPathFactory) -> Model:
    """A cuboid of 10 x 8 x 6 cm."""
    folder: Path = tmp_path_factory.mktemp("model")
    return cuboid(folder)
