"""The boundary over two inputs, as curves: beside orbits and events found one by one."""

import math

import numpy as np
import pytest

import helimag as hm
from helimag.orbits import (
    BoundaryCurve,
    Change,
    StabilityMap,
    boundary_of,
    find_orbits,
    stability_map,
    stable_interval,
)
from helimag.orbits.curves import boundary
from helimag.orbits.strobe import chart
from helimag.scenario import Input

PATHS = "drive.pitch", "drive.frequency"
PITCHES, FREQUENCIES = np.radians(np.linspace(4.0, 17.0, 6)), np.linspace(2.1, 3.0, 6)
SPANS = np.ptp(PITCHES), np.ptp(FREQUENCIES)


@pytest.fixture(scope="module")
def base() -> hm.Scenario:
    return hm.load("nose-first/fig3c").replaced({"drive.frequency": "2.5 Hz"})


@pytest.fixture(scope="module")
def orbit(base: hm.Scenario) -> hm.Orbit:
    return hm.find_orbit(base)


@pytest.fixture(scope="module")
def found(orbit: hm.Orbit) -> StabilityMap:
    return stability_map(orbit.scenario, (PATHS[0], PITCHES), (PATHS[1], FREQUENCIES), seeds=[orbit])


@pytest.fixture(scope="module")
def curves(found: StabilityMap) -> dict[Change, BoundaryCurve]:
    done: list[float] = []
    result = boundary_of(found, progress=done.append)
    assert done[-1] == 1.0
    assert len(result) == 2
    return {curve.kind: curve for curve in result}


def scenario_at(base: hm.Scenario, pitch: float, frequency: float) -> hm.Scenario:
    return base.replaced({PATHS[0]: float(pitch), PATHS[1]: float(frequency)})


def crossings(across: np.ndarray, along: np.ndarray, value: float) -> list[float]:
    """Where a polyline passes a value of one coordinate: the other one."""
    at = np.flatnonzero((across[:-1] - value) * (across[1:] - value) <= 0.0)
    part = (value - across[at]) / (across[at + 1] - across[at])
    return sorted((along[at] + part * (along[at + 1] - along[at])).tolist())


def test_each_kind_is_one_curve_across_the_map(curves: dict[Change, BoundaryCurve]) -> None:
    assert curves.keys() == {Change.FOLD, Change.NEIMARK_SACKER}
    for curve in curves.values():
        assert curve.paths == PATHS
        assert curve.ends == ("edge of the map", "edge of the map")
        ends = np.array([curve.first[[0, -1]] / SPANS[0], curve.second[[0, -1]] / SPANS[1]])
        edges = np.array([PITCHES[[0, -1]] / SPANS[0], FREQUENCIES[[0, -1]] / SPANS[1]])
        assert np.abs(ends[:, :, None] - edges[:, None, :]).min(axis=(0, 2)).max() < 1e-9
        assert np.hypot(np.diff(curve.first) / SPANS[0], np.diff(curve.second) / SPANS[1]).max() < 1.0 / 50.0


def test_curves_agree_with_events_along_either_input(orbit: hm.Orbit, curves: dict[Change, BoundaryCurve]) -> None:
    fold, swing = curves[Change.FOLD], curves[Change.NEIMARK_SACKER]
    for frequency in (2.4, 2.55, 2.75):
        start = hm.find_orbit(scenario_at(orbit.scenario, math.radians(8.0), frequency), thorough=False)
        interval = stable_interval(start, PATHS[0], PITCHES[0], PITCHES[-1])
        assert (interval.why_low, interval.why_high) == (Change.NEIMARK_SACKER, Change.FOLD)
        (low,), (high,) = (crossings(curve.second, curve.first, frequency) for curve in (swing, fold))
        assert [low, high] == pytest.approx([interval.low, interval.high], abs=1e-3 * SPANS[0])
    # along the other input the swings are met twice: there the curve runs along the first input and turns back
    pitch = math.radians(4.7)
    start = hm.find_orbit(scenario_at(orbit.scenario, pitch, 2.4), thorough=False)
    interval = stable_interval(start, PATHS[1], FREQUENCIES[0], FREQUENCIES[-1])
    assert (interval.why_low, interval.why_high) == (Change.NEIMARK_SACKER, Change.NEIMARK_SACKER)
    assert crossings(swing.first, swing.second, pitch) == pytest.approx(
        [interval.low, interval.high], abs=1e-3 * SPANS[1]
    )


def test_points_lie_on_the_boundary_itself(base: hm.Scenario, curves: dict[Change, BoundaryCurve]) -> None:
    """Orbits found anew at the inputs of the swings' curve neither grow nor decay."""
    swing = curves[Change.NEIMARK_SACKER]
    chosen = range(0, swing.first.size, 9)
    length = np.array(base.drive.distance)
    drives = [scenario_at(base, swing.first[k], swing.second[k]) for k in chosen]
    for k, each in zip(chosen, find_orbits(drives, swing.states[list(chosen)]), strict=True):
        assert abs(each.growth) < 2e-8
        assert abs(each.rates[0].imag) == pytest.approx(swing.swing[k], rel=1e-5)
        assert np.abs(chart.coordinates(each.state, swing.states[k], length)).max() < 1e-7
    assert not curves[Change.FOLD].swing.any()


@pytest.mark.parametrize("kind", [Change.FOLD, Change.NEIMARK_SACKER])
def test_orbits_are_stable_on_one_side_alone(
    kind: Change, base: hm.Scenario, curves: dict[Change, BoundaryCurve]
) -> None:
    """A thousandth of the ranges to either side of the curve, searched from many places around its orbit."""
    curve = curves[kind]
    rng = np.random.default_rng(4)
    by = np.vstack([np.zeros(6), rng.normal(scale=0.02, size=(15, 6))])
    for k in range(5, curve.first.size - 5, 12):
        ahead = np.array([np.diff(curve.first[k : k + 2]) / SPANS[0], np.diff(curve.second[k : k + 2]) / SPANS[1]])
        normal = np.array([-ahead[1, 0], ahead[0, 0]]) / np.linalg.norm(ahead)
        near = chart.moved(np.broadcast_to(curve.states[k], (16, 7)), by, np.full(16, base.drive.distance))
        stable = []
        for side in (1e-3, -1e-3):
            drive = scenario_at(
                base, curve.first[k] + side * normal[0] * SPANS[0], curve.second[k] + side * normal[1] * SPANS[1]
            )
            orbits = [each for each in find_orbits([drive] * 16, near) if each.found]
            here = [
                each
                for each in orbits
                if np.linalg.norm(chart.coordinates(each.state, curve.states[k], np.array(base.drive.distance))) < 0.1
            ]
            stable.append(any(each.stable for each in here))
            if kind is Change.NEIMARK_SACKER:
                assert here
        assert sorted(stable) == [False, True]


def test_folds_take_over_where_they_meet_the_swings(base: hm.Scenario, monkeypatch: pytest.MonkeyPatch) -> None:
    """The point where both meet lies where the lower end over frequency changes its kind.

    Begun at the swings alone, whose curve leads to the folds'.
    """
    edges = boundary._edges
    monkeypatch.setattr(boundary, "_edges", lambda result: [each for each in edges(result) if each[0][0] == 0])
    pitches, frequencies = np.radians(np.linspace(20.0, 22.0, 4)), np.linspace(1.54, 1.7, 4)
    seed = hm.find_orbit(scenario_at(base, math.radians(20.0), 1.7))
    result = stability_map(base, (PATHS[0], pitches), (PATHS[1], frequencies), seeds=[seed])
    curves = boundary_of(result)
    assert {curve.kind for curve in curves} == {Change.FOLD, Change.NEIMARK_SACKER}
    assert len(curves) == 2
    meets = []
    for curve in curves:
        assert sorted(curve.ends) == ["edge of the map", "fold-Neimark-Sacker"]
        end = -curve.ends.index("fold-Neimark-Sacker")
        meets.append([curve.first[end], curve.second[end]])
    assert meets[0] == pytest.approx(meets[1], rel=1e-5)
    for by, why in ((-0.3, Change.NEIMARK_SACKER), (0.3, Change.FOLD)):
        pitch = meets[0][0] + math.radians(by)
        (start,) = find_orbits([scenario_at(base, pitch, 1.7)], seed.state[None])
        interval = stable_interval(start, PATHS[1], 1.54, 1.75)
        (curve,) = (curve for curve in curves if curve.kind is why)
        assert interval.why_low == why
        assert crossings(curve.first, curve.second, pitch)[-1] == pytest.approx(interval.low, abs=1e-3 * 0.16)


def test_an_input_of_the_map_may_be_the_distance(base: hm.Scenario, orbit: hm.Orbit) -> None:
    """Coordinates are shares of one length, whatever the distance does."""
    distances = np.linspace(0.15, 0.19, 4)
    result = stability_map(base, ("drive.distance", distances), (PATHS[1], np.linspace(2.3, 2.7, 4)), seeds=[orbit])
    (curve,) = boundary_of(result)
    assert curve.kind is Change.FOLD
    interval = stable_interval(orbit, "drive.distance", distances[0], distances[-1])
    assert crossings(curve.second, curve.first, 2.5) == pytest.approx([interval.high], abs=1e-3 * 0.04)
    assert Input("drive.distance").value(curve.scenario) == pytest.approx(0.15)
