"""`python -m vision_server track` and `check`: JSON, exit statuses, films, and what is refused."""

import json
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import cv2
import numpy as np
import pytest

from bridge.command_line import run_command
from geometry.pose import Pose
from image_server.serve.server import ImageServer
from image_server.simulator.simulator import Simulator
from tests.commands import command, process, started
from tests.vision_server.serve.running import Running
from tests.vision_server.synthetic import CAMERA, POSE, camera_file, cuboid
from tests.vision_server.tracking.films import filmed, moving
from vision_server.__main__ import COMMANDS
from vision_server.channels.depth import Pixels
from vision_server.tracking import sources
from vision_server.tracking.sources import Source
from vision_server.tracking.tracked import Tracked
from vision_server.tracking.tracker import Tracker

pytestmark = pytest.mark.slow

COUNT = 5


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("track")
    model = cuboid(path)
    poses = moving(COUNT)
    (path / "frames").mkdir()
    size = (CAMERA.width, CAMERA.height)
    video = cv2.VideoWriter(str(path / "film.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 25.0, size)
    for number, frame in enumerate(filmed(model, list(poses))):
        cv2.imwrite(str(path / "frames" / f"{number:03d}.png"), frame)
        video.write(cv2.cvtColor(frame, cv2.COLOR_GRAY2BGR))
    video.release()
    camera_file(path / "camera.toml")
    cv2.imwrite(str(path / "small.png"), np.zeros((100, 100), np.uint8))
    write_pose(path / "right.toml", poses[0])
    write_pose(path / "wrong.toml", Pose(POSE.rotation_vector + np.array([0.15, 0.0, 0.1]), POSE.translation))
    return path


def write_pose(path: Path, pose: Pose) -> None:
    values = pose.to_dict()
    path.write_text("".join(f"{key} = {value}\n" for key, value in values.items()))


def of(folder: Path, *words: str) -> list[str]:
    """The words of a command about the cuboid."""
    return ["--model", str(folder / "cuboid.cao"), "--camera", str(folder / "camera.toml"), *words]


@pytest.mark.parametrize("source", ["frames", "film.avi"])
def test_one_object_a_frame_and_a_film(folder: Path, tmp_path: Path, source: str) -> None:
    film = tmp_path / "out.mp4"
    words = [str(folder / source), "--json", "--seed-pose", str(folder / "right.toml")]
    runs = process if source == "frames" else command
    done = runs("vision_server", "track", *of(folder, *words, "--overlay", str(film)))
    assert done.returncode == 0, done.stderr
    told = [json.loads(line) for line in done.stdout.splitlines()]
    assert [one["frame"] for one in told] == list(range(COUNT))
    keys = {"frame", "state", "pose", "covariance", "seconds"}
    assert set(told[0]) == (keys if source == "frames" else keys | {"time"})
    if source == "film.avi":
        assert [one["time"] for one in told] == pytest.approx(np.arange(COUNT) / 25.0, abs=1e-3)
    assert {one["state"] for one in told} == {"sure"}
    last = Pose.from_dict(told[-1]["pose"])
    assert last.error_to(moving(COUNT)[-1]).within(0.5, 0.005)
    video = cv2.VideoCapture(str(film))
    assert int(video.get(cv2.CAP_PROP_FRAME_COUNT)) == COUNT
    assert video.get(cv2.CAP_PROP_FPS) == (25.0 if source == "film.avi" else 30.0)


def test_image_files_have_the_times_of_the_rate_that_is_told(folder: Path) -> None:
    words = [str(folder / "frames"), "--fps", "10", "--seed-pose", str(folder / "right.toml"), "--json"]
    done = command("vision_server", "track", *of(folder, *words))
    assert [json.loads(line)["time"] for line in done.stdout.splitlines()] == [0.0, 0.1, 0.2, 0.3, 0.4]


def test_what_track_tells_of_a_frame_is_a_pose_to_check_and_to_start_from(
    folder: Path, tmp_path: Path
) -> None:
    first, line = str(folder / "frames" / "000.png"), tmp_path / "line.json"
    words = [first, "--json", "--seed-pose"]
    told = command("vision_server", "track", *of(folder, *words, str(folder / "right.toml")))
    line.write_text(told.stdout)
    done = command("vision_server", "check", *of(folder, first, "--pose", str(line)))
    assert (done.returncode, done.stderr) == (0, "")
    again = command("vision_server", "track", *of(folder, *words, str(line)))
    pose = Pose.from_dict(json.loads(told.stdout)["pose"])
    assert Pose.from_dict(json.loads(again.stdout)["pose"]).error_to(pose).within(0.1, 0.001)


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ('{"frame": 1, "state": "lost", "pose": null}', "tells no pose"),
        ('{"pose": 1}\n{"pose": 2}', "is not one JSON object"),
        ("[1, 2]", "tells no pose"),
        ('{"pose": {"translation": [0, 0, 1]}}', "no rotation_vector"),
        ('{"pose": {"rotation_vector": [NaN, 0, 0], "translation": [0, 0, 1]}}', "must be finite"),
        ('{"pose": {"rotation_vector": [0, 0, 0], "translation": [0, 0, 1e300]}}', "at most 1e+06"),
        ('{"pose": {"rotation_vector": [1e155, 0, 0], "translation": [0, 0, 1]}}', "at most 1e+06"),
        ('{"pose": {"rotation_vector": [0, 0, 0], "translation": [0, 0, -1]}}', "is behind the camera"),
    ],
)
def test_a_json_file_without_a_pose_is_refused_plainly(
    folder: Path, tmp_path: Path, told: str, said: str
) -> None:
    file = tmp_path / "told.json"
    file.write_text(told)
    done = command(
        "vision_server", "check", *of(folder, str(folder / "frames" / "000.png"), "--pose", str(file))
    )
    assert done.returncode == 2
    assert said in done.stderr and str(file) in done.stderr
    assert ("in no [table]" in done.stderr) == (said == "no rotation_vector")


@pytest.mark.parametrize(
    ("pose", "said"),
    [
        (Pose(np.degrees(POSE.rotation_vector), POSE.translation), "Is it in degrees?"),
        (Pose(POSE.rotation_vector, 1e3 * POSE.translation), "the pose's, metres"),
        (Pose(POSE.rotation_vector, np.array([50.0, 0.0, 1.0])), "no line of the model is in the frame"),
    ],
)
def test_of_degrees_millimetres_and_a_pose_aside_it_is_said_what_is_wrong(
    folder: Path, tmp_path: Path, pose: Pose, said: str
) -> None:
    write_pose(tmp_path / "pose.toml", pose)
    image = str(folder / "frames" / "000.png")
    done = command("vision_server", "check", *of(folder, image, "--pose", str(tmp_path / "pose.toml")))
    assert done.returncode == 3
    assert said in done.stderr


def test_where_a_target_is_in_no_frame_it_is_said_what_may_help(folder: Path, tmp_path: Path) -> None:
    black = tmp_path / "black.png"
    cv2.imwrite(str(black), np.zeros((CAMERA.height, CAMERA.width), np.uint8))
    done = command(
        "vision_server", "track", *of(folder, str(black), "--seed-pose", str(folder / "right.toml"))
    )
    assert done.returncode == 3
    assert "found in no frame" in done.stderr and "Leave out --seed-pose" in done.stderr
    assert "Leave out" not in command("vision_server", "track", *of(folder, str(black))).stderr


def test_a_video_that_was_cut_off_is_said(folder: Path, tmp_path: Path) -> None:
    # What a library writes by itself would be on standard error, too.
    content = (folder / "film.avi").read_bytes()
    seed = ["--seed-pose", str(folder / "right.toml"), "--json"]
    (tmp_path / "cut.avi").write_bytes(content[: len(content) * 3 // 5])
    done = process("vision_server", "track", *of(folder, str(tmp_path / "cut.avi"), *seed))
    assert done.returncode in (0, 2)
    assert len(done.stderr.strip().splitlines()) == 1
    assert "cut.avi" in done.stderr
    (tmp_path / "none.mp4").write_bytes(content[:100])
    done = command("vision_server", "track", *of(folder, str(tmp_path / "none.mp4"), *seed))
    assert done.returncode == 2
    assert "is no video or camera that can be read" in done.stderr


def test_frames_of_another_size_end_in_a_message(folder: Path) -> None:
    frames = [str(folder / "frames" / "000.png"), str(folder / "small.png")]
    done = command(
        "vision_server", "track", *of(folder, *frames, "--seed-pose", str(folder / "right.toml"), "--json")
    )
    assert done.returncode == 2
    assert len(done.stdout.splitlines()) == 1
    assert "small.png: Frame 1 has 100x100 px of uint8, the camera 320x240" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_radius_of_edges_is_told_by_file_or_option(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    told, camera, start = [], tmp_path / "camera.toml", Tracker.__init__

    def heard(self: Tracker, *values: object) -> None:
        told.append(values[-1])
        start(self, *values)  # type: ignore[arg-type]

    monkeypatch.setattr(Tracker, "__init__", heard)
    words = ["track", str(folder / "frames" / "000.png"), "--model", str(folder / "cuboid.cao")]
    words += ["--camera", str(camera), "--seed-pose", str(folder / "right.toml"), "--json"]
    for line, more in (("", []), ("edge_radius_m = 0.001", []), ("", ["--edge-radius", "0.0005"])):
        camera.write_text((folder / "camera.toml").read_text() + f"[target]\n{line}\n")
        assert run_command("vision_server", "Vision server.", COMMANDS, [*words, *more]) == 0
    assert told == [None, 0.001, 0.0005]
    capsys.readouterr()
    camera.write_text((folder / "camera.toml").read_text() + "[target]\nedge_radius_m = -1\n")
    assert run_command("vision_server", "Vision server.", COMMANDS, words) == 2
    assert "edge_radius_m must be a number from 0 to" in capsys.readouterr().err
    check = ["check", *words[1:-3], "--pose", str(folder / "right.toml"), "--edge-radius", "1"]
    camera.write_text((folder / "camera.toml").read_text())
    assert run_command("vision_server", "Vision server.", COMMANDS, check) == 2
    assert "--edge-radius must be a number from 0 to" in capsys.readouterr().err


def test_a_pose_is_judged(folder: Path) -> None:
    image = str(folder / "frames" / "000.png")
    right = command(
        "vision_server", "check", *of(folder, image, "--pose", str(folder / "right.toml"), "--json")
    )
    told = json.loads(right.stdout)
    assert (right.returncode, told["state"], told["better"]) == (0, "ok", None)
    assert told["probability"] > 0.9
    wrong = command(
        "vision_server", "check", *of(folder, image, "--pose", str(folder / "wrong.toml"), "--json")
    )
    told = json.loads(wrong.stdout)
    assert (wrong.returncode, told["state"]) == (3, "lost")
    assert Pose.from_dict(told["better"]).error_to(POSE).within(0.3, 0.003)
    assert command("vision_server", "check", *of(folder, image, "--pose", "nothing.toml")).returncode == 2


@pytest.mark.parametrize("table", ["", "[target.seed_pose]\n"])
def test_a_pose_is_not_taken_from_a_table(folder: Path, table: str) -> None:
    text = table and table + (folder / "right.toml").read_text()
    (folder / "elsewhere.toml").write_text(text)
    image = str(folder / "frames" / "000.png")
    done = command("vision_server", "check", *of(folder, image, "--pose", str(folder / "elsewhere.toml")))
    assert done.returncode == 2
    assert "Give rotation_vector and translation at its top" in done.stderr


def test_a_film_of_another_kind_is_refused_before_anything_is_done(folder: Path) -> None:
    words = of(folder, str(folder / "frames"), "--overlay", str(folder / "film.png"))
    done = command("vision_server", "track", *words)
    assert (done.returncode, done.stdout) == (2, "")
    assert "must end in .mp4 or .mov" in done.stderr


def test_a_video_is_not_written_over(folder: Path, tmp_path: Path) -> None:
    video = tmp_path / "film.mp4"
    shutil.copy(folder / "film.avi", video)
    done = command("vision_server", "track", *of(folder, str(video), "--overlay", str(video)))
    assert (done.returncode, done.stdout) == (2, "")
    assert "it is read as well" in done.stderr
    assert video.read_bytes() == (folder / "film.avi").read_bytes()


def test_a_film_that_cannot_be_written_to_its_end_is_said(folder: Path, tmp_path: Path) -> None:
    words = of(folder, str(folder / "frames"), "--seed-pose", str(folder / "right.toml"), "--json")
    line = [sys.executable, "-m", "vision_server", "track", *words, "--overlay", str(tmp_path / "out.mp4")]
    limited = ["sh", "-c", 'ulimit -f 4; exec "$@"', "sh", *line]
    done = subprocess.run(limited, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 4, done.stderr
    assert len(done.stdout.splitlines()) == COUNT
    assert done.stderr.splitlines()[-1].endswith("cannot be written to its end. Is the disk full?")
    assert len(done.stderr.splitlines()) == 1


def test_a_rate_that_no_film_has_is_not_a_film_s(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = Source([str(folder / "film.avi")])
    assert source.rate() == 25.0
    assert Source([str(folder / "frames")]).rate() is None
    monkeypatch.setattr(sources, "RATES", (30.0, 60.0))
    assert source.rate() is None


@pytest.mark.parametrize("kind", ["bmp", "jpg", "png", "pnm", "ppm", "tif", "webp"])
def test_frames_may_be_images_of_each_kind_that_estimate_reads(tmp_path: Path, kind: str) -> None:
    cv2.imwrite(str(tmp_path / f"f.{kind}"), np.full((16, 16, 3), 90, np.uint8))
    (frame,) = Source([str(tmp_path)])
    assert np.abs(frame.pixels.astype(int) - 90).max() <= 2


def test_of_a_session_s_folder_its_frames_are_tracked_in_their_order(tmp_path: Path) -> None:
    pictures = ["i1", "i1-overlay", "i1-edges", "i2", "._i2", "i10"]
    for name in pictures:
        cv2.imwrite(str(tmp_path / f"{name}.png"), np.zeros((4, 4), np.uint8))
    assert [Path(frame.name).stem for frame in Source([str(tmp_path)])] == ["i1", "i2", "i10"]
    frame = '[[frames]]\nimage = "{}.png"\nlights = [1]\nshutter_s = 0.1\naperture = 4.0\n'
    (tmp_path / "stack.toml").write_text("".join(map(frame.format, ("i2", "i1", "i10"))))
    assert [Path(frame.name).stem for frame in Source([str(tmp_path)])] == ["i2", "i1", "i10"]


@pytest.fixture
def served(tmp_path: Path) -> Iterator[list[str]]:
    """The words of a command line for what a simulated image server shows."""
    device = Simulator("cube", "nominal", 1)
    target = device.describe().target
    assert target is not None
    camera_file(tmp_path / "camera.toml", device.camera)
    write_pose(tmp_path / "seed.toml", device.true_pose)
    words = ["--model", target.model, "--camera", str(tmp_path / "camera.toml"), "--unit", target.unit]
    with tempfile.TemporaryDirectory(prefix="t") as sockets:
        server = Running(ImageServer(device), f"ipc://{sockets}/images")
        yield [server.endpoint, *words, "--seed-pose", str(tmp_path / "seed.toml"), "--json"]
        server.stop()


def test_the_command_follows_what_a_server_shows(served: list[str]) -> None:
    done = command("vision_server", "track", *served, "--switch-lights", "--count", "3")
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) == 3


@pytest.mark.parametrize(("sent", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_ends_a_camera_and_leaves_a_whole_film(
    root: Path, served: list[str], tmp_path: Path, sent: signal.Signals, status: int
) -> None:
    film = tmp_path / "out.mp4"
    line = [sys.executable, "-m", "vision_server", "track", *served, "--overlay", str(film)]
    with started(line, cwd=root, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as running:
        assert running.stdout is not None
        assert [json.loads(running.stdout.readline())["frame"] for _ in range(2)] == [0, 1]
        running.send_signal(sent)
        _, said = running.communicate(timeout=60)
    assert running.returncode == status
    assert "Traceback" not in said
    assert int(cv2.VideoCapture(str(film)).get(cv2.CAP_PROP_FRAME_COUNT)) > 0


def test_ctrl_c_that_a_library_catches_still_ends_a_camera(
    served: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    step = Tracker.step

    def pressed_meanwhile(tracker: Tracker, pixels: Pixels, time_s: float) -> Tracked:
        with suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        return step(tracker, pixels, time_s)

    monkeypatch.setattr(Tracker, "step", pressed_meanwhile)
    assert run_command("vision_server", "", COMMANDS, ["track", *served, "--count", "3"]) == 130


def without_camera(words: list[str]) -> list[str]:
    place = words.index("--camera")
    return words[:place] + words[place + 2 :]


def test_a_server_s_own_camera_is_used_and_another_one_is_said(
    served: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def told(words: list[str]) -> tuple[list[str], str]:
        assert run_command("vision_server", "", COMMANDS, ["track", *words, "--count", "1"]) == 0
        said = capsys.readouterr()
        return [json.loads(line)["state"] for line in said.out.splitlines()], said.err

    own = told(without_camera(served))
    assert own == told(served)
    assert own[1] == ""
    camera = Path(served[served.index("--camera") + 1])
    fx = Simulator("cube", "nominal", 1).camera.fx
    camera.write_text(camera.read_text().replace(f"fx = {fx}", f"fx = {0.95 * fx}"))
    assert "the image server describes another camera" in told(served)[1]


def test_without_a_camera_files_are_not_tracked(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["track", str(folder / "frames"), "--model", str(folder / "cuboid.cao")]
    assert run_command("vision_server", "", COMMANDS, words) == 2
    assert "Give --camera FILE" in capsys.readouterr().err
    assert run_command("vision_server", "", COMMANDS, [*words, "--camera", "c.toml", "--keys", "k"]) == 2
    assert "Only an image server takes --keys" in capsys.readouterr().err


def test_images_of_which_one_shows_the_target_elsewhere_are_named(folder: Path, tmp_path: Path) -> None:
    turned = Pose(POSE.rotation_vector + np.array([0.0, 0.0, 0.5]), POSE.translation)
    for number, frame in enumerate(filmed(cuboid(tmp_path), [turned, None])):
        cv2.imwrite(str(tmp_path / f"{number}.png"), frame)
    words = [str(folder / "frames" / "000.png"), str(tmp_path / "0.png"), str(tmp_path / "1.png")]
    done = command(
        "vision_server", "check", *of(folder, *words, "--pose", str(folder / "right.toml"), "--json")
    )
    assert json.loads(done.stdout)["disagreeing_images"] == [words[1]]
    assert f"{words[1]}: each alone shows the target elsewhere" in done.stderr
    words = [words[1], words[1], "--pose", str(folder / "right.toml"), "--json"]
    done = command("vision_server", "check", *of(folder, *words))
    assert json.loads(done.stdout)["disagreeing_images"] == []
