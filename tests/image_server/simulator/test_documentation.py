"""What docs/simulator.md says is what the simulator reads."""

import re
import tomllib
from pathlib import Path

import msgspec
import pytest

from image_server.simulator.material import Appearance
from image_server.simulator.scenario import SCENARIOS
from image_server.simulator.scenario_tables import Scenario
from stack.tables import Table

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def text(root: Path) -> str:
    """The page."""
    return (root / "docs" / "simulator.md").read_text()


def examples(text: str) -> list[dict[str, object]]:
    return [tomllib.loads(block) for block in re.findall(r"```toml\n(.*?)```", text, re.S)]


def test_the_examples_can_be_read(text: str) -> None:
    scenario, appearance = examples(text)
    msgspec.convert(scenario, Scenario)
    msgspec.convert(appearance, Appearance)


CHOSEN = {"description", "lights", "earth", "target"}
CHOSEN_FOR_CAMERA = {"focal_lengths_mm", "focuses_m"}
TOLD_BY_SIZE = {"range_m"}  # the target's, where a scenario does not say it


def test_the_numbers_of_a_scenario_are_the_defaults(text: str) -> None:
    scenario, _ = examples(text)
    defaults = msgspec.json.decode(msgspec.json.encode(Scenario()))
    for name, table in scenario.items():
        if name in CHOSEN:
            continue
        if not isinstance(table, dict):
            assert table == defaults[name], name
            continue
        for key, value in table.items():
            if key not in CHOSEN_FOR_CAMERA | TOLD_BY_SIZE and key != "material":
                assert value == defaults[name][key], key


def keys(table: type[Table]) -> set[str]:
    """Names of a table's keys, and of those of the tables in it."""
    found: set[str] = set()
    for field in msgspec.structs.fields(table):
        found.add(field.name)
        for part in (field.type, *getattr(field.type, "__args__", ())):
            for inner in (part, *getattr(part, "__args__", ())):
                if isinstance(inner, type) and issubclass(inner, Table):
                    found |= keys(inner)
    return found


def test_every_key_of_a_scenario_is_shown(text: str) -> None:
    missing = {key for key in keys(Scenario) if not re.search(rf"\b{key}\b", text)}
    assert not missing


@pytest.mark.parametrize("name", sorted(path.stem for path in SCENARIOS.glob("*.toml")))
def test_every_scenario_has_its_row_and_its_picture(text: str, root: Path, name: str) -> None:
    assert re.search(rf"\| `{name}` \|.*images/scenarios/{name}\.jpg", text)
    assert (root / "docs" / "images" / "scenarios" / f"{name}.jpg").is_file()
