"""A wheel, installed into an empty environment, does from an empty folder what a checkout does."""

import json
import os
import shutil
import subprocess
import sys
import sysconfig
from importlib.metadata import version
from pathlib import Path

import pytest

import bridge

pytestmark = pytest.mark.slow

DEADLINE_S = 300.0
NOT_SOURCES = shutil.ignore_patterns(
    ".*", "__pycache__", "build", "runs", "tests", "benchmarks", "docs", "*.so", "*.qlf", "*.egg-info"
)


def done(*words: str | Path, cwd: Path, **more: str) -> subprocess.CompletedProcess[str]:
    """Run a command of the installation to its end, with nothing of this checkout in its environment."""
    ours = ("PYTHON", "VIRTUAL", "LIGHTS_AND")
    environment = {key: value for key, value in os.environ.items() if not key.startswith(ours)}
    return subprocess.run(
        [str(word) for word in words],
        cwd=cwd,
        env=environment | more,
        capture_output=True,
        text=True,
        timeout=DEADLINE_S,
        stdin=subprocess.DEVNULL,
        check=False,
    )


@pytest.fixture(scope="module")
def scripts(root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The `bin` of an environment with the wheel in it; dependencies come from the tests' own."""
    folder = tmp_path_factory.mktemp("installed")
    shutil.copytree(root, folder / "source", ignore=NOT_SOURCES)
    isolated = int(version("setuptools").split(".")[0]) < 77  # what pyproject.toml needs to be understood
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check"]
    how = [] if isolated else ["--no-build-isolation"]
    built = done(*pip, "wheel", "--no-deps", *how, "-w", folder, folder / "source", cwd=folder)
    assert built.returncode == 0, built.stderr
    shutil.rmtree(folder / "source")
    assert done(sys.executable, "-m", "venv", "--without-pip", folder / "venv", cwd=folder).returncode == 0
    python = folder / "venv" / "bin" / "python"
    where = done(python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))", cwd=folder)
    site = Path(where.stdout.strip())
    wheel = next(folder.glob("*.whl"))
    installed = done(*pip, "--python", python, "install", "--no-deps", "--no-index", wheel, cwd=folder)
    assert installed.returncode == 0, installed.stderr
    (site / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return python.parent


@pytest.fixture(scope="module")
def session(scripts: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The run folder of a short session of the installed command, started in an empty folder."""
    folder = tmp_path_factory.mktemp("elsewhere")
    ran = done(
        scripts / "lights-and-camera", "--controller", "fixed", "--max-iterations", "1", "--out", "run",
        cwd=folder,
    )  # fmt: skip
    assert ran.returncode in (0, 3), ran.stderr
    return folder / "run"


def test_the_files_are_the_installed_ones(scripts: Path, tmp_path: Path) -> None:
    rooms = "bridge, geometry, image_server, numerics, report, session, stack, vision_server"
    program = f"import {rooms}; print({rooms.replace(', ', '.__file__, ')}.__file__)"
    told = done(scripts / "python", "-c", program, cwd=tmp_path)
    assert told.returncode == 0, told.stderr
    assert all(Path(file).is_relative_to(scripts.parent) for file in told.stdout.split())
    assert all(Path(file).with_name("py.typed").exists() for file in told.stdout.split())


@pytest.mark.parametrize("command", ["vision-server", "image-server"])
def test_commands_of_the_servers_are_there(scripts: Path, tmp_path: Path, command: str) -> None:
    assert "Commands:" in done(scripts / command, "--help", cwd=tmp_path).stdout
    module = command.replace("-", "_")
    assert "Commands:" in done(scripts / "python", "-m", module, "--help", cwd=tmp_path).stdout


def test_a_session_leaves_a_pose_and_a_report(session: Path) -> None:
    assert json.loads((session / "result.json").read_text())["pose"] is not None
    assert "</html>" in (session / "report.html").read_text()


def test_a_pose_is_estimated_from_a_stack(scripts: Path, session: Path) -> None:
    stack = session / "images" / "stack.toml"
    images = sorted(file for file in stack.parent.glob("*.png") if "overlay" not in file.name)
    assert done(scripts / "python", "-m", "vision_server", "estimate", "--help", cwd=session).returncode == 0
    ran = done(
        scripts / "python", "-m", "vision_server", "estimate", "--model", next(stack.parent.glob("*.cao")),
        "--camera", stack, "--seed-pose", stack, *images, "--json", cwd=session,
    )  # fmt: skip
    assert ran.returncode == 0, ran.stderr
    assert len(json.loads(ran.stdout)["pose"]["translation"]) == 3


def test_a_report_is_written_again(scripts: Path, session: Path) -> None:
    (session / "report.html").unlink()
    ran = done(scripts / "python", "-m", "report", session, cwd=session)
    assert ran.returncode == 0, ran.stderr
    assert (session / "report.html").is_file()


def test_the_interpreter_runs_an_example(scripts: Path, root: Path, tmp_path: Path) -> None:
    shutil.copy(root / "examples" / "elevator.pl", tmp_path)
    site = Path(bridge_file(scripts, tmp_path)).parent.parent
    ran = done("swipl", site / "indigolog" / "run.pl", "--", "elevator.pl", "control", cwd=tmp_path)
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout.rstrip().endswith("actions.")


def test_a_c_module_that_cannot_be_built_is_said(scripts: Path, tmp_path: Path) -> None:
    module = Path(bridge_file(scripts, tmp_path)).with_name("prolog") / "zmq4pl.so"
    kept = module.read_bytes() if module.exists() else None
    module.unlink(missing_ok=True)
    swipl = tmp_path / "only" / "swipl"
    swipl.parent.mkdir()
    swipl.symlink_to(shutil.which("swipl") or "")
    ran = done(scripts / "lights-and-camera", "--help", cwd=tmp_path, PATH=str(swipl.parent))
    if kept is not None:
        module.write_bytes(kept)
    assert ran.returncode == 2
    assert "swipl-ld" in ran.stderr and "libzmq3-dev" in ran.stderr


def bridge_file(scripts: Path, cwd: Path) -> str:
    """Where the installed bridge is."""
    return done(scripts / "python", "-c", "import bridge; print(bridge.__file__)", cwd=cwd).stdout.strip()


def test_the_version_is_told_once(scripts: Path, tmp_path: Path) -> None:
    program = "from importlib.metadata import version; print(version('lights-and-camera'))"
    told = done(scripts / "python", "-c", program, cwd=tmp_path)
    assert told.stdout.strip() == bridge.__version__
