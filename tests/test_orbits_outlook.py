"""What becomes of a run after its horizon: by its orbit, or by taking it on; and motion on closed curves."""

import math

import numpy as np
import pytest

import helimag as hm
from helimag.orbits import Future, explain, find_orbits, follow
from helimag.orbits.beside_runs import outlook
from helimag.orbits.beside_runs.closed_curve import swinging, weighted_mean
from helimag.orbits.beside_runs.outlook import ON_ORBIT
from helimag.orbits.strobe import chart
from helimag.outcomes import Verdict


@pytest.fixture(scope="module")
def orbit() -> hm.Orbit:
    return hm.find_orbit(hm.load("nose-first/fig3c").replaced({"drive.frequency": "2.5 Hz"}))


@pytest.fixture(scope="module")
def swing() -> hm.Scenario:
    """One whose only orbit repels: a random one of the brute-force benchmark."""
    return hm.load("nose-first/fig3c").replaced(
        {
            "drive.frequency": 3.6618,
            "drive.pitch": "7.848 deg",
            "drive.distance": "164.04 mm",
            "drive.yaw_rate": "0.7424 deg/s",
            "device.weight.net_weight": "24.571 uN",
            "fluid.viscosity": "1.1248 Pa s",
        }
    )


def test_outlook_of_runs_that_come_to_a_stable_orbit(orbit: hm.Orbit) -> None:
    coming = explain(hm.simulate(orbit.scenario))
    assert coming.future is Future.COMING
    assert coming.orbit is not None
    assert coming.orbit.position == pytest.approx(orbit.position, abs=1e-7)
    assert "decays in 1868 s" in coming.text
    on = explain(hm.simulate(orbit.scenario, duration=333.3, initial_state=orbit.state))
    assert on.future is Future.ON_ORBIT
    assert "on a stable orbit" in on.text


def test_outlook_of_runs_that_leave_is_what_a_longer_run_shows() -> None:
    scenario = hm.load("nose-first/fig3c")
    assert explain(hm.simulate(hm.load("nose-first/fig3a"))).future is Future.GONE
    later = explain(hm.simulate(scenario))
    assert later.future is Future.LEAVES
    whole = hm.simulate(scenario, duration=4000.0)
    assert whole.verdict is Verdict.ATTRACTED
    assert "pulled into the magnet" in later.text
    after = float(later.text.split("after another ")[1].split(" s")[0])
    assert 1800.0 + after == pytest.approx(whole.judgement.end_time, abs=1.0)


def test_outlook_of_an_arm_that_turns_and_moves_is_not_known() -> None:
    scenario = hm.load("nose-first/fig3c").replaced({"drive.velocity": ["0.1 mm/s", "0 mm/s", "0 mm/s"]})
    outlook = explain(hm.simulate(scenario, duration=10.0))
    assert outlook.future is Future.UNKNOWN
    assert "must not both act" in outlook.text


def test_outlook_of_a_straight_run_looks_beyond_the_end_of_the_tank(orbit: hm.Orbit) -> None:
    """The circle's speed on a line: no orbit there, so the run leaves; but not by the wall, which stands 10 mm off."""
    straight = orbit.scenario.replaced({"drive.yaw_rate": 0.0, "drive.velocity": ["0.4 mm/s", "0 mm/s", "0 mm/s"]})
    tank = straight.replaced({"workspace.walls.x": ["-200 mm", "10 mm"]})
    run = hm.simulate(tank, duration=10.0, initial_state=orbit.state)
    assert run.verdict.inside
    open_water, walled = explain(hm.simulate(straight, duration=10.0, initial_state=orbit.state)), explain(run)
    assert walled.text == open_water.text
    assert "wall" not in walled.text


def test_outlook_of_a_run_on_a_closed_curve(swing: hm.Scenario) -> None:
    repelling = np.array([-0.0145, -0.0515, 0.0172, 0.0749, -0.0997, -0.2996, 0.9459])
    orbit = hm.find_orbit(swing, near=repelling)
    assert orbit.found
    assert orbit.growth > 0.0
    outlook = explain(hm.simulate(swing, initial_state=orbit.state + 0.02 * np.eye(7)[1]))
    assert outlook.future is Future.SWINGS
    assert "swing in 50" in outlook.text


def test_swinging_tells_closed_curves_from_disorder() -> None:
    times = 10.0 * np.arange(2000.0)
    around = 0.02 + 0.01 * np.cos(2.0 * math.pi * times / 503.0) ** 3
    curve = swinging(times, around)
    assert curve.closed
    assert curve.period == pytest.approx(503.0, rel=0.01)
    assert (curve.low, curve.high) == pytest.approx((0.01, 0.03), abs=1e-4)
    logistic = [0.3]
    while len(logistic) < times.size:
        logistic.append(3.97 * logistic[-1] * (1.0 - logistic[-1]))
    assert not swinging(times, np.array(logistic)).closed
    assert not swinging(times, np.cumsum(np.random.default_rng(1).normal(size=times.size))).closed


def test_weighted_mean_converges_faster_than_the_plain_one() -> None:
    phase = np.sqrt(2.0) * np.arange(1000.0)
    values = np.cos(phase)
    assert abs(weighted_mean(values)) < 1e-9 < abs(values.mean())


def test_a_run_beside_a_stable_orbit_may_still_leave(orbit: hm.Orbit, monkeypatch: pytest.MonkeyPatch) -> None:
    """Just before the fold an unstable orbit lies beside the stable one, and a run beyond it leaves.

    Whichever of the two the search from the run's end finds: here it is made to find the stable one.
    """
    low, high = math.radians(15.39), math.radians(15.5)
    (near,) = find_orbits([orbit.scenario.replaced({"drive.pitch": low})], orbit.state[None])
    saddle = follow(near, "drive.pitch", low, high).points[-1].orbit
    assert near.stable
    assert not saddle.stable
    length = np.array([0.15])
    gap = chart.coordinates(saddle.state[None], near.state[None], length)
    assert np.linalg.norm(gap) < ON_ORBIT
    monkeypatch.setattr(outlook, "find_orbit", lambda *_args, **_options: near)
    futures = []
    for share in (0.3, 1.2):
        start = chart.moved(near.state[None], share * gap, length)[0]
        futures.append(explain(hm.simulate(near.scenario, duration=20.0, initial_state=start)).future)
    assert futures[0] is Future.ON_ORBIT
    assert futures[1] in (Future.LEAVES, Future.STAYS)


def test_a_moment_of_a_run_is_taken_on_as_far_as_a_long_one() -> None:
    outlook = explain(hm.simulate(hm.load("nose-first/fig3c"), duration=0.1))
    assert "inside for 0.1 s" in outlook.text
    assert outlook.future is Future.LEAVES
    after = float(outlook.text.split("after another ")[1].split(" s")[0])
    assert after == pytest.approx(2275.0, abs=10.0)


def test_motion_without_swings_names_no_period() -> None:
    times = 10.0 * np.arange(200.0)
    sinking = swinging(times, -1e-5 * times)
    assert not sinking.closed
    assert "nan" not in sinking.text
    assert "swing" not in sinking.text
