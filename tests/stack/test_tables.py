"""TOML files as typed tables: what is written is read again, what is misspelt is named."""

import tomllib
from pathlib import Path
from typing import Literal

import pytest

from bridge.errors import BadInput
from stack.tables import Table, as_table, read_toml, toml_text


def test_toml_text_reads_back() -> None:
    values = {
        "kind": "frames", "none": None, "x": 1 / 3, "on": True,
        "camera": {"k": [0.1, -2.0], "deep": {"s": 'ä"\\'}},
        "frames": [{"image": "a.png", "n": 1}, {"image": "b.png", "pose": {"t": [1.0, 2.0]}}],
    }  # fmt: skip
    read = tomllib.loads(toml_text(values))
    assert read == {key: value for key, value in values.items() if value is not None}


def test_a_byte_order_mark_and_line_ends_of_windows_are_no_matter(tmp_path: Path) -> None:
    file = tmp_path / "a.toml"
    file.write_bytes(b"\xef\xbb\xbfx = 1\r\ny = 2\r\n")
    assert read_toml(file, "file") == {"x": 1, "y": 2}


@pytest.mark.parametrize(("encoding", "line"), [("utf-16", 1), ("latin-1", 2)])
def test_a_file_in_another_encoding_is_told_with_the_line(tmp_path: Path, encoding: str, line: int) -> None:
    file = tmp_path / "a.toml"
    file.write_text("x = 1\ny = 'ä'\n", encoding=encoding)
    with pytest.raises(
        BadInput, match=rf"a\.toml is not valid TOML: .* UTF-8, from line {line} on\. Save it"
    ):
        read_toml(file, "file")


class Lamp(Table, frozen=True):
    colour: Literal["red", "green"] = "red"


class Room(Table, frozen=True):
    width_m: float = 1.0
    lamp: Lamp | None = None
    rows: tuple[tuple[Lamp, ...], ...] = ()


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"widthm": 1.0}, "unknown key `widthm`. Did you mean width_m?"),
        ({"zzz": 1.0}, "unknown key `zzz`. There are lamp, rows, width_m."),
        ({"lamp": {"color": "red"}}, "unknown key `color` in [lamp]. Did you mean colour?"),
        ({"lamp": {"colour": "gren"}}, "unknown word 'gren' in [lamp.colour]. Did you mean green?"),
        ({"rows": [[{"color": "red"}]]}, "Did you mean colour?"),
        ({"width_m": "wide"}, "expected `float`, got `str` in [width_m]."),
    ],
)
def test_a_misspelt_key_or_word_is_named_with_what_may_be_meant(values: dict[str, object], said: str) -> None:
    with pytest.raises(BadInput) as refused:
        as_table(values, Room, Path("room.toml"))
    assert str(refused.value).startswith("room.toml: ")
    assert str(refused.value).endswith(said)
