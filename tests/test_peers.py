"""What `make bench` measures is the same problem: its equations beside the engine's kernel, its tolerances in order."""

import math
import sys
from pathlib import Path

import numpy as np
import pytest

import helimag as hm
import oracles

sys.path.insert(0, str(Path(__file__).parent.parent / "benchmarks" / "peers"))
from checks import difference, random_states
from codes import Code
from equations import rates_of, unit_of
from measure import Tuning

PRESET = "paper/fig3c"


def test_the_equations_are_the_kernels_on_random_states():
    scenario = hm.load(PRESET)
    rates = rates_of(scenario)
    assert difference(scenario, lambda t, y: np.array(rates(t, *y))) < 1e-14


def test_another_drive_is_another_problem():
    """The comparison can fail: a hundred thousandth of the frequency shows."""
    scenario = hm.load(PRESET)
    other = rates_of(scenario.replaced({"drive.frequency": scenario.drive.frequency * (1.0 + 1e-5)}))
    assert difference(scenario, lambda t, y: np.array(other(t, *y))) > 1e-6


def test_the_equations_are_those_of_the_tests_own_model():
    """Written apart from both: rotation matrices by Rodrigues, drag by quadrature."""
    case = oracles.case()
    scenario = oracles.scenario_of(case)
    mine, theirs = rates_of(scenario), oracles.right_hand_side(case)
    times, states = random_states(scenario)
    scale = np.array([unit_of(scenario)] * 3 + [1.0] * 4)
    found = np.array([np.array(mine(t, *(y / scale))) * scale for t, y in zip(times, states, strict=True)])
    expected = np.array([theirs(t, y) for t, y in zip(times, states, strict=True)])
    assert np.abs(found - expected).max(axis=0) == pytest.approx(0.0, abs=1e-9 * np.abs(expected).max())


def test_tolerances_are_tuned_to_the_error_from_below():
    """A code whose error is ten times its tolerance, but for a lucky one, and which breaks down where it is loose."""

    def run(_, tolerance):
        if tolerance > 1e-4:
            return np.full(3, math.nan)
        return np.array([1e-12 if tolerance == 1e-5 else 10.0 * tolerance, 0.0, 0.0])

    tuning = Tuning(Code("made up", run), np.zeros(3))
    tuning.scan(1e-8)
    assert tuning.error(1e-3) == math.inf
    for target in (1e-6, 3e-7):
        tolerance = tuning.tolerance_for(target)
        assert 0.5 * target < tuning.error(tolerance) <= target
    assert tuning.tolerance_for(1e-16) == 0.0
