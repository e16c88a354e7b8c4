"""Kinds of cells beside sessions, and comparisons of each."""

import json
import os
import re
import tempfile
from pathlib import Path

import pytest
import trimesh

from bridge.errors import BadInput
from bridge.messages import Settings
from experiments import comparison_folder
from experiments.comparison_folder import compare_table
from experiments.computing import rows_of
from experiments.description import DESCRIPTION, read_description
from experiments.page import write_page
from experiments.plan import Cell, read_plan
from experiments.table import JOURNAL, ResultsTable, read_rows
from experiments.version import code_version
from image_server.simulator.scenario import SCENARIOS
from image_server.simulator.simulator import Simulator
from tests.experiments.experiment import computed, plan_file

SMALL = "width = 320\nheight = 240\nfx = 400.0\nfy = 400.0\ncx = 159.5\ncy = 119.5\n"


def small(folder: Path, scenario: str) -> str:
    """The line of a plan that names a scenario of the project with a small camera; it tells none itself."""
    text = (SCENARIOS / f"{scenario}.toml").read_text()
    assert "[camera]" not in text
    (folder / "small.toml").write_text(f"{text}\n[camera]\n{SMALL}")
    return 'scenarios = ["small.toml"]\n'


def cells(folder: Path, text: str) -> list[Cell]:
    return list(read_plan(plan_file(folder, text)).cells())


def table_of(folder: Path, text: str) -> Path:
    return computed(plan_file(folder, text), folder / "out")


def test_an_estimate_of_three_random_images(tmp_path: Path) -> None:
    text = 'kind = "estimate"\ncontrollers = ["random-3", "middle-1"]\ntargets = ["cube"]\nseeds = "2"\n'
    first, second = rows_of(cells(tmp_path, text), code_version())
    assert (first["images"], second["images"]) == (3, 1)
    assert first["status"] == "estimated"
    assert first["rotation_deg"] < 1.0
    assert first["score"] > 0.5
    assert first["normalised_error_squared"] > 0.0
    again = rows_of(cells(tmp_path, text), code_version())[0]
    assert again["rotation_deg"] == pytest.approx(first["rotation_deg"], rel=1e-9)


def test_a_pose_number_is_the_same_scene_with_any_seed(tmp_path: Path) -> None:
    from experiments.warm_servers import simulator_of

    text = 'kind = "estimate"\ncontrollers = ["middle-1"]\ntargets = ["cube"]\nposes = "5"\nseeds = "1-2"\n'
    one, two = (simulator_of(cell).true_pose for cell in cells(tmp_path, text))
    assert (one.translation == two.translation).all()
    by_seed = cells(tmp_path, text.replace('poses = "5"', "").replace("1-2", "5"))
    assert (simulator_of(by_seed[0]).true_pose.translation == one.translation).all()


def test_cells_of_a_scene_share_a_simulator_that_begins_anew(tmp_path: Path) -> None:
    from experiments.warm_servers import simulator_of

    text = 'kind = "estimate"\ncontrollers = ["middle-1", "middle-2"]\ntargets = ["cube"]\nseeds = "1-2"\n'
    middle = Settings(lights=(4, 4, 4), shutter_s=1 / 60, aperture=4.0)
    found = []
    for cell in cells(tmp_path, text):
        simulator = simulator_of(cell)
        fresh = Simulator("cube", "nominal", cell.seed)
        for _ in range(2):
            assert (simulator.capture(middle).pixels == fresh.capture(middle).pixels).all()
        found.append(simulator)
    assert found[0] is found[1] is not found[2]


def test_conditions_change_the_light(tmp_path: Path) -> None:
    from experiments.warm_servers import simulator_of

    text = (
        'kind = "estimate"\ncontrollers = ["middle-1"]\ntargets = ["cube"]\n'
        '[[conditions]]\nname = "dark"\nambient_scale = 0.0\n'
        '[[conditions]]\nname = "harsh"\nambient_scale = 20.0\n'
    )
    dark, harsh = (simulator_of(cell).radiance((0, 0, 0)).max() for cell in cells(tmp_path, text))
    assert dark < harsh / 10


@pytest.mark.slow
def test_edge_maps_know_the_outline(tmp_path: Path) -> None:
    text = 'kind = "edges"\ncontrollers = ["em", "mertens"]\ntargets = ["cube"]\n'
    text += small(tmp_path, "nominal")
    out = table_of(tmp_path, text)
    assert min(read_rows(out)["best_f"].to_pylist()) > 0.8
    compare_table(out, tmp_path / "compared")
    assert "best_f" in (tmp_path / "compared" / "comparison.md").read_text()


@pytest.mark.slow
def test_an_approach_counts_its_hold_points(tmp_path: Path) -> None:
    text = 'kind = "approach"\ncontrollers = ["heuristic"]\ntargets = ["fixture"]\n'
    text += small(tmp_path, "approach")
    (row,) = rows_of(cells(tmp_path, text), code_version())
    assert row["status"] == "converged"
    assert row["holds"] == row["fixed"] == 7


def made_up(folder: Path, *controllers: str) -> Path:
    """A table of ten scenes where one strategy is right and the other is wrong in every second one."""
    named = json.dumps(controllers or ("heuristic", "simple"))
    text = f'controllers = {named}\ntargets = ["cube"]\nposes = "1-10"\nseeds = "1-3"\n'
    plan = read_plan(plan_file(folder, text))
    rows = []
    for cell in plan.cells():
        wrong = cell.controller == "simple" and cell.pose is not None and cell.pose % 2 == 0
        rows.append(
            {
                **cell.names(), "key": cell.key, "status": "exhausted" if wrong else "converged",
                "images": 10 if wrong else 2, "kept": 2, "rotation_deg": 5.0 if wrong else 0.1,
                "translation_fraction": 0.001, "merit": 0.5, "seconds": 1.0,
            }
        )  # fmt: skip
    table = ResultsTable(folder / "out", plan.description, code_version())
    table.append(rows)
    table.close()
    return folder / "out"


def test_a_comparison_says_who_is_better_where_and_how_sure(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    compare_table(made_up(tmp_path), tmp_path / "compared")
    text = (tmp_path / "compared" / "comparison.md").read_text()
    row = next(line for line in text.splitlines() if line.startswith("| heuristic − simple | right"))
    assert "| 30 in 10 | +50.0 [" in row
    assert row.endswith("| 15 : 0, p = 6.1e-05 | more |")
    assert text.count(f"code {code_version()}") >= 5  # every table says which code, and n
    assert text.count("n = 60 rows") >= 5
    deciding = text[text.index("## Cells that decide") :]
    assert "pose 2 |" in deciding
    assert "pose 1 |" not in deciding
    for name in ("success", "images-to-trust", "errors", "differences", "scenes"):
        for ending in ("png", "svg"):
            assert (tmp_path / "compared" / f"{name}.{ending}").stat().st_size > 1000
    shown = capsys.readouterr().out
    assert "heuristic − simple" in shown
    assert "…" not in shown  # no cell is cut, however narrow the terminal


def test_of_one_strategy_no_empty_table_is_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    compare_table(made_up(tmp_path, "simple"), tmp_path / "compared")
    text = (tmp_path / "compared" / "comparison.md").read_text()
    assert "## Strategies" in text and "## Scenes" in text
    assert "## Paired" not in text and "## Power" not in text and "## Cells that decide" not in text
    assert "Paired" not in capsys.readouterr().out


def test_scenes_without_a_true_pose_are_neither_right_nor_false(tmp_path: Path) -> None:
    out = made_up(tmp_path)
    lines = (out / JOURNAL).read_text().splitlines(keepends=True)
    errors = re.compile('("rotation_deg"|"translation_fraction"):[0-9.]+')
    for number, line in enumerate(lines):
        if '"pose":3,' in line:
            untold = errors.sub(r'\1:null,"rms_px":1.0', line, 1)
            lines[number] = untold.replace('"stack":null', '"stack":"mine"')
    (out / JOURNAL).write_text("".join(lines))
    compare_table(out, tmp_path / "compared")
    text = (tmp_path / "compared" / "comparison.md").read_text()
    assert "Of 6 rows no true pose is known" in text
    assert "| heuristic − simple | right | 27 in 9 | +" in text
    assert "| heuristic − simple | trusted | 30 in 10 | +" in text
    assert re.search(r"\| heuristic \| 30 \| 100\.0 [^|]*\|[^|]*\| 100\.0 [^|]*\| 0\.0 ", text)


@pytest.mark.slow
def test_a_page_has_its_tables_and_pictures_renewed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = tmp_path / "page.md"
    page.write_text(
        "Before.\n<!-- plan: Strategies -->\nSTALE\n<!-- end -->\n![it](plan-success.png)\n"
        "<!-- plan: Paired differences, nobody -->\n<!-- end -->\n"
        "<!-- other: Strategies -->\nkept\n<!-- end -->\n"
    )
    out = made_up(tmp_path)
    for _ in range(2):  # renewed again, it is the same page
        compare_table(out, tmp_path / "compared", page=page)
        monkeypatch.setattr(comparison_folder, "draw_all", lambda *_: [])  # they are there
        text = page.read_text()
        assert "STALE" not in text
        assert "kept" in text
        assert "| heuristic | 30 |" in text
        assert text.count(f"code {code_version()}") == 2
        assert "heuristic − simple" not in text
        assert text.startswith("Before.")
    assert (tmp_path / "plan-success.png").stat().st_size > 1000
    page.write_text("<!-- plan: Nothing -->\n<!-- end -->\n")
    with pytest.raises(BadInput, match="asks for a table 'Nothing'"):
        compare_table(out, tmp_path / "compared", page=page)
    page.write_text("no place\n")
    with pytest.raises(BadInput, match="no place for tables of plan"):
        compare_table(out, tmp_path / "compared", page=page)


def test_the_page_holds_every_row_and_refreshes_itself_while_it_runs(tmp_path: Path) -> None:
    out = made_up(tmp_path)
    running = write_page(out, running=True).read_text()
    assert 'http-equiv="refresh"' in running
    assert "n = 60 rows" in running
    assert 'http-equiv="refresh"' not in write_page(out, running=False).read_text()
    description = out / DESCRIPTION
    description.write_text(description.read_text().replace('"cells": 60', '"cells": 6'))
    assert '<div style="width: 100.0%">' in write_page(out, running=False).read_text()


def test_a_row_tells_how_to_run_its_cell_again(tmp_path: Path) -> None:
    from experiments.deciding import cell_of

    out = made_up(tmp_path)
    for row in read_rows(out).to_pylist():
        assert cell_of(row, read_description(out)).key == row["key"]
    trimesh.creation.box([300, 200, 150]).export(tmp_path / "part.stl")
    text = 'controllers = ["simple"]\ntargets = ["part.stl"]\nunit = "mm"\n'
    plan = read_plan(plan_file(tmp_path, text, "mm.toml"))
    (cell,) = plan.cells()
    assert cell_of({**cell.names(), "key": cell.key}, plan.description).key == cell.key


@pytest.mark.slow
def test_reports_of_the_cells_that_decide_are_made_and_linked(tmp_path: Path) -> None:
    text = (
        'controllers = ["auto_exposed", "fixed"]\ntargets = ["cube"]\nseeds = "1"\n'
        f"{small(tmp_path, 'eclipse')}"
        'max_iterations = 2\n[[conditions]]\nname = "dark"\nambient_scale = 0.0\nlight_power = 0.003\n'
    )
    out = table_of(tmp_path, text)
    assert [row["rotation_deg"] is None for row in read_rows(out).to_pylist()] == [False, True]
    workers = f"lights-and-camera-worker-{os.getpid()}-*"
    before = set(Path(tempfile.gettempdir()).glob(workers))
    compare_table(out, tmp_path / "compared", reports=1)
    assert set(Path(tempfile.gettempdir()).glob(workers)) <= before
    written = (tmp_path / "compared" / "comparison.md").read_text()
    links = re.findall(r"\[report\]\((.*?)\)", written[written.index("## Cells that decide") :])
    pages = [(tmp_path / "compared" / link).read_text() for link in links]
    assert "auto_exposed" in pages[0]
    assert "fixed" in pages[1]
    assert len(pages) == 2
