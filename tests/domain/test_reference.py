"""docs/controllers.md lists everything that a strategy may be written in."""

import re
from pathlib import Path

import pytest

THEORY = ("acquisition", "procedures", "approach")


def declared(root: Path) -> set[str]:
    """Names of all procedures, tests, fluents and actions, and of the predicates that the theory imports."""
    theory = "".join((root / "domain" / f"{name}.pl").read_text() for name in THEORY)
    names = set(re.findall(r"^proc\((\w+)", theory, re.MULTILINE))
    names |= set(re.findall(r"^(?:fun_fluent|prim_action|exog_action)\((\w+)", theory, re.MULTILINE))
    for module in re.findall(r"^:- use_module\((reasoning/\w+)\)", theory, re.MULTILINE):
        head = (root / "domain" / f"{module}.pl").read_text().split("]).")[0]
        names |= set(re.findall(r"(\w+)/\d", head))
    return names


def listed(root: Path) -> set[str]:
    """Names in the first column of the page's tables, and the actions from outside."""
    page = (root / "docs" / "controllers.md").read_text()
    cells = re.findall(r"^\| (`[^|]*) \|", page, re.MULTILINE)
    cells += re.findall(r"^From outside come (.*)", page, re.MULTILINE)
    return {name for cell in cells for name in re.findall(r"`(\w+)", cell)}


INNER = {"step", "new_scene"}
"""Parts of axioms, of no use to a strategy."""


def test_every_name_of_the_theory_is_in_the_reference(root: Path) -> None:
    names = declared(root)
    assert len(names) > 80
    assert sorted(names - listed(root) - INNER) == []


@pytest.mark.parametrize("name", ["converged", "take_image", "only_light", "light_fault", "line_support"])
def test_names_of_each_kind_are_found(root: Path, name: str) -> None:
    assert name in declared(root)


def test_the_lights_named_are_the_simulators_and_the_mocks(root: Path) -> None:
    from bridge.mock_physics import describe
    from image_server.simulator.light import DEFAULT_LIGHTS

    row = re.search(
        r"^\| names of lights \| (.*?) on the simulator", (root / "docs/controllers.md").read_text(), re.M
    )
    assert row is not None
    named = re.findall(r"`(\w+)`", row[1])[1:]
    assert named == [light.name for light in DEFAULT_LIGHTS] == [light.name for light in describe().lights]
