"""A run folder as a session leaves it, of a plain synthetic cube: small, exact, and needing no data."""

import json
from pathlib import Path
from typing import Any

import cv2
import pytest

from geometry.model import load_model
from tests.report.run_folders import CUBE, Bench, RunMaker, result_record, step_record
from tests.session.scenes import small
from tests.session.serving import served


@pytest.fixture(scope="session")
def three_images(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Run folder of a session of three images, which is not to be written to."""
    folder = tmp_path_factory.mktemp("sessions") / "run"
    never = ("--threshold", "0.000001", "--max-iterations", "3", "--no-report")
    done = served("--out", folder, "--scenario", small(), "--seed", "5", *never)
    assert done.returncode == 3, done.stderr
    return folder


@pytest.fixture
def bench(tmp_path: Path) -> Bench:
    """A cube before a camera."""
    path = tmp_path / "cube.cao"
    path.write_text(CUBE)
    return Bench(load_model(path), path)


@pytest.fixture
def make_run(tmp_path: Path, bench: Bench) -> RunMaker:
    """Build a run folder: `make_run(steps=3, status="converged", **fields of result.json)`."""

    def build(steps: int = 3, name: str = "run", **changes: Any) -> Path:
        folder = tmp_path / name
        images = folder / "images"
        images.mkdir(parents=True)
        (images / "cube.cao").write_text(CUBE)
        camera = "\n".join(f"{key} = {value}" for key, value in bench.camera.to_dict().items())
        lights = "".join(f'[[lights]]\nname = "{one}"\nlevels = 8\n' for one in ("left", "right", "top"))
        target = '[target]\nmodel = "cube.cao"\nunit = "m"\n'
        (images / "stack.toml").write_text(f'kind = "frames"\n[camera]\n{camera}\n{lights}{target}')
        records = []
        for number in range(1, steps + 1):
            assert cv2.imwrite(str(images / f"i{number}.png"), bench.image())
            records.append(step_record(number, bench.pose))
        result = result_record(records, bench.pose) | changes
        (folder / "result.json").write_text(json.dumps(result))
        return folder

    return build
