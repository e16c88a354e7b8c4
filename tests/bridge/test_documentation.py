"""What docs/protocol.md says is what the code does."""

import ast
import json
import re
from pathlib import Path
from typing import get_args

import msgspec
import pytest

from bridge.client import Client
from bridge.image_messages import IMAGE_OPERATIONS
from bridge.messages import EVENT_ARGS, EventName
from bridge.mock_script import apply_script
from bridge.mocks import MockImageServer, MockVisionServer
from bridge.vision_messages import VISION_OPERATIONS, EstimateResult
from vision_server.serve.parameters import CHECKS, SEED_POSE

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def text(root: Path) -> str:
    """The page."""
    return (root / "docs" / "protocol.md").read_text()


def test_every_operation_and_field_is_described(text: str) -> None:
    for operations in (IMAGE_OPERATIONS, VISION_OPERATIONS):
        for op, (args, result) in operations.items():
            assert f"| `{op}` |" in text
            for field in getattr(args, "__struct_fields__", ()):
                assert f"`{field}`" in text
            for field in getattr(result, "__struct_fields__", ()):
                assert f"`{field}`" in text or f'"{field}"' in text, f"{op} tells {field}"


def test_every_parameter_is_described(text: str) -> None:
    table = text.partition("#### Parameters")[2].partition("####")[0]
    assert [name for name in (*CHECKS, SEED_POSE) if f"`{name}`" not in table] == []


def test_every_error_code_is_described(text: str, root: Path) -> None:
    rooms = ("bridge", "image_server", "vision_server")
    sources = "".join(path.read_text() for room in rooms for path in (root / room).rglob("*.py"))
    raised = set(re.findall(r'ProtocolError\(\s*"(\w+)"', sources)) - {"bad_reply"}
    assert len(raised) > 5
    for code in raised | {"bad_input", "device_error", "unsupported", "timeout", "refused"}:
        assert f"| `{code}` |" in text


def test_every_event_is_described_with_what_it_tells(text: str) -> None:
    table = text[text.index("| `event` | `args` |") :]
    rows = dict(re.findall(r"^\| `(\w+)` \| (.*) \|$", table, re.MULTILINE))
    assert set(EVENT_ARGS) == set(get_args(EventName))
    for event, args in EVENT_ARGS.items():
        for field in args.__struct_fields__:
            assert f"`{field}`" in rows[event]


def test_the_python_examples_are_python(text: str) -> None:
    examples = re.findall(r"```python\n(.*?)```", text, re.S)
    assert len(examples) >= 4
    for example in examples:
        ast.parse(example)


def test_the_client_example_works(text: str) -> None:
    example = next(e for e in re.findall(r"```python\n(.*?)```", text, re.S) if "pixels,)" in e)
    with MockImageServer() as mock:
        names: dict[str, object] = {}
        exec(example.replace("ipc:///tmp/image", mock.endpoint), names)
    assert getattr(names["pixels"], "shape", None) == (48, 64)


def test_the_script_example_works(text: str) -> None:
    block = text[text.index('    {"capture":') : text.index("`health` then tells")]
    with MockVisionServer() as mock:
        apply_script(mock, json.loads(block))
        with Client(mock.endpoint, timeout_s=60) as client:
            best = msgspec.convert(client.request("best")[0], EstimateResult)
            assert best.pose is None
