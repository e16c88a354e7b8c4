"""A whole session on real lights' protocol and a camera's control flow, a light dying in the middle."""

import json
from collections.abc import Iterator
from pathlib import Path
from threading import Thread

import pytest

from bridge.messages import CameraDescription, Settings
from bridge.serve import Server
from image_server.hardware import Hardware
from image_server.lights.opening import open_rig
from image_server.serve.device import Frame
from image_server.serve.server import ImageServer
from image_server.v4l2.camera import V4L2Camera
from image_server.v4l2.camera_file import CameraFile
from tests.equipment.line import EmulatedLineDriver
from tests.image_server.v4l2.scripted_camera import HEIGHT, WIDTH, ScriptedCamera
from tests.session.serving import served

pytestmark = pytest.mark.slow

SEED_POSE = "[target.seed_pose]\nrotation_vector = [0.5, 0.7, 0.1]\ntranslation = [0.0, 0.0, 0.6]\n"
CAMERA = CameraDescription(width=WIDTH, height=HEIGHT, fx=80.0, fy=80.0, cx=31.5, cy=23.5)


class Bench(Hardware):
    """Camera and lights, of which the second fails while the second frame is taken."""

    def __init__(self, emulator: EmulatedLineDriver) -> None:
        node = ScriptedCamera()
        camera = V4L2Camera(CameraFile(device=node.path), node)
        super().__init__(camera, open_rig(emulator.path), CAMERA)
        self.emulator = emulator
        self.frames: list[Frame] = []

    def capture(self, settings: Settings) -> Frame:
        """A frame; the light fails before the second."""
        if len(self.frames) == 1:
            self.emulator.fault("dead:2")
        self.frames.append(super().capture(settings))
        return self.frames[-1]


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[tuple[Bench, str]]:
    emulator = EmulatedLineDriver()
    device = Bench(emulator)
    endpoint = f"ipc://{tmp_path}/image"
    server = Server(ImageServer(device), endpoint, f"{endpoint}-events")
    thread = Thread(target=server.run)
    thread.start()
    yield device, endpoint
    server.lifeline.stop(0)
    thread.join()
    emulator.close()


def test_the_session_goes_on_without_a_light_that_died(bench: tuple[Bench, str], tmp_path: Path) -> None:
    device, endpoint = bench
    (tmp_path / "seed.toml").write_text(SEED_POSE)
    done = served(
        "--image-server", endpoint, "--target", "cube", "--seed-pose", tmp_path / "seed.toml",
        "--max-iterations", "5", "--controller", "simple", "--no-report", "--out", tmp_path / "run",
    )  # fmt: skip
    assert done.returncode == 3, done.stderr
    assert "event: light_fault(light2)" in done.stderr
    result = json.loads((tmp_path / "run" / "result.json").read_text())
    assert result["status"] == "exhausted"
    levels = [frame.requested.lights for frame in device.frames]
    assert len(levels) == 5
    assert all(lit[1] == 0 for lit in levels[3:])  # the third may have been chosen before it was told
    assert any(lit[0] for lit in levels[3:]) or any(lit[2] for lit in levels[3:])
    for frame in device.frames[1:]:
        assert frame.applied.lights[1] == 0
        assert frame.verified == (frame.requested.lights[1] == 0)
    assert device.frames[0].verified


def test_what_is_missing_for_a_camera_is_bad_input(bench: tuple[Bench, str], tmp_path: Path) -> None:
    _, endpoint = bench
    done = served("--image-server", endpoint, "--no-report", "--out", tmp_path / "run")
    assert done.returncode == 2, done.stderr
    assert "--target FILE" in done.stderr


def test_without_a_seed_pose_it_is_looked_for_everywhere(bench: tuple[Bench, str], tmp_path: Path) -> None:
    _, endpoint = bench
    done = served("--image-server", endpoint, "--target", "cube", "--dry-run", "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    assert "looked for everywhere (no seed pose)" in done.stdout + done.stderr
