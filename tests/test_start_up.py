"""What a short command does not wait for: libraries that it has no use for."""

import subprocess
import sys

import numpy as np
import pytest
from scipy.integrate import DOP853

import helimag as hm
from helimag.engine import tableau

HEAVY = ("xarray", "pandas", "dask", "pint", "scipy", "matplotlib", "h5py", "trimesh")


@pytest.mark.parametrize("words", [("--help",), ("simulate", "nose-first/fig3c", "--duration=5 s", "--no-orbit")])
def test_a_short_command_imports_nothing_heavy(words):
    code = (
        "import sys; from helimag.cli import main\n"
        "try: main()\n"
        f"except SystemExit: pass\nprint([name for name in {HEAVY} if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True, timeout=120, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


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
