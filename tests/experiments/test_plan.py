"""Plans: what they say, which cells they mean, and what is said of those that mean none."""

from pathlib import Path

import pytest

from bridge.errors import BadInput
from experiments.plan import Cell, read_plan
from experiments.units import unit_doubts
from experiments.warm_servers import simulator_of
from geometry.model import find_target
from tests.experiments.experiment import plan_file

FULL = """
controllers = ["heuristic", "simple"]
targets = ["cube", "satellite"]
scenarios = ["nominal", "eclipse"]
poses = "1-3"
seeds = "1-2"
max_iterations = 5
threshold = 0.8
"""


def stack(folder: Path, name: str) -> Path:
    made = folder / name
    made.mkdir(parents=True)
    (made / "stack.toml").write_text('kind = "basis"\n')
    return made


def test_cells_are_the_product_of_the_axes(tmp_path: Path) -> None:
    plan = read_plan(plan_file(tmp_path, FULL))
    cells = list(plan.cells())
    assert len(plan) == len(cells) == 2 * 2 * 2 * 3 * 2
    names = {tuple(cell.names().values()) for cell in cells}
    assert len(names) == len(cells)
    assert len({cell.key for cell in cells}) == len(cells)
    assert {cell.pose for cell in cells} == {1, 2, 3}
    assert plan.settings.max_iterations == 5
    assert plan.settings.threshold == 0.8


def test_controllers_of_a_scene_follow_each_other(tmp_path: Path) -> None:
    first, second = (read_plan(plan_file(tmp_path, FULL)).cell(number) for number in (0, 1))
    assert (first.scene, first.seed) == (second.scene, second.seed)
    assert first.controller != second.controller


def test_without_poses_the_seed_draws_the_scene(tmp_path: Path) -> None:
    plan = read_plan(plan_file(tmp_path, 'controllers = "simple"\ntargets = "cube"\nseeds = [4, 7]\n'))
    assert [cell.pose for cell in plan.cells()] == [4, 7]


def test_a_cell_is_the_same_in_a_larger_plan(tmp_path: Path) -> None:
    def keyed(text: str) -> dict[int, Cell]:
        return {cell.key: cell for cell in read_plan(plan_file(tmp_path, text)).cells()}

    small, large = keyed(FULL), keyed(FULL.replace("1-2", "1-9").replace('["cube"', '["fixture", "cube"'))
    assert small.keys() < large.keys()
    assert all(large[key].names() == cell.names() for key, cell in small.items())
    other = keyed(FULL.replace("0.8", "0.9"))
    assert not small.keys() & other.keys()


def test_a_file_s_numbers_are_in_the_plan_s_unit(tmp_path: Path) -> None:
    part = (find_target("cube").parent / "cube.cao").read_text()
    (tmp_path / "part.cao").write_text(part)
    text = 'controllers = "simple"\ntargets = ["part.cao", "cube"]\n'
    plain, small = (read_plan(plan_file(tmp_path, text + more)) for more in ("", 'unit = "mm"\n'))
    assert [cell.scene.unit for cell in small.cells()] == ["mm", "m"]
    assert plain.cell(0).key != small.cell(0).key
    assert plain.cell(1).key == small.cell(1).key
    assert unit_doubts(plain) == []
    assert "part.cao is 0.000" in unit_doubts(small)[0]
    across = [simulator_of(plan.cell(0)).model.diameter for plan in (plain, small)]
    assert across[1] == pytest.approx(across[0] / 1000.0)


def test_stacks_come_from_the_plan_and_from_the_command_line(tmp_path: Path) -> None:
    stack(tmp_path, "here/a")
    stack(tmp_path, "here/b")
    more = stack(tmp_path, "there/a")
    file = plan_file(tmp_path, 'controllers = ["simple"]\nstacks = ["here/*"]\n')
    plan = read_plan(file, [more], seeds="1-2")
    assert [cell.scene.stack for cell in plan.cells()][:3] == ["here/a", "b", "there/a"]
    assert all(cell.pose is None for cell in plan.cells())
    assert len(plan) == 6


def test_folders_may_have_the_signs_of_patterns_in_their_names(tmp_path: Path) -> None:
    stack(tmp_path, "old [1]/a [2]")
    stack(tmp_path, "old [1]/b")
    for stacks, count in (("*", 2), ("a [2]", 1)):
        text = f'controllers = ["simple"]\nstacks = ["{stacks}"]\n'
        assert len(read_plan(plan_file(tmp_path / "old [1]", text))) == count


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('controllers = ["heuristik"]\ntargets = ["cube"]\n', "'heuristik' is neither a file nor one of"),
        ('controllers = ["simple"]\ntargets = ["cub"]\n', "unknown target 'cub'"),
        ('controllers = ["simple"]\ntargets = ["cube"]\nscenarios = ["x"]\n', "no scenario 'x'"),
        ('controllers = ["simple"]\nstacks = ["nowhere"]\n', "'nowhere' is no folder with a stack.toml"),
        ('controllers = ["simple"]\n', "no cell: stacks and targets are empty"),
        ('controllers = []\ntargets = ["cube"]\n', "no cell: controllers are empty"),
        ('controllers = ["simple"]\ntargets = ["cube"]\nseeds = "5-1"\n', "seeds = '5-1' runs backwards"),
        ('controllers = ["simple"]\ntargets = ["cube"]\nseeds = []\n', "no cell: seeds are empty"),
        (
            'controllers = ["simple"]\ntargets = ["cube"]\nseeds = [9223372036854775808]\n',
            "seeds must be at most 9223372036854775807",
        ),
        ('controler = ["simple"]\n', "Did you mean controllers?"),
        ('[[conditions]]\nnam = "dark"\n', "unknown key `nam` in [conditions 1]. Did you mean name?"),
        ('controllers = ["simple"]\ntargets = ["cube"]\nseeds = "a"\n', "says no numbers"),
        ('controllers = ["simple"]\ntargets = ["cube"]\nseeds = "1,1"\n', "says a number twice"),
        ('controllers = ["simple"]\ntargets = ["cube"]\nmax_iterations = 0\n', "max_iterations must be"),
        ('controllers = ["simple"]\ntargets = ["cube"]\nthreshold = -1.0\n', "threshold must be a positive"),
        ('controllers = ["simple"]\ntargets = ["cube"]\ncolour = 1\n', "colour"),
        ('controllers = 3\ntargets = ["cube"]\n', "controllers"),
        ('kind = "dance"\ncontrollers = ["simple"]\ntargets = ["cube"]\n', "no kind 'dance'"),
        ('controllers = ["simple"]\nscenarios = ["nominal"]\n', "scenarios but no targets"),
        ('controllers = ["simple"]\ntargets = ["cube"]\nunit = "mm"\n', "a unit, but no target of a file"),
        ("controllers = [", "is not valid TOML"),
        ('[[conditions]]\nname = "a"\nambient_scale = -1.0\n', "ambient_scale"),
        ('[[conditions]]\nname = "a"\nlight_power = 1e10\n', "light_power"),
        ('[[conditions]]\nname = "a"\nmotion_px_per_s = [nan, 0.0]\n', "motion_px_per_s"),
    ],
)
def test_what_is_wrong_is_said_with_the_file(tmp_path: Path, text: str, says: str) -> None:
    file = plan_file(tmp_path, text)
    with pytest.raises(BadInput) as refused:
        read_plan(file)
    assert says in str(refused.value)
    assert file.name in str(refused.value)


def test_every_plan_of_the_project_can_be_read() -> None:
    plans = sorted((Path(__file__).resolve().parents[2] / "experiments" / "plans").glob("*.toml"))
    assert plans
    for file in plans:
        if "stacks are named after it" not in file.read_text():
            assert len(read_plan(file)) > 0
