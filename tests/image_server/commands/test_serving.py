"""The command line and the server over real sockets."""

import os
import signal
import subprocess
import sys
from argparse import ArgumentParser
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from bridge.arrays import array_sha256
from bridge.client import Client
from bridge.errors import ServerError
from image_server.commands import record
from image_server.commands.options import add_conditions, given_conditions
from tests.commands import command
from tests.stack.stack_folders import BASIS, basis_stack

DEADLINE_S = 120.0
REPLAY = ("replay", "--stack", "s", "--endpoint", "ipc:///e")
SETTINGS = {"lights": [4, 4, 4], "shutter_s": 1 / 60, "aperture": 4.0}


def image_server(*arguments: str | Path) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [sys.executable, "-m", "image_server", *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.fixture
def simulator(tmp_path: Path) -> "Iterator[tuple[subprocess.Popen[str], str]]":
    endpoint = f"ipc://{tmp_path}/image"
    process = image_server(
        "simulator", "--target", "cube", "--scenario", "approach", "--seed", "3", "--endpoint", endpoint,
        "--events", f"ipc://{tmp_path}/events",
    )  # fmt: skip
    try:
        yield process, endpoint
    finally:
        process.kill()
        process.communicate()


def test_a_simulator_serves_its_operations(simulator: "tuple[subprocess.Popen[str], str]") -> None:
    process, endpoint = simulator
    with Client(endpoint, timeout_s=DEADLINE_S) as client:
        described, _ = client.request("describe", {})
        assert described["device"] == "simulator"
        assert described["movable"] is True
        assert described["events"] == endpoint.replace("image", "events")
        assert "true_pose" not in str(described)
        header, (pixels,) = client.request("capture", {"settings": SETTINGS})
        assert pixels.shape == (480, 640) and pixels.dtype == np.uint8
        assert header["sha256"] == array_sha256(pixels)
        assert header["verified"] is True and header["sequence"] == 1
        moved, _ = client.request("move", {"range_m": 0.9})
        assert [event["event"] for event in moved["events"]] == ["target_moved", "sun_changed"]
        score, _ = client.request("score", {"pose": described["target"]["seed_pose"]})
        assert score["error"]["translation_fraction_of_range"] > 0.3
        with pytest.raises(ServerError, match="no level 9"):
            client.request("capture", {"settings": {**SETTINGS, "lights": [9, 0, 0]}})
        client.request("shutdown", {})
    assert process.wait(DEADLINE_S) == 0


def test_a_terminated_server_ends_and_takes_its_socket_along(
    simulator: "tuple[subprocess.Popen[str], str]",
) -> None:
    process, endpoint = simulator
    with Client(endpoint, timeout_s=DEADLINE_S) as client:
        client.request("describe", {})
    os.kill(process.pid, signal.SIGTERM)
    assert process.wait(DEADLINE_S) == 143


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["replay", "--stack", "nowhere"], "There is no stack folder nowhere"),
        (["simulator", "--target", "pyramid"], "unknown target 'pyramid'; known: cube"),
        (["simulator", "--scenario", "dusk"], "There is no scenario 'dusk'"),
        (["simulator", "--unit", "ell"], "unknown unit 'ell'"),
    ],
)
def test_bad_input_ends_with_one_plain_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], message: str
) -> None:
    monkeypatch.setattr("faulthandler.enable", lambda: None)  # it is pytest's here
    done = command("image_server", *arguments, "--endpoint", f"ipc://{tmp_path}/image")
    assert done.returncode == 2
    assert message in done.stderr
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            [*REPLAY, "--ambient-scale", "nan"],
            "--ambient-scale: must be 0 to 1e+09, not nan",
        ),
        (
            [*REPLAY, "--seed", "-1"],
            "--seed: must be 0 to 9223372036854775807, not -1",
        ),
        ([*REPLAY, "--light-power", "x"], "'x' is not a number"),
        ([*REPLAY, "--light-power", "1e300"], "--light-power: must be 0 to 1e+09, not 1e300"),
        (
            [*REPLAY, "--motion-px-per-s", "1"],
            "--motion-px-per-s: expected 2",
        ),
        (["replay", "--stack", "s"], "required: --endpoint"),
        (["simulator", "--endpoint", "ipc:///e", "--targets", "cube"], "--targets"),
        (["record", "out", "--kind", "film"], "invalid choice: 'film' (choose from 'frames', 'basis')"),
        (
            ["record", "out", "--kind", "frames", "--repeat", "2000"],
            "must be 1 to 1000, not",
        ),
        ([*REPLAY, "--light-dies", "left"], "'left' is not NAME:CAPTURES, such as left:3"),
        ([*REPLAY, "--moved", "0.8"], "'0.8' is not RANGE_M:CAPTURES, such as 0.8:3"),
        (["project"], "no command 'project'; there are replay, simulator"),
        (["simulate"], "Did you mean simulator?"),
    ],
)
def test_a_wrong_command_line_is_told(arguments: list[str], message: str) -> None:
    done = command("image_server", *arguments)
    assert done.returncode == 2
    assert not done.stdout
    assert message in done.stderr.splitlines()[-1]


def test_values_are_what_the_command_takes() -> None:
    record.add_options(parser := ArgumentParser())
    words = ["out", "--kind", "basis", "--settings", "each", "--settings", "7:1/60:4", "--seed", "3"]
    given = parser.parse_args(words)
    assert given.out == Path("out") and given.kind == "basis"
    assert given.settings == ["each", "7:1/60:4"] and given.black == 0.0 and given.camera is None
    assert (given.seed, given.captures_taken) == (3, 0) and given.lights is None and given.unit == "m"
    assert "--moved" not in parser.format_help()  # of a session that goes on
    add_conditions(parser := ArgumentParser())
    moved = parser.parse_args(["--motion-px-per-s", "-24", "0.5"])
    assert given_conditions(moved) == (None, None, None, (-24.0, 0.5))


def test_a_broken_stack_and_a_bad_endpoint_end_the_same_way(tmp_path: Path) -> None:
    basis_stack(tmp_path, BASIS.replace("fx = 40.0", 'fx = "long"'))
    for endpoint, message in ((f"ipc://{tmp_path}/image", "stack.toml: expected `float`"), ("tcp://", "")):
        process = image_server("replay", "--stack", tmp_path, "--endpoint", endpoint)
        _, complaint = process.communicate(timeout=DEADLINE_S)
        assert process.returncode == 2
        assert message in complaint
        assert complaint.count("\n") == 1


def test_a_server_ends_with_its_parent(tmp_path: Path) -> None:
    parent = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
    endpoint = f"ipc://{tmp_path}/image"
    process = image_server("simulator", "--endpoint", endpoint, "--parent", str(parent.pid))
    with Client(endpoint, timeout_s=DEADLINE_S) as client:
        client.request("describe", {})
    parent.kill()
    parent.communicate()
    assert process.wait(DEADLINE_S) == 0
    process.communicate()
