"""The page of the results so far, of very many rows."""

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from experiments.page import write_page
from experiments.plan import read_plan
from experiments.table import ResultsTable
from experiments.version import code_version
from tests.experiments.experiment import plan_file

SCENES = 25_000
DEADLINE_S = 60.0
PAGE = Path(__file__).with_name("page_in_node.js")


@pytest.mark.slow
def test_a_hundred_thousand_rows_are_drawn(tmp_path: Path) -> None:
    text = f'controllers = ["heuristic", "simple"]\ntargets = ["cube", "satellite"]\nseeds = "1-{SCENES}"\n'
    plan = read_plan(plan_file(tmp_path, text))
    rng = np.random.default_rng(1)
    errors, images = rng.lognormal(-3.0, 1.5, len(plan)), rng.integers(1, 11, len(plan))
    table = ResultsTable(tmp_path / "out", plan.description, code_version())
    table.append(
        [
            {
                **cell.names(), "key": cell.key, "status": "converged" if error < 0.5 else "exhausted",
                "images": int(count), "kept": 1, "rotation_deg": float(error),
                "translation_fraction": float(error) / 100, "merit": 1.0, "seconds": 1.0,
            }
            for cell, error, count in zip(plan.cells(), errors, images, strict=True)
        ]
    )  # fmt: skip
    assert len(table.finished()) == 100_000
    table.close()
    page = write_page(tmp_path / "out", running=False)
    assert "when it was running" not in page.read_text()
    page = write_page(tmp_path / "out", running=True)
    assert "when it was running" in page.read_text()
    if shutil.which("node") is None:
        pytest.skip("node is not installed; the page's script was not run")
    done = subprocess.run(
        ["node", str(PAGE), str(page)], capture_output=True, text=True, check=True, timeout=DEADLINE_S
    )
    told = json.loads(done.stdout)
    assert told["drawn"] == 100_000
    assert told["words"].startswith("100000 rows")
