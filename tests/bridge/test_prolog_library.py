"""The Prolog side of the bridge, used by a program that lies somewhere else."""

import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = """
:- use_module('{folder}/client').
:- use_module('{folder}/zmq').
:- initialization((zmq_socket(dealer, S, []), zmq_close(S), writeln(loaded), halt)).
"""


@pytest.mark.parametrize("compiled", [False, True])
def test_it_is_loaded_from_another_folder(tmp_path: Path, compiled: bool) -> None:
    folder = tmp_path / "elsewhere" / "prolog"
    shutil.copytree(ROOT / "bridge" / "prolog", folder, ignore=shutil.ignore_patterns("*.qlf"))
    if compiled:
        goal = f"qcompile('{folder}/zmq'), qcompile('{folder}/client')"
        subprocess.run(["swipl", "-g", goal, "-t", "halt"], check=True, timeout=240)
        assert (folder / "zmq.qlf").exists()
    program = tmp_path / "mine.pl"
    program.write_text(PROGRAM.format(folder=folder))
    done = subprocess.run(
        ["swipl", program.name], cwd=tmp_path, capture_output=True, text=True, timeout=240, check=False
    )
    assert (done.stdout, done.stderr, done.returncode) == ("loaded\n", "", 0)
