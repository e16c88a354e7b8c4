"""Recording: what is replayed from a recorded stack is what the device would have shown."""

import errno
import os
import signal
from pathlib import Path

import msgspec
import numpy as np
import pytest
import trimesh

from bridge.errors import BadInput, DeviceError
from bridge.messages import Describe, Settings
from geometry.model import TARGETS, load_model
from image_server.commands.record import parsed_settings
from image_server.recording.record import record_basis, record_frames
from image_server.replay import Replay
from image_server.serve.device import Device, Frame
from image_server.simulator.scenario import load_scenario
from image_server.simulator.scenario_tables import Scenario
from image_server.simulator.simulator import Simulator
from stack.read import BasisStack, load_stack, recorded_frames
from stack.write import described
from tests.commands import command, process

pytestmark = pytest.mark.slow

APERTURE = 4.0
SETTINGS = [
    Settings(lights=(7, 0, 0), shutter_s=1 / 60, aperture=APERTURE),
    Settings(lights=(0, 3, 5), shutter_s=1 / 120, aperture=5.6),
    Settings(lights=(0, 0, 0), shutter_s=1 / 15, aperture=2.8),
]


def ignore(_text: str) -> None:
    """Nobody watches."""


def nominal() -> Scenario:
    """The scenario of that name, with a small camera."""
    told = load_scenario("nominal")
    small = msgspec.structs.replace(
        told.camera, width=320, height=240, fx=400.0, fy=400.0, cx=159.5, cy=119.5
    )
    return msgspec.structs.replace(told, camera=small)


@pytest.fixture(scope="module")
def simulator() -> Simulator:
    return Simulator("cube", nominal(), seed=5)


def test_frames_come_back_bit_for_bit(simulator: Simulator, tmp_path: Path) -> None:
    taken: list[Frame] = []

    class Watched(Device):
        name = "watched"

        def describe(self) -> Describe:
            return simulator.describe()

        def capture(self, settings: Settings) -> Frame:
            taken.append(simulator.capture(settings))
            return taken[-1]

        def health(self) -> dict[str, object]:
            return simulator.health()

    done = record_frames(Watched(), tmp_path / "stack", SETTINGS, repeat=2, progress=ignore)
    assert (done.frames, done.unverified) == (6, 0)
    replay = Replay(load_stack(tmp_path / "stack"))
    for frame in taken:
        replayed = replay.capture(frame.applied)
        assert np.array_equal(replayed.pixels, frame.pixels)
        assert replayed.applied == frame.applied
    assert not np.array_equal(taken[0].pixels, taken[1].pixels)  # each is a frame of its own


def test_a_recording_of_a_recording_is_the_same(simulator: Simulator, tmp_path: Path) -> None:
    record_frames(simulator, tmp_path / "first", SETTINGS, repeat=1, progress=ignore)
    first = Replay(load_stack(tmp_path / "first"))
    record_frames(first, tmp_path / "second", SETTINGS, repeat=1, progress=ignore)
    for name in ("frame0001.png", "frame0003.png", "cube.cao"):
        assert (tmp_path / "first" / name).read_bytes() == (tmp_path / "second" / name).read_bytes()


@pytest.mark.parametrize(("noisy", "average", "share"), [(False, 1, 0.9999), (True, 8, 0.97)])
def test_a_basis_replays_within_one_grey_level(
    simulator: Simulator, tmp_path: Path, noisy: bool, average: int, share: float
) -> None:
    """What differs is rounding, and what the averaging has left of the photons' noise."""
    noiseless = msgspec.structs.replace(nominal().camera, read_noise_e=0.0, full_well_e=1e12)
    truth = Simulator("cube", msgspec.structs.replace(nominal(), camera=noiseless), seed=5)
    at = Settings(lights=(0, 0, 0), shutter_s=1 / 60, aperture=APERTURE)
    source = simulator if noisy else truth
    record_basis(source, tmp_path / "stack", at, average=average, black=0.0, progress=ignore)
    stack = load_stack(tmp_path / "stack")
    assert isinstance(stack, BasisStack)
    assert stack.table.camera.apertures == (APERTURE,)
    camera = msgspec.structs.replace(stack.table.camera, read_noise_e=0.0, full_well_e=1e12)
    table = msgspec.structs.replace(stack.table, camera=camera)
    replay = Replay(BasisStack(stack.folder, table, stack.radiances, stack.ambient))
    for lights in ((7, 0, 0), (0, 7, 0), (0, 0, 0), (2, 5, 3), (7, 7, 7)):
        for shutter_s in (1 / 240, 1 / 60, 1 / 15):
            asked = Settings(lights=lights, shutter_s=shutter_s, aperture=APERTURE)
            difference = np.abs(truth.capture(asked).pixels.astype(int) - replay.capture(asked).pixels)
            assert (difference <= 1).mean() >= share
            assert difference.mean() < 0.2


def test_a_camera_that_is_not_linear_makes_no_basis(simulator: Simulator, tmp_path: Path) -> None:
    class Curved(Device):
        """A simulator behind a tone curve that its description does not tell of."""

        name = "curved"

        def describe(self) -> Describe:
            return simulator.describe()

        def capture(self, settings: Settings) -> Frame:
            frame = simulator.capture(settings)
            pixels = np.rint(255 * (frame.pixels / 255) ** (1 / 2.2)).astype(np.uint8)
            return Frame(pixels, settings, frame.applied, True, frame.sequence, 0.0)

        def health(self) -> dict[str, object]:
            return {}

    at = Settings(lights=(0, 0, 0), shutter_s=1 / 60, aperture=APERTURE)
    with pytest.raises(BadInput, match=r"not linear: light 'left' is 1\.\d+ times brighter"):
        record_basis(Curved(), tmp_path / "stack", at, average=1, black=0.0, progress=ignore)
    assert not (tmp_path / "stack" / "stack.toml").exists()


def test_a_scene_that_moves_makes_no_basis_and_is_told_with_frames(tmp_path: Path) -> None:
    scenario = msgspec.structs.replace(nominal(), time=load_scenario("drifting").time)
    moving = Simulator("cube", scenario, seed=5)
    with pytest.raises(BadInput, match=r"does not stand still while it is recorded \(target_moved\)"):
        record_basis(moving, tmp_path / "basis", SETTINGS[0], 4, 0.0, ignore)
    said: list[str] = []
    record_frames(moving, tmp_path / "frames", [SETTINGS[0]] * 9, 1, said.append)
    assert "event: target_moved" in said


def test_a_light_that_is_not_linear_makes_no_basis(simulator: Simulator, tmp_path: Path) -> None:
    class Dimmed(Device):
        """Lights whose levels follow a square law."""

        name = "dimmed"

        def describe(self) -> Describe:
            return simulator.describe()

        def capture(self, settings: Settings) -> Frame:
            levels = tuple(round(level**2 / 7) for level in settings.lights)
            frame = simulator.capture(msgspec.structs.replace(settings, lights=levels))
            return Frame(frame.pixels, settings, settings, True, frame.sequence, 0.0)

        def health(self) -> dict[str, object]:
            return {}

    at = Settings(lights=(0, 0, 0), shutter_s=1 / 60, aperture=APERTURE)
    with pytest.raises(BadInput, match=r"Light 'left' is not linear: level 4 of 7"):
        record_basis(Dimmed(), tmp_path / "stack", at, average=1, black=0.0, progress=ignore)


# --- the command ---


def test_the_command_records_from_the_simulator(tmp_path: Path) -> None:
    out = tmp_path / "stack"
    words = (out, "--kind", "frames", "--scenario", "nominal", "--settings", "7,0,0:1/60:4")
    done = process("image_server", "record", *words, "--seed", "5")
    assert done.returncode == 0, done.stderr
    assert "1 frame recorded, 0 of them unverified" in done.stdout
    assert load_stack(out).table.kind == "frames"
    again = command("image_server", "record", *words)
    assert again.returncode == 2
    assert "holds a stack already" in again.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--kind", "frames", "--settings", "each"], "Give one of --camera, --stack and --scenario"),
        (["--kind", "frames", "--scenario", "nominal"], "nothing to record"),
        (["--kind", "frames", "--scenario", "nominal", "--settings", "bright"], "'bright' is not LEVELS"),
        (
            ["--kind", "frames", "--scenario", "nominal", "--settings", "7,0,0:0:4"],
            "'7,0,0:0:4' is not LEVELS",
        ),
        (["--kind", "frames", "--scenario", "nominal", "--settings", "9,0,0:1/60:4"], "no level 9"),
        (["--kind", "frames", "--scenario", "nominal", "--settings", "7,0,0:0.5:4"], "Allowed: 0.00416667"),
        (["--kind", "frames", "--camera", "/dev/video77", "--settings", "each"], "no camera /dev/video77"),
    ],
)
def test_bad_input_is_refused(tmp_path: Path, arguments: list[str], message: str) -> None:
    done = command("image_server", "record", tmp_path / "stack", *arguments)
    assert done.returncode == 2
    assert message in done.stderr
    assert not (tmp_path / "stack").exists()


@pytest.mark.parametrize(
    ("unknown", "said"), [("camera", "needs the camera's calibration"), ("target", "needs its target")]
)
def test_what_no_stack_can_be_of_is_refused_before_anything_is_taken(
    simulator: Simulator, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, unknown: str, said: str
) -> None:
    """It was told when all frames had been taken, which were lost then."""
    describe = msgspec.structs.replace(simulator.describe(), **{unknown: None})
    monkeypatch.setattr(simulator, "describe", lambda: describe)
    told: list[str] = []
    with pytest.raises(BadInput, match=said):
        record_frames(simulator, tmp_path / "f", SETTINGS, 1, told.append)
    with pytest.raises(BadInput, match=said):
        record_basis(simulator, tmp_path / "b", SETTINGS[0], 1, 0.0, told.append)
    assert told == []
    assert list(tmp_path.iterdir()) == []


def test_a_model_that_cannot_be_copied_is_told(simulator: Simulator, tmp_path: Path) -> None:
    (tmp_path / "cube.cao").mkdir()
    with pytest.raises(BadInput, match=r"Cannot copy .*cube.cao to .*: Is a directory"):
        described(tmp_path, simulator.describe())


def test_a_camera_that_fails_leaves_no_empty_folder(
    simulator: Simulator, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(*_: object) -> None:
        raise DeviceError("The camera is gone.")

    monkeypatch.setattr(simulator, "capture", fails)
    settings = parsed_settings("7,0,0:1/60:4", simulator.describe())
    (tmp_path / "given").mkdir()
    for folder in (tmp_path / "new", tmp_path / "given"):
        with pytest.raises(DeviceError):
            record_frames(simulator, folder, settings, 1, lambda _: None)
    assert [one.name for one in tmp_path.iterdir()] == ["given"]


@pytest.mark.parametrize("kind", ["gltf", "cao"])
def test_a_model_of_several_files_goes_with_the_stack(tmp_path: Path, kind: str) -> None:
    (tmp_path / "parts").mkdir()
    model = tmp_path / f"whole.{kind}"
    if kind == "gltf":
        scene = trimesh.Scene(trimesh.creation.box((0.3, 0.2, 0.1)))
        for name, content in scene.export(file_type="gltf").items():  # type: ignore[no-untyped-call]
            file = tmp_path / name.replace("model.gltf", model.name).replace("gltf_buffer", "parts/a b")
            file.write_bytes(content.replace(b"gltf_buffer", b"parts/a%20b"))
    else:
        (tmp_path / "parts" / "cube.cao").write_bytes((TARGETS / "cube.cao").read_bytes())
        model.write_text('V1\nload("parts/cube.cao", t=[0; 0; 0.1])\n0\n')
    simulator = Simulator(model, nominal(), seed=5)
    record_frames(simulator, tmp_path / "stack", SETTINGS[:1], repeat=1, progress=ignore)
    for file in [model, *(tmp_path / "parts").iterdir()]:
        file.unlink()
    target = load_stack(tmp_path / "stack").table.target
    copy = load_model(tmp_path / "stack" / target.model, target.unit)
    assert np.array_equal(copy.vertices, simulator.model.vertices)


def test_frames_that_came_before_an_error_are_a_stack(simulator: Simulator, tmp_path: Path) -> None:
    class Failing(Device):
        name = "failing"
        left = 2

        def describe(self) -> Describe:
            return simulator.describe()

        def capture(self, settings: Settings) -> Frame:
            self.left -= 1
            if self.left < 0:
                raise DeviceError("The camera is gone.")
            return simulator.capture(settings)

        def health(self) -> dict[str, object]:
            return simulator.health()

    told: list[str] = []
    with pytest.raises(DeviceError):
        record_frames(Failing(), tmp_path / "kept", SETTINGS, 1, told.append)
    assert told[-1] == f"{tmp_path / 'kept'} is a stack of the 2 frames before"
    kept = recorded_frames(tmp_path / "kept")
    assert [frame.settings() for frame in kept.values()] == SETTINGS[:2]


def test_where_the_disk_is_full_the_frames_before_are_a_stack(
    simulator: Simulator, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fsync, synced = os.fsync, []

    def full(descriptor: int) -> None:
        synced.append(descriptor)
        if len(synced) == 2:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        fsync(descriptor)

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(BadInput, match=r"Cannot write .*frame0002\.png: No space left"):
        record_frames(simulator, tmp_path / "kept", SETTINGS, 1, ignore)
    assert len(recorded_frames(tmp_path / "kept")) == 1
    assert not (tmp_path / "kept" / "frame0002.png").exists()


def test_ctrl_c_ends_a_recording_and_leaves_no_empty_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    capture, taken = Simulator.capture, []

    def pressed(simulator: Simulator, settings: Settings) -> Frame:
        signal.raise_signal(signal.SIGINT)
        taken.append(settings)
        return capture(simulator, settings)

    monkeypatch.setattr(Simulator, "capture", pressed)
    words = (tmp_path / "new", "--kind", "frames", "--scenario", "nominal", "--settings", "each")
    done = command("image_server", "record", *words)
    assert (done.returncode, len(taken), done.stdout) == (130, 1, "")
    assert not (tmp_path / "new").exists()


def test_settings_are_written_as_photographers_do(simulator: Simulator) -> None:
    (one,) = parsed_settings("7,0,3:1/60:5.6:35:1.5", simulator.describe())
    assert one == Settings(
        lights=(7, 0, 3), shutter_s=1 / 60, aperture=5.6, focal_length_mm=35.0, focus_m=1.5
    )
    assert len(parsed_settings("each", simulator.describe())) == 4 * 5 * 3
