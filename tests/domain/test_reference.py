"""docs/controllers.md lists everything that a strategy may be written in."""

import re
from pathlib import Path

import pytest

THEORY = ("acquisition", "procedures", "approach")


def shape(term: str) -> tuple[str, int]:
    """Name and number of arguments of a term as it is written."""
    name, opened, inside = term.partition("(")
    depth, commas = 0, 0
    for character in inside.rpartition(")")[0]:
        depth += (character in "([") - (character in ")]")
        commas += character == "," and depth == 0
    return name.strip(), commas + 1 if opened else 0


def heads(theory: str, declaration: str) -> set[tuple[str, int]]:
    """Shapes of what the theory declares so, as in ``prim_action(keep(_))``."""
    found = re.findall(rf"^{declaration}\((\w+(?:\(.*?\))?)(?:,|\)\.)", theory, re.MULTILINE)
    return {shape(term) for term in found}


def declared(root: Path) -> set[tuple[str, int]]:
    """Names and arities of all procedures, tests, fluents and actions."""
    theory = "".join((root / "domain" / f"{name}.pl").read_text() for name in THEORY)
    return heads(theory, "proc") | heads(theory, "(?:fun_fluent|prim_action|exog_action)")


def imported(root: Path) -> set[tuple[str, int]]:
    """Names and arities of the predicates that the theory imports."""
    theory = "".join((root / "domain" / f"{name}.pl").read_text() for name in THEORY)
    found = set()
    for module in re.findall(r"^:- use_module\((reasoning/\w+)\)", theory, re.MULTILINE):
        head = (root / "domain" / f"{module}.pl").read_text().split("]).")[0]
        found |= {(name, int(arity)) for name, arity in re.findall(r"(\w+)/(\d)", head)}
    return found


def listed(root: Path) -> set[tuple[str, int]]:
    """Names and arities in the first column of the page's tables, and of the actions from outside."""
    page = (root / "docs" / "controllers.md").read_text()
    cells = re.findall(r"^\| (`[^|]*) \|", page, re.MULTILINE)
    cells += re.findall(r"^From outside come (.*?)\n\n", page, re.MULTILINE | re.DOTALL)
    return {shape(term) for cell in cells for term in re.findall(r"`(\w[^`]*)`", cell)}


INNER = {"step", "new_scene"}
"""Parts of axioms, of no use to a strategy."""


def test_every_name_of_the_theory_is_in_the_reference(root: Path) -> None:
    names = {name for name, _ in declared(root) | imported(root)}
    assert len(names) > 80
    assert sorted(names - {name for name, _ in listed(root)} - INNER) == []


def test_each_is_shown_with_the_arguments_that_it_takes(root: Path) -> None:
    own, helpers = declared(root), imported(root)
    shown, names = listed(root), {name for name, _ in own}
    assert {one for one in shown if one[0] in names} - helpers == {one for one in own if one[0] not in INNER}
    short = {(name, 0) for name, _ in helpers}  # `device_lights(Device, Lights)`, `device_shutters`
    known = {name for name, _ in helpers} - names
    assert {one for one in shown if one[0] in known} - helpers - short == set()


@pytest.mark.parametrize("name", ["converged", "take_image", "light_fault", "line_support", "look_ahead"])
def test_names_of_each_kind_are_found(root: Path, name: str) -> None:
    assert name in {name for name, _ in declared(root)}


def test_the_lights_named_are_the_simulators_and_the_mocks(root: Path) -> None:
    from bridge.mock_physics import describe
    from image_server.simulator.scenario_tables import DEFAULT_LIGHTS

    row = re.search(
        r"^\| names of lights \| (.*?) on the simulator", (root / "docs/controllers.md").read_text(), re.M
    )
    assert row is not None
    named = re.findall(r"`(\w+)`", row[1])[1:]
    assert named == [light.name for light in DEFAULT_LIGHTS] == [light.name for light in describe().lights]
