"""TOML files that are written read back."""

import tomllib

from stack.tables import toml_text


def test_toml_text_reads_back() -> None:
    values = {
        "kind": "frames", "none": None, "x": 1 / 3, "on": True,
        "camera": {"k": [0.1, -2.0], "deep": {"s": 'ä"\\'}},
        "frames": [{"image": "a.png", "n": 1}, {"image": "b.png", "pose": {"t": [1.0, 2.0]}}],
    }  # fmt: skip
    read = tomllib.loads(toml_text(values))
    assert read == {key: value for key, value in values.items() if value is not None}
