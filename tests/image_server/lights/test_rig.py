"""Lights on emulated drivers: both protocols over a real pseudo-terminal, and what can go wrong."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bridge.errors import BadInput, DeviceError
from image_server.lights.dmx_usb_pro import MessageReader, dmx_packet, message
from image_server.lights.lights_file import load_lights_file
from image_server.lights.line_protocol import GarbledLineError, decoded, encoded
from image_server.lights.opening import open_rig
from image_server.lights.rig import LightRig
from tests.equipment.dmx import EmulatedDmxUsbPro
from tests.equipment.emulator import Emulator
from tests.equipment.line import EmulatedLineDriver
from tests.image_server.lights.lights_files import lights_file, until

# --- protocols ---


def test_a_dmx_packet_is_the_widgets() -> None:
    packet = dmx_packet([255, 1])
    assert packet[:7] == bytes([0x7E, 6, 25, 0, 0, 255, 1])  # label, length, start code, channels 1 and 2
    assert len(packet) == 4 + 25 + 1 and packet[-1] == 0xE7
    assert message(10) == bytes([0x7E, 10, 0, 0, 0xE7])
    assert dmx_packet([0] * 512)[2:4] == bytes([0x01, 0x02])  # 513 bytes, low byte first


@given(st.lists(st.tuples(st.integers(0, 255), st.binary(max_size=40)), max_size=4), st.data())
def test_messages_are_found_however_the_bytes_arrive(
    sent: list[tuple[int, bytes]], data: st.DataObject
) -> None:
    stream = b"".join(message(label, payload) for label, payload in sent)
    reader, found = MessageReader(), []
    while stream:
        size = data.draw(st.integers(1, len(stream)))
        found += reader.feed(stream[:size])
        stream = stream[size:]
    assert found == sent
    assert reader.skipped == 0


def test_garbage_between_messages_is_skipped() -> None:
    reader = MessageReader()
    assert reader.feed(b"\x00\xff" + message(3, b"abc") + b"\x7e\x01\xff\xff" + message(10)) == [
        (3, b"abc"),
        (10, b""),
    ]
    assert reader.skipped == 6


@given(st.integers(0, 10**6), st.text("ABC0123456789 =:,.-", max_size=40))
def test_a_line_comes_back_as_it_went(number: int, words: str) -> None:
    words = words.strip()
    assert decoded(encoded(number, words)) == (number, words)


def test_a_number_that_is_too_long_for_one_is_a_garbled_line() -> None:
    """An even count of ones: the check is that of the blank. It ended the thread that watches the lights."""
    with pytest.raises(GarbledLineError):
        decoded(b"1" * 5000 + b" *20\n")


@given(st.integers(0, 20), st.integers(1, 255))
def test_a_flipped_byte_is_noticed(position: int, flip: int) -> None:
    line = bytearray(encoded(17, "SET 0 128 255 7 9"))
    line[position] ^= flip
    with pytest.raises(GarbledLineError):
        decoded(bytes(line))


# --- levels and channels ---


def test_levels_reach_their_channels(bench: tuple[Emulator, Path]) -> None:
    emulator, file = bench
    rig = open_rig(str(file))
    try:
        lit = rig.light((7, 1))
        assert lit.levels == (7, 1)
        assert until(lambda: emulator.outputs == [255, 10, 10])
        assert lit.verified == isinstance(emulator, EmulatedLineDriver)  # DMX cannot be read back
        rig.light((3, 2))
        assert until(lambda: emulator.outputs == [109, 200, 200])
    finally:
        rig.close()
    assert until(lambda: emulator.outputs == [0, 0, 0])


def test_a_device_without_a_file_is_asked_what_it_speaks() -> None:
    for kind, names in (
        (EmulatedLineDriver, ["light1", "light2", "light3"]),
        (EmulatedDmxUsbPro, ["left", "right", "top"]),
    ):
        emulator: Emulator = kind()
        rig = open_rig(emulator.path)
        assert [light.name for light in rig.lights] == names
        rig.light((7, 0, 7))
        assert until(lambda shown=emulator: shown.outputs == [255, 0, 255])
        rig.close()
        emulator.close()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("channels = [1]", "channels = [2]", "channel 2 is used by 'left' and 'right'"),
        ("values = [0, 10, 200]", "values = [0, 10]", "3 levels, but 2 values"),
        ("values = [0, 10, 200]", "values = [5, 10, 200]", "not off at level 0"),
        (
            "values = [0, 10, 200]",
            "values = [0, 100, 20]",
            "values of light 'right' fall from a level",
        ),
        ("values = [0, 10, 200]", "values = [0, 10, 200]\nfull = 200", "light 'right' has full and values"),
        ('name = "right"', 'name = "left"', "two lights are called 'left'"),
        ('name = "right"', 'name = ""', "a light has an empty name"),
        ("channels = [1]", "channels = [513]", "512"),
        ("settle_s = 0.0", "settle_s = -1.0", "settle_s"),
        ("settle_s = 0.0", "setle_s = 1.0", "setle_s"),
        ('protocol = "line"', 'protocol = "dali"', "protocol"),
    ],
)
def test_a_bad_lights_file_names_the_key(tmp_path: Path, old: str, new: str, message: str) -> None:
    file = lights_file(tmp_path, "/dev/ttyUSB7", "line")
    file.write_text(file.read_text().replace(old, new))
    with pytest.raises(BadInput, match=message):
        load_lights_file(file)


def test_channels_and_values_must_be_the_drivers(tmp_path: Path) -> None:
    emulator = EmulatedLineDriver(channels=2)
    file = lights_file(tmp_path, emulator.path, "line")
    with pytest.raises(BadInput, match="uses channel 3, but emulated-driver"):
        open_rig(str(file))
    file.write_text(file.read_text().replace("[2, 3]", "[2]").replace("200]", "256]"))
    with pytest.raises(BadInput, match="goes up to 255"):
        open_rig(str(file))
    emulator.close()


# --- faults ---


@pytest.mark.parametrize("fault", ["silent", "garbage", "unplugged"])
def test_lights_that_fail_die_once_and_the_rig_goes_on(bench: tuple[Emulator, Path], fault: str) -> None:
    emulator, file = bench
    rig = open_rig(str(file))
    died: list[tuple[str, str]] = []
    rig.listen(lambda name, why: died.append((name, why)))
    rig.light((7, 2))
    emulator.fault(fault)
    lit = rig.light((1, 1))
    assert lit.levels == (0, 0) and not lit.verified
    assert [name for name, _ in died] == ["left", "right"]
    why = {"silent": "do not answer", "garbage": "answer with garbage", "unplugged": "are gone"}[fault]
    assert all(emulator.path in reason and why in reason for _, reason in died)
    assert not rig.light((7, 2)).verified
    assert set(rig.health()["dead_lights"]) == {"left", "right"}
    assert len(died) == 2
    rig.close()


def test_a_failed_channel_kills_its_light_only(
    line: tuple[EmulatedLineDriver, LightRig, list[str]],
) -> None:
    emulator, rig, died = line
    rig.light((7, 2))
    emulator.fault("dead:3")
    assert until(lambda: died == ["right"])
    lit = rig.light((7, 2))
    assert lit.levels == (7, 0)
    assert not lit.verified  # not what was asked for
    assert rig.light((7, 0)).verified
    assert "open_circuit" in rig.health()["dead_lights"]["right"]
    assert rig.health()["temperature_c"] > 20


@pytest.mark.parametrize("told", ["nan", "inf", "-inf", "1e999", "-"])
def test_a_sensor_without_a_reading_puts_no_light_out(
    line: tuple[EmulatedLineDriver, LightRig, list[str]], monkeypatch: pytest.MonkeyPatch, told: str
) -> None:
    emulator, rig, died = line
    monkeypatch.setattr(emulator, "_reply", answering("STATUS", f"STATUS temp_c={told} faults=-", emulator))
    rig.present()
    assert rig.health()["temperature_c"] is None
    assert rig.light((7, 0)).verified
    assert died == []


@pytest.mark.parametrize(
    "numbers",
    ["channels=0 full=255", "channels=3 full=0", "channels=3 full=65536", f"channels={10**12} full=1"],
)
def test_a_driver_of_no_or_endless_channels_makes_no_sense(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, numbers: str
) -> None:
    emulator = EmulatedLineDriver()
    monkeypatch.setattr(emulator, "_reply", answering("ID", f"ID acme 1 {numbers} serial=A7", emulator))
    with pytest.raises(DeviceError, match="which makes no sense"):
        open_rig(str(lights_file(tmp_path, emulator.path, "line")))
    emulator.close()


def answering(request: str, words: str, emulator: EmulatedLineDriver) -> Callable[[list[str]], str]:
    """An emulated driver's reply to one request, in other words than its own."""
    usual = emulator._reply
    return lambda asked: words if asked[0] == request else usual(asked)


def test_a_fault_between_two_captures_is_noticed_by_itself(
    line: tuple[EmulatedLineDriver, LightRig, list[str]],
) -> None:
    emulator, _, died = line
    emulator.fault("unplugged")
    assert until(lambda: died == ["left", "right"])


def test_a_short_silence_is_survived(line: tuple[EmulatedLineDriver, LightRig, list[str]]) -> None:
    emulator, rig, died = line
    emulator.fault("silent")
    before = emulator.requests
    assert until(lambda: emulator.requests > before)
    emulator.fault("none")
    assert rig.light((2, 0)).verified
    assert rig.health()["retries"] > 0
    assert not died


# --- devices that cannot be used ---


def test_what_is_no_light_says_so(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="There is no serial device /dev/ttyUSB77"):
        open_rig("/dev/ttyUSB77")
    with pytest.raises(BadInput, match="/dev/null is not a serial device"):
        open_rig("/dev/null")
    emulator = EmulatedLineDriver()
    rig = open_rig(emulator.path)
    with pytest.raises(DeviceError, match="are busy"):
        open_rig(emulator.path)
    rig.close()
    emulator.fault("silent")
    with pytest.raises(DeviceError, match="do not answer"):
        open_rig(str(lights_file(tmp_path, emulator.path, "dmx_usb_pro")))
    emulator.close()


@pytest.mark.skipif(os.geteuid() == 0, reason="root may open every device")
def test_no_permission_says_which_group() -> None:
    emulator = EmulatedLineDriver()
    os.chmod(emulator.path, 0)
    with pytest.raises(BadInput, match="dialout"):
        open_rig(emulator.path)
    emulator.close()
