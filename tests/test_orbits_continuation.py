"""Following orbits: folds and Neimark-Sacker points, intervals, the map of two inputs, inputs by name."""

import math

import numpy as np
import pytest

import helimag as hm
from helimag.orbits import Change, find_orbits, follow, stability_map, stable_interval
from helimag.scenario import Input


@pytest.fixture(scope="module")
def scenario() -> hm.Scenario:
    return hm.load("nose-first/fig3c").replaced({"drive.frequency": "2.5 Hz"})


@pytest.fixture(scope="module")
def orbit(scenario: hm.Scenario) -> hm.Orbit:
    return hm.find_orbit(scenario)


def nearest(scenario: hm.Scenario, path: str, value: float, state: np.ndarray) -> hm.Orbit:
    (found,) = find_orbits([scenario.replaced({path: value})], state[None])
    return found


def test_fold_is_located_and_the_branch_turns_there(scenario: hm.Scenario, orbit: hm.Orbit) -> None:
    low, high = math.radians(12.0), math.radians(20.0)
    branch = follow(orbit, "drive.pitch", low, high)
    (fold,) = [event for event in branch.events if event.kind is Change.FOLD]
    assert branch.values.max() <= fold.value + 1e-6
    # both branches reach the end of the range, one stable, one not: the fold joins two orbits
    assert branch.points[0].value == pytest.approx(low)
    assert branch.points[-1].value == pytest.approx(low)
    assert {branch.points[0].orbit.stable, branch.points[-1].orbit.stable} == {True, False}
    # an independent check: orbits exist on one side of it within 1e-3 of the range, and not on the other
    width = 1e-3 * (high - low)
    assert nearest(scenario, "drive.pitch", fold.value - width, fold.orbit.state).found
    assert not nearest(scenario, "drive.pitch", fold.value + width, fold.orbit.state).found


def test_neimark_sacker_point_is_located(scenario: hm.Scenario, orbit: hm.Orbit) -> None:
    low, high = 1.4, 2.5
    interval = stable_interval(orbit, "drive.frequency", low, high)
    assert interval.why_low == Change.NEIMARK_SACKER
    assert interval.why_high == "end of the range"
    assert interval.high == pytest.approx(high)
    width = 1e-3 * (high - low)
    state = follow(orbit, "drive.frequency", low, high, while_stable=True).events[0].orbit.state
    before, after = (nearest(scenario, "drive.frequency", interval.low + by, state) for by in (width, -width))
    assert before.stable
    assert after.found
    assert not after.stable
    assert abs(after.rates[0].imag) > 0.01
    assert "stable for frequency between" in interval.text


def test_range_must_hold_the_orbit(orbit: hm.Orbit) -> None:
    with pytest.raises(hm.InputError, match=r"range of drive\.pitch"):
        follow(orbit, "drive.pitch", math.radians(5.0), math.radians(6.0))
    with pytest.raises(hm.InputError, match="single number"):
        follow(orbit, "drive.velocity", 0.0, 1.0)
    with pytest.raises(hm.InputError, match="not a field"):
        follow(orbit, "drive.pith", 0.0, 1.0)


def test_map_agrees_with_orbits_found_one_by_one(scenario: hm.Scenario, orbit: hm.Orbit) -> None:
    pitches, frequencies = np.radians([8.0, 11.0, 14.0, 17.0]), np.array([2.2, 2.5, 2.8, 3.1])
    result = stability_map(scenario, ("drive.pitch", pitches), ("drive.frequency", frequencies), seeds=[orbit])
    assert result.stable.sum() >= 9
    for i, j in [(0, 1), (1, 2), (2, 0)]:
        one = hm.find_orbit(result.scenario_at(i, j), thorough=False)
        assert one.stable
        assert result.growth[i, j] == pytest.approx(one.growth, rel=1e-3)
    assert not result.stable[3, 2:].any()


def test_inputs_by_name(scenario: hm.Scenario) -> None:
    pitch = Input("drive.pitch")
    assert pitch.show(scenario, pitch.read(scenario, "0.2 rad"), 4) == "11.46 deg"
    straight = scenario.replaced({"drive.yaw_rate": 0.0, "drive.velocity": (3e-4, 0.0, 4e-4)})
    speed = Input("drive.speed")
    assert speed.value(straight) == pytest.approx(5e-4)
    assert speed.changed(straight, 1e-3).drive.velocity == pytest.approx((6e-4, 0.0, 8e-4))
    assert speed.changed(scenario, 1e-3).drive.velocity == (1e-3, 0.0, 0.0)
