"""Slow flow, averaged model, basin, verdicts and design: each against the full model."""

import math
from dataclasses import replace

import numpy as np
import pytest

import helimag as hm
from helimag.design import candidates, design, full_runs, robust_inputs
from helimag.engine import start_state
from helimag.orbits import (
    averaged_rates,
    averaging_error,
    basin,
    basin_dataset,
    slow_flow,
)
from helimag.orbits.averaged import SlowFlow, attraction, comes_to
from helimag.outcomes import BasinEnd, End, Verdict


@pytest.fixture(scope="module")
def orbit() -> hm.Orbit:
    return hm.find_orbit(hm.load("nose-first/fig3c").replaced({"drive.frequency": "2.5 Hz"}))


def flow_of(orbit: hm.Orbit, stages: int) -> SlowFlow:
    half = np.array([0.024, 0.024, 0.024])
    low, high = orbit.position - half, orbit.position + half
    return slow_flow(orbit, low=low, high=high, shape=(9, 9, 9), lag_stages=stages)


@pytest.fixture(scope="module")
def flow(orbit: hm.Orbit) -> SlowFlow:
    return flow_of(orbit, 4)


def test_slow_flow_vanishes_at_the_orbit(orbit: hm.Orbit, flow: SlowFlow) -> None:
    assert flow.settled.mean() > 0.95
    typical = np.median(np.linalg.norm(flow.velocity, axis=-1))
    assert np.linalg.norm(flow.at(orbit.position[None])) < 2e-3 * typical


def test_averaged_model_has_the_slow_rates_of_the_orbit(orbit: hm.Orbit, flow: SlowFlow) -> None:
    rates = averaged_rates(flow, orbit)
    assert rates[0].real == pytest.approx(orbit.rates[0].real, rel=0.15)
    assert abs(rates[0].imag) == pytest.approx(abs(orbit.rates[0].imag), rel=0.01)
    assert rates[2] == pytest.approx(orbit.rates[2], rel=0.02)


def test_lag_of_the_attitude_matters(orbit: hm.Orbit, flow: SlowFlow) -> None:
    """Without it the swings' decay is far off: the attitude lags behind a place that moves."""
    held = averaged_rates(flow_of(orbit, 0), orbit)
    assert abs(held[0].real / orbit.rates[0].real - 1.0) > 0.5
    place = orbit.position + np.array([0.006, 0.0, 0.003])
    error = averaging_error(flow, place, 900.0)
    assert error.time[-1] > 800.0
    assert error.worst < 5e-4
    assert np.ptp(error.full) > 2e-3


def test_basin_holds_the_orbits_neighbourhood_and_not_the_magnets(orbit: hm.Orbit) -> None:
    near = orbit.position + np.array([[-0.003], [0.003]])
    around = basin(orbit, low=near[0], high=near[1], shape=(2, 2, 2), duration=1200.0)
    assert around.captured.all()
    assert around.volume == pytest.approx(6e-3**3)
    above = np.array([orbit.position[0], orbit.position[1], 0.05]) + np.array([[-0.003], [0.003]])
    high = basin(orbit, low=above[0], high=above[1], shape=(2, 2, 2), duration=1200.0)
    assert not high.captured.any()


def test_basin_by_the_averaged_model_agrees(orbit: hm.Orbit, flow: SlowFlow) -> None:
    low, high = orbit.position - 0.004, orbit.position + 0.004
    fast = basin(orbit, low=low, high=high, shape=(3, 3, 3), flow=flow, duration=1800.0)
    assert fast.captured.all()
    assert fast.engine == "averaged"


def test_design_meets_the_wish_and_its_runs_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    for module, name, value in (
        (candidates, "SAMPLES", 16),
        (candidates, "SOLVED", 6),
        (robust_inputs, "CANDIDATES", 1),
        (robust_inputs, "POLISHES", 1),
        (full_runs, "LONGEST_RUN", 3000.0),
    ):
        monkeypatch.setattr(module, name, value)
    scenario = hm.load("nose-first/fig3c").replaced({"drive.frequency": "2.5 Hz"})
    limits = {"drive.frequency": (2.0, 3.2), "drive.pitch": (math.radians(6.0), math.radians(16.0))}
    result = design(scenario, speed=4.5e-4, limits=limits, runs=6)
    assert result.orbit.stable
    assert result.orbit.speed == pytest.approx(4.5e-4, rel=1e-5)
    assert result.verdicts == {Verdict.BOUNDED: 6}
    for path, (low, high) in limits.items():
        interval = result.intervals[path]
        here = result.scenario.drive.pitch if path == "drive.pitch" else result.scenario.drive.frequency
        assert low <= interval.low <= here - result.tolerances[path]
        assert here + result.tolerances[path] <= interval.high <= high
    assert "±" in result.text


def test_design_refuses_what_cannot_be() -> None:
    scenario = hm.load("nose-first/fig3c")
    with pytest.raises(hm.InputError, match="more inputs"):
        design(scenario, speed=1e-3, limits={"drive.pitch": (0.1, 0.2)})
    with pytest.raises(hm.InputError, match="lower and a higher"):
        design(scenario, limits={"drive.pitch": (0.2, 0.1)})


def test_a_basin_needs_runs_that_can_tell(orbit: hm.Orbit) -> None:
    low, high = orbit.position - 0.003, orbit.position + 0.003
    with pytest.raises(hm.InputError, match="12 turns"):
        basin(orbit, low=low, high=high, shape=(2, 2, 2), duration=2.0)


def test_a_real_release_may_fall_where_a_settled_attitude_is_captured(orbit: hm.Orbit) -> None:
    """Starts of both kinds against runs in the lab, from the place and the attitude that ``simulate`` begins with."""
    half = 0.36 * orbit.scenario.drive.distance
    box = {"low": orbit.position - half, "high": orbit.position + half, "shape": (2, 2, 2), "duration": 1800.0}
    settled, released = (basin(orbit, **box, attitude=attitude) for attitude in ("settled", "released"))
    begun = np.concatenate([released.places, np.tile(start_state(orbit.scenario)[3:], (8, 1))], axis=1)
    lasting = orbit.scenario.replaced({"run.duration": 3600.0})
    runs = hm.simulate_many([lasting] * 8, initial_states=begun)
    assert [run.verdict.inside for run in runs] == released.captured.tolist()
    assert (settled.captured & ~released.captured).any()
    assert "released as simulate releases" in released.text
    assert "attitude that it settles to" in settled.text
    assert basin_dataset(released).attrs["attitude"] == "released"


def test_the_averaged_model_knows_settled_attitudes_only(orbit: hm.Orbit, flow: SlowFlow) -> None:
    low, high = orbit.position - 0.004, orbit.position + 0.004
    with pytest.raises(hm.InputError, match="attitude must be settled by the averaged model"):
        basin(orbit, low=low, high=high, flow=flow, attitude="released")
    with pytest.raises(hm.InputError, match="attitude must be settled or released; got 'level'"):
        basin(orbit, low=low, high=high, attitude="level")  # type: ignore[arg-type]


def test_a_start_whose_run_breaks_down_meets_no_wall(orbit: hm.Orbit, monkeypatch: pytest.MonkeyPatch) -> None:
    strobed = attraction.strobed
    monkeypatch.setattr(
        attraction, "strobed", lambda *a, **k: [replace(run, status=End.NOT_FINITE) for run in strobed(*a, **k)]
    )
    found = basin(orbit, low=orbit.position - 0.003, high=orbit.position + 0.003, shape=(2, 2, 2), duration=10.0)
    assert set(found.ends) == {"broke down"}
    assert (basin_dataset(found).end == BasinEnd.BROKE_DOWN).all()


def test_coming_to_an_orbit_is_being_near_or_coming_nearer(orbit: hm.Orbit) -> None:
    quarters = np.repeat(np.arange(4.0), 40)

    def path(*distances: float) -> np.ndarray:
        return orbit.position + np.array(distances)[quarters.astype(int), None] * np.array([1.0, 0.0, 0.0])

    assert comes_to(orbit, path(0.1, 0.1, 0.1, 0.004))
    assert comes_to(orbit, path(0.1, 0.1, 0.1, 0.09))
    assert comes_to(orbit, path(0.001, 0.002, 0.0043, 0.0042))
    assert comes_to(orbit, path(0.00014, 0.00013, 0.00012, 0.00013))
    assert not comes_to(orbit, path(0.001, 0.002, 0.0041, 0.0042))
    assert not comes_to(orbit, path(0.1, 0.1, 0.1, 0.097))
    assert not comes_to(orbit, path(0.2, 0.15, 0.01, 0.01))
