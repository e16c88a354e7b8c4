"""A wheel, installed into an empty environment, does from an empty folder what a checkout does."""

import json
import os
import shutil
import subprocess
import sys
import sysconfig
import tomllib
import zipfile
from importlib.metadata import version
from pathlib import Path

import pytest

import bridge

pytestmark = pytest.mark.slow

DEADLINE_S = 300.0
PIP = (sys.executable, "-m", "pip", "--disable-pip-version-check")
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


def copied_source(root: Path, folder: Path) -> Path:
    """A copy of what is built from."""
    shutil.copytree(root, folder / "source", ignore=NOT_SOURCES)
    return folder / "source"


def built_wheel(source: Path, folder: Path) -> Path:
    """The wheel of a folder of sources."""
    isolated = int(version("setuptools").split(".")[0]) < 77  # what pyproject.toml needs to be understood
    how = [] if isolated else ["--no-build-isolation"]
    built = done(*PIP, "wheel", "--no-deps", *how, "-w", folder, source, cwd=folder)
    assert built.returncode == 0, built.stderr
    return next(folder.glob("*.whl"))


@pytest.fixture(scope="module")
def wheel(root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel of an archive of sources, built in a folder where an older build has left a module."""
    folder = tmp_path_factory.mktemp("built")
    source = copied_source(root, folder)
    packed = done(sys.executable, "setup.py", "-q", "sdist", "-d", folder, cwd=source)
    assert packed.returncode == 0, packed.stderr
    (archive,) = folder.glob("*.tar.gz")
    assert done("tar", "-xf", archive, cwd=folder).returncode == 0
    unpacked = folder / archive.name.removesuffix(".tar.gz")
    gone = unpacked / "build" / "lib" / "geometry" / "gone.py"
    gone.parent.mkdir(parents=True)
    gone.touch()
    made = built_wheel(unpacked, folder)
    shutil.rmtree(source)
    shutil.rmtree(unpacked)
    return made


@pytest.fixture(scope="module")
def scripts(root: Path, wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The `bin` of an environment with the wheel in it; dependencies come from the tests' own."""
    folder = tmp_path_factory.mktemp("installed")
    assert done(sys.executable, "-m", "venv", "--without-pip", folder / "venv", cwd=folder).returncode == 0
    python = folder / "venv" / "bin" / "python"
    where = done(python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))", cwd=folder)
    site = Path(where.stdout.strip())
    installed = done(*PIP, "--python", python, "install", "--no-deps", "--no-index", wheel, cwd=folder)
    assert installed.returncode == 0, installed.stderr
    (site / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    bring_compiled_kernels(root, site)
    return python.parent


def bring_compiled_kernels(root: Path, site: Path) -> None:
    """What `make setup` has compiled, except numerics': to compile all of them takes a minute.

    Numba knows a source by its size and age.
    """
    for kernel in root.glob("*/**/__pycache__/*.nb[ci]"):
        folder = kernel.parent.parent.relative_to(root)
        source = folder / f"{kernel.name.partition('.')[0]}.py"
        if folder.parts[0] != "numerics" and (site / source).is_file():
            (site / folder / "__pycache__").mkdir(exist_ok=True)
            shutil.copy2(kernel, site / folder / "__pycache__")
            shutil.copystat(root / source, site / source)


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
    rooms = "bridge, experiments, geometry, image_server, numerics, report, session, stack, vision_server"
    program = f"import {rooms}; print({rooms.replace(', ', '.__file__, ')}.__file__)"
    told = done(scripts / "python", "-c", program, cwd=tmp_path)
    assert told.returncode == 0, told.stderr
    assert all(Path(file).is_relative_to(scripts.parent) for file in told.stdout.split())
    assert all(Path(file).with_name("py.typed").exists() for file in told.stdout.split())


def test_a_wheel_has_what_the_rooms_have_and_nothing_of_an_older_build(root: Path, wheel: Path) -> None:
    held = set(zipfile.ZipFile(wheel).namelist())
    assert "geometry/gone.py" not in held
    packaging = tomllib.loads((root / "pyproject.toml").read_text())["tool"]["setuptools"]
    rooms = packaging["packages"]["find"]["include"]
    listed = subprocess.run(
        ["git", "ls-files", "--", "main.pl", *(room.strip("*") for room in rooms)],
        cwd=root, capture_output=True, text=True, check=False,
    )  # fmt: skip
    if listed.returncode != 0:
        pytest.skip("no git here that lists the sources")
    assert set(listed.stdout.split()) - held == set()


@pytest.mark.parametrize("command", ["vision-server", "image-server"])
def test_commands_of_the_servers_are_there(scripts: Path, tmp_path: Path, command: str) -> None:
    told = done(scripts / command, "--help", cwd=tmp_path).stdout
    assert told.startswith(f"Usage: {command} COMMAND ...") and "Commands:" in told
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


def test_a_strategy_of_ones_own_is_begun(scripts: Path, tmp_path: Path) -> None:
    ran = done(scripts / "python", "-m", "bridge", "new-controller", "mine", cwd=tmp_path)
    assert ran.returncode == 0, ran.stderr
    assert "lights-and-camera --controller mine/mine.pl" in ran.stdout
    tested = done("swipl", "-g", "run_tests", "-t", "halt", "mine/mine.plt", cwd=tmp_path)
    assert tested.returncode == 0, tested.stderr


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
    said = done(scripts / "lights-and-camera", "--version", cwd=tmp_path)
    assert said.stdout == f"lights-and-camera {bridge.__version__}\n"


def test_a_session_s_help_names_the_command(scripts: Path, tmp_path: Path) -> None:
    assert (
        "\nUsage: lights-and-camera [options]\n"
        in done(scripts / "lights-and-camera", "--help", cwd=tmp_path).stdout
    )
