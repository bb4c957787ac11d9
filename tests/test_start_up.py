"""What a short command does not wait for: libraries that it has no use for."""

import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import DOP853

import helimag as hm
from helimag.cli import _shared
from helimag.engine import tableau

HEAVY = ("xarray", "pandas", "dask", "pint", "scipy", "matplotlib", "h5py", "trimesh")
UNUSED = {  # by the command's first word
    "--version": ("markdown_it", "helimag.physics"),
    "--help": ("helimag.physics",),
    "simulate": ("rich.progress", "helimag.physics.walls", "helimag.physics.contact"),
}


@pytest.mark.parametrize(
    "words", [("--version",), ("--help",), ("simulate", "nose-first/fig3c", "--duration=5 s", "--no-orbit")]
)
def test_a_short_command_imports_nothing_heavy(words):
    """Nor does Python look for garbage among all that was imported when it ends: it would take as long as the run."""
    names = HEAVY + UNUSED[words[0]]
    code = (
        "import gc, sys; from helimag.cli import main\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        "left = len(gc.get_objects()) if gc.get_freeze_count() > 0 else None\n"
        f"print([name for name in {names} if name in sys.modules] + [left] * (left is None or left > 1000))"
    )
    done = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True, timeout=120, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_a_bar_appears_after_a_second_and_counts_from_the_beginning(monkeypatch, capsys):
    now = SimpleNamespace(seconds=50.0)
    monkeypatch.setattr(_shared, "time", SimpleNamespace(monotonic=lambda: now.seconds))
    monkeypatch.setenv("FORCE_COLOR", "1")  # as on a terminal
    with _shared.progress_bar("swimming") as report:
        report(0.1)
        assert capsys.readouterr().err == ""
        now.seconds += 7.0
        report(0.5)
        now.seconds += 1.0
        report(0.6)
    said = capsys.readouterr().err
    assert "swimming" in said
    assert "0:00:08" in said


@pytest.mark.parametrize("name", ["A", "B", "C", "E3", "E5"])
def test_the_coefficients_are_scipys(name):
    assert np.array_equal(getattr(tableau, name), getattr(DOP853, name))
    assert DOP853.n_stages == tableau.STAGES


def test_a_run_is_the_same_before_and_after_it_is_labelled():
    run = hm.simulate(hm.load("nose-first/fig3c"), duration=20.0)
    early = run.judgement, run.final_state.copy(), dict(run.attributes)
    dataset = run.dataset
    assert hm.Trajectory(dataset).judgement == early[0]
    assert np.array_equal(run.final_state, early[1])
    assert dict(dataset.attrs) == early[2]
    dataset.attrs["name"] = "renamed"
    assert run.attributes["name"] == "renamed"
