"""Leaps over turns of the magnet, held against direct steps at a tolerance of 1e-11."""

from contextlib import closing

import numpy as np
import pytest

import helimag as hm
import oracles
from helimag.engine import DOP853, MULTIREVOLUTION, advance, advancing
from helimag.outcomes import End

TAIL_FIRST = {
    "left": False,
    "wire": 0.1938e-3,
    "head": 0.553e-3,
    "viscosity": 1.65,
    "weight": 51.6e-6,
    "gravity_center": -3.8e-3,
    "beta": -np.radians(12.7),
    "yaw": -np.radians(1.8),
}


def scenario(duration, extra="", **changes):
    return oracles.scenario_of(oracles.case(**changes), f'{extra}\n[run]\nduration = "{duration}"\ninterval = "0.7 s"')


def both(run):
    (exact,), (leaping,) = advance([run], tolerance=1e-11), advance([run], method=MULTIREVOLUTION)
    return exact, leaping


@pytest.fixture(scope="module")
def steady():
    """A device that gets into step and stays there: directly, and with leaps."""
    return both(scenario("400 s", **TAIL_FIRST))


def test_leaps_take_a_steady_run_most_of_its_way(steady):
    exact, leaping = steady
    followed = leaping.progress["leap"]["followed"]
    assert exact.leapt == 0.0
    assert 0.6 < leaping.leapt < 1.0
    assert followed < 0.5 * leaping.leapt * 400.0 * 3.3
    assert leaping.steps < 0.5 * advance([leaping.scenario])[0].steps


def test_samples_between_turns_are_those_of_direct_steps(steady):
    exact, leaping = steady
    np.testing.assert_array_equal(exact.time, leaping.time)
    away = np.linalg.norm(exact.states[:, :3] - leaping.states[:, :3], axis=1)
    assert away.max() < 5e-7
    np.testing.assert_allclose(leaping.states[:, 3:], exact.states[:, 3:], rtol=0.0, atol=2e-5)
    np.testing.assert_array_equal(exact.slips, leaping.slips)


def test_extremes_and_means_are_those_of_direct_steps(steady):
    exact, leaping = steady
    for name, most in {"low": 2e-6, "high": 2e-6, "height": 1e-6, "attack": 1e-4, "square": 1e-4}.items():
        np.testing.assert_allclose(leaping.records[name], exact.records[name], rtol=0.0, atol=most, err_msg=name)
    assert leaping.judge().verdict is exact.judge().verdict
    assert leaping.judge().gain == pytest.approx(exact.judge().gain, abs=1e-5)


def test_contact_is_found_when_it_comes():
    exact, leaping = both(scenario("60 s", distance=0.095))
    assert exact.status is leaping.status is End.CONTACT
    assert leaping.leapt > 0.2
    assert leaping.time[-1] == pytest.approx(exact.time[-1], abs=1e-3)


@pytest.mark.parametrize(
    ("end", "changes"),
    [(End.SURFACE, {"distance": 0.14}), (End.FLOOR, {"distance": 0.13, "frequency": 2.0})],
    ids=["surface", "floor"],
)
def test_walls_are_found_when_they_come(end, changes):
    walls = '[workspace]\nfloor = "-20 mm"\nsurface = "12 mm"'
    exact, leaping = both(scenario("400 s", walls, **TAIL_FIRST | changes))
    assert exact.status is leaping.status is end
    assert leaping.leapt > 0.5
    assert leaping.time[-1] == pytest.approx(exact.time[-1], abs=1e-3)


def test_a_device_that_slips_is_stepped_directly():
    run = scenario("30 s", distance=0.25)
    (direct,), (leaping,) = advance([run], method=DOP853), advance([run], method=MULTIREVOLUTION)
    assert direct.slips[-1] > 3
    assert leaping.leapt == 0.0
    np.testing.assert_array_equal(direct.states, leaping.states)


def test_no_leaps_where_no_frame_moves_with_the_drive():
    run = scenario("30 s", **TAIL_FIRST | {"velocity": (1e-4, 0.0, 0.0)})
    (direct,), (leaping,) = advance([run]), advance([run], method=MULTIREVOLUTION)
    assert leaping.leapt == 0.0
    np.testing.assert_array_equal(direct.states, leaping.states)


def test_going_on_after_a_stop_gives_the_same_bits():
    runs = [scenario("30000 s", **TAIL_FIRST), scenario("30000 s", **TAIL_FIRST | {"weight": 50e-6})]
    whole = advance(runs, method=MULTIREVOLUTION)
    looks = advancing(runs, method=MULTIREVOLUTION, threads=1)
    first = []
    with closing(looks):
        for underway in looks:
            first = underway.histories()
            if all(history.progress["leap"]["stage"] > 0 for history in first):
                break
    assert all(history.status is End.RUNNING for history in first)
    again = []
    for underway in advancing(runs, after=first, method=MULTIREVOLUTION):
        again = underway.histories()
    for one, other in zip(whole, again, strict=True):
        assert one.leapt > 0.8
        np.testing.assert_array_equal(one.records, other.records)


def test_the_result_says_which_engine_did_what():
    run = scenario("300 s", **TAIL_FIRST)
    leaping, direct = hm.simulate(run, method="multirevolution"), hm.simulate(run)
    assert "multi-revolution" in leaping.dataset.attrs["integrator"]
    assert 0.5 < leaping.dataset.attrs["share_of_turns_leapt_over"] < 1.0
    assert direct.dataset.attrs["integrator"] == "DOP853, adaptive"
    with pytest.raises(hm.InputError, match="method must be one of direct, multirevolution; got 'euler'"):
        hm.simulate(run, method="euler")
