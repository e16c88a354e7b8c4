"""Lights go out when nobody asks for them, however that comes."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from image_server.lights.line_protocol import encoded
from image_server.lights.opening import open_rig
from tests.equipment.emulator import Emulator
from tests.equipment.line import EmulatedLineDriver
from tests.image_server.lights.lights_files import lights_file, until


def test_lights_go_out_when_nobody_asks(tmp_path: Path) -> None:
    emulator = EmulatedLineDriver()
    rig = open_rig(str(lights_file(tmp_path, emulator.path, "line", dark_after_s=0.3)))
    rig.light((7, 2))
    assert emulator.outputs == [255, 200, 200]
    assert until(lambda: emulator.outputs == [0, 0, 0])
    assert not rig.present().verified
    rig.heard()
    assert rig.light((7, 2)).verified
    rig.close()
    emulator.close()


def test_the_line_driver_goes_dark_by_itself() -> None:
    emulator = EmulatedLineDriver()
    slave = os.open(emulator.path, os.O_RDWR | os.O_NOCTTY)
    os.write(slave, encoded(1, "HOLD 2000") + encoded(2, "SET 9 9 9"))
    assert until(lambda: emulator.outputs == [9, 9, 9])
    assert until(lambda: emulator.outputs == [0, 0, 0])
    os.close(slave)
    emulator.close()


SERVER = """
import sys, time
from image_server.lights.opening import open_rig
rig = open_rig(sys.argv[1])
rig.light((7, 2))
print("lit", flush=True)
time.sleep(600)
"""


@pytest.mark.parametrize("sent", [signal.SIGKILL, signal.SIGTERM])
def test_lights_go_out_however_their_process_ends(bench: tuple[Emulator, Path], sent: signal.Signals) -> None:
    emulator, file = bench
    if isinstance(emulator, EmulatedLineDriver):
        file.write_text(f"hold_off_s = 0\n{file.read_text()}")  # then only the watchdog can do it
    process = subprocess.Popen([sys.executable, "-c", SERVER, str(file)], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "lit\n"
    assert emulator.outputs == [255, 200, 200]
    process.send_signal(sent)
    process.wait(60)
    process.stdout.close()
    assert until(lambda: emulator.outputs == [0, 0, 0])


COUNTING_SERVER = """
import sys
from image_server.lights.opening import open_rig
rig = open_rig(sys.argv[1])
for asked in sys.stdin:
    lit = rig.light((7, 2)) if asked == "light\\n" else rig.present()
    print(*lit.levels, lit.verified, flush=True)
"""


@pytest.mark.slow
def test_lights_of_a_server_that_hangs_go_out_and_it_knows(bench: tuple[Emulator, Path]) -> None:
    emulator, file = bench
    file.write_text(f"hold_off_s = 4.0\n{file.read_text()}")
    emulator.tick = lambda: None  # type: ignore[method-assign]  # only the watchdog can do it
    readable = isinstance(emulator, EmulatedLineDriver)
    process = subprocess.Popen(
        [sys.executable, "-c", COUNTING_SERVER, str(file)],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1,
    )  # fmt: skip
    words, answers = process.stdin, process.stdout
    assert words is not None and answers is not None

    def ask(what: str) -> str:
        words.write(f"{what}\n")
        return answers.readline()

    try:
        assert ask("light") == f"7 2 {readable}\n"
        time.sleep(5.0)  # alive, it is left alone
        assert emulator.outputs == [255, 200, 200]
        process.send_signal(signal.SIGSTOP)
        assert until(lambda: emulator.outputs == [0, 0, 0])
        process.send_signal(signal.SIGCONT)
        assert ask("present") == "0 0 False\n"  # so the frame that was being taken is not called lit
        assert ask("light") == f"7 2 {readable}\n"
        assert until(lambda: emulator.outputs == [255, 200, 200])
        process.send_signal(signal.SIGSTOP)
        assert until(lambda: emulator.outputs == [0, 0, 0])  # and again
    finally:
        process.kill()
        process.wait(60)
        words.close()
        answers.close()
