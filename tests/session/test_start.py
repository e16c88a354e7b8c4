"""What a session loads before its servers start, and a strategy all the same finds what no file names."""

import subprocess
from pathlib import Path

import pytest

import bridge
from tests.session.command import controller

LOADED = (
    "lights_and_camera:load('{root}', '/session/{part}'), "
    "( module_property(predicate_options, file(_)) -> writeln(checks) ; writeln(parts) ), "
    "current_prolog_flag(autoload, Autoload), writeln(Autoload)"
)


@pytest.mark.parametrize("part", ["opening", "run"])
def test_checks_of_options_are_not_loaded(root: Path, part: str) -> None:
    goal = LOADED.format(root=root, part=part)
    done = subprocess.run(
        ["swipl", "-q", "-l", "main.pl", "-g", goal, "-t", "halt"],
        cwd=root, capture_output=True, text=True, timeout=60, check=True,
    )  # fmt: skip
    assert done.stdout.split() == ["parts", "true"], done.stderr


def test_the_version_is_told() -> None:
    done = controller("--version")
    assert (done.returncode, done.stdout) == (0, f"lights-and-camera {bridge.__version__}\n")
