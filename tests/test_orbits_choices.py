"""Choices that the commands about orbits make: boxes, seeds, nodes to compare at, branches to follow."""

import math
from dataclasses import replace

import numpy as np
import pytest

import helimag as hm
from helimag import orbits
from helimag.orbits import OrbitComparison, OrbitStatus
from helimag.orbits.averaged import paths


@pytest.fixture(scope="module")
def orbit() -> hm.Orbit:
    return hm.find_orbit(hm.load("nose-first/fig3c").replaced({"drive.frequency": "2.5 Hz"}))


def test_a_box_lies_around_its_orbit(orbit: hm.Orbit) -> None:
    low, high = orbits.box_around(orbit, reach=0.02)
    assert (low + high) / 2.0 == pytest.approx(orbit.position)
    assert high - low == pytest.approx([0.04] * 3)
    low, high = orbits.box_around(orbit)
    assert high - low == pytest.approx([2.0 * 0.36 * 0.15] * 3)
    with pytest.raises(hm.InputError, match="reach must be greater than zero; got -1 m"):
        orbits.box_around(orbit, reach=-1.0)
    with pytest.raises(hm.InputError, match="reach must be greater than zero"):
        orbits.box_around(orbit, reach=math.nan)
    with pytest.raises(hm.InputError, match="lost step"):
        orbits.box_around(hm.Orbit(scenario=orbit.scenario, status=OrbitStatus.LOST_STEP))


def test_a_map_begins_at_the_scenario_itself_where_that_is_on_it(orbit: hm.Orbit) -> None:
    pitch = orbit.scenario.drive.pitch
    ranges = {"drive.pitch": (pitch, pitch + 0.1), "drive.frequency": (2.4, 2.6)}
    (seed,) = orbits.seeds_within(orbit.scenario, ranges)
    assert seed.position == pytest.approx(orbit.position, abs=1e-9)
    assert orbits.seeds_within(orbit.scenario, ranges | {"drive.frequency": (2.51, 2.6)}) == []


def test_branches_begin_with_the_orbits_own(orbit: hm.Orbit) -> None:
    (own,) = orbits.all_branches(orbit, "drive.pitch", 0.2, 0.24)
    assert own.points[own.origin].value == orbit.scenario.drive.pitch
    outside = orbit.scenario.replaced({"drive.pitch": 0.3})
    (other,) = orbits.all_branches(replace(orbit, scenario=outside), "drive.pitch", 0.2, 0.24)
    assert [min(b.values) for b in (own, other)] == pytest.approx([0.2, 0.2])
    assert other.points[0].orbit.position == pytest.approx(own.points[0].orbit.position, abs=1e-7)
    with pytest.raises(hm.InputError, match=r"must go from low to high; got 5\.7296 deg to 5\.7296 deg"):
        orbits.all_branches(orbit, "drive.pitch", 0.1, 0.1)


def test_the_averaged_model_is_measured_at_two_nodes_off_the_orbit(
    orbit: hm.Orbit, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(paths, "COMPARED", 60.0)
    low, high = orbits.box_around(orbit, reach=0.02)
    flow = orbits.slow_flow(orbit, low=low, high=high, shape=(21, 5, 5))
    found = orbits.averaging_errors(flow, orbit)
    assert [off for off, _ in found] == pytest.approx([0.25 * 0.02, 0.6 * 0.02], abs=0.001 + 1e-9)
    for _, error in found:
        assert 0.0 < error.mean <= error.worst < 1e-3
        assert error.time[-1] == pytest.approx(60.0, abs=1.0)
    off, error = found[0]
    node = orbit.position + np.array([off, 0.0, 0.0])
    assert error.full[0] == pytest.approx(node[2], abs=1e-12)


def test_a_basin_by_flow_is_that_of_a_flow_half_as_wide_again(orbit: hm.Orbit, monkeypatch: pytest.MonkeyPatch) -> None:
    from helimag.orbits.averaged import attraction

    monkeypatch.setattr(attraction, "ENGINE_NODES", 7)
    asked = []
    work_out = attraction.slow_flow
    monkeypatch.setattr(attraction, "slow_flow", lambda *a, **k: asked.append(k) or work_out(*a, **k))
    low, high = orbits.box_around(orbit, reach=0.02)
    caught = orbits.basin_by_flow(orbit, low=low, high=high, shape=(3, 3, 3), duration=1200.0)
    assert caught.engine == "averaged"
    assert asked[0]["low"] == pytest.approx(orbit.position - 0.03)
    assert asked[0]["high"] == pytest.approx(orbit.position + 0.03)
    same = orbits.basin(orbit, low=low, high=high, shape=(3, 3, 3), duration=1200.0)
    assert caught.ends.tolist() == same.ends.tolist()
    unstable = replace(orbit, multipliers=2.0 * orbit.multipliers / np.abs(orbit.multipliers[0]))
    with pytest.raises(hm.InputError, match="needs a stable orbit"):
        orbits.basin_by_flow(unstable, low=low, high=high)
    with pytest.raises(hm.InputError, match="low below high"):
        orbits.basin_by_flow(orbit, low=high, high=low)


def test_only_grids_of_two_numbers_make_a_map(orbit: hm.Orbit) -> None:
    grid = np.full((2, 3), -1.0)
    states = np.zeros((2, 3, 7))
    flags = np.zeros((2, 3), bool)
    result = OrbitComparison(np.full((2, 3), "bounded"), grid, grid, states, flags, flags)
    pitch, frequency = ("drive.pitch", [0.1, 0.2]), ("drive.frequency", [1.0, 2.0, 3.0])
    known = orbits.map_of(result, orbit.scenario, [pitch, frequency])
    assert known is not None
    assert known.paths == ("drive.pitch", "drive.frequency")
    assert known.scenario_at(1, 2).drive.frequency == 3.0
    assert known.scenario_at(1, 2).drive.pitch == 0.2
    assert known.stable.all()
    for inputs in (
        [pitch],
        [pitch, frequency, pitch],
        [pitch, ("magnet.field", ["dipole", "cylinder", "dipole"])],
        [pitch, ("drive.frequency", [3.0, 2.0, 1.0])],
        [pitch, ("drive.frequency", [1.0, 1.0, 2.0])],
        [("drive.pitch", [0.1]), frequency],
    ):
        assert orbits.map_of(result, orbit.scenario, inputs) is None
