"""The notebook in examples/ runs as it is written, and shows what it says."""

import json
from pathlib import Path
from typing import Any

import pytest

NOTEBOOK = Path(__file__).parent.parent / "examples" / "notebook.ipynb"


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> Any:
    nbclient = pytest.importorskip("nbclient")
    nbformat = pytest.importorskip("nbformat")
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    place = {"metadata": {"path": str(tmp_path_factory.mktemp("notebook"))}}
    return nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3", resources=place).execute()


def shown(notebook: Any, source: str) -> str:
    """What the cell that ends in a line puts below it, of every form."""
    cell = next(cell for cell in notebook.cells if cell.source.endswith(source))
    return json.dumps(cell.outputs)


def test_scenario_run_and_orbit_show_themselves_as_tables(done: Any) -> None:
    scenario = shown(done, '"2.5 Hz"})\nscenario')
    assert "<table" in scenario
    assert "drive.frequency 2.5 Hz" in scenario
    run = shown(done, "simulate(scenario)\nrun")
    assert "<table" in run
    assert "bounded" in run
    orbit = shown(done, "\norbit")
    assert "<table" in orbit
    assert "stable" in orbit


def test_figures_are_drawn(done: Any) -> None:
    assert "image/png" in shown(done, "draw_run(run)")
    assert "image/png" in shown(done, 'reason}")')


def test_batch_prints_a_verdict_a_pitch(done: Any) -> None:
    lines = shown(done, '{each.verdict}")')
    assert lines.count("gain") == 7
    assert lines.count("bounded") >= 4


def test_committed_without_outputs() -> None:
    cells = json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]
    assert all(cell["outputs"] == [] for cell in cells if cell["cell_type"] == "code")
