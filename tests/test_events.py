"""How runs end and what they record: events, the exact end, sampling, batches, progress, numbers that break down."""

from itertools import pairwise

import numpy as np
import pytest

import helimag as hm
import oracles
from helimag.engine import simulation
from helimag.outcomes import End

CONTACT = np.hypot(0.0175, 0.010) + 0.0003603
NEAR = {"distance": 0.040, "beta": np.radians(5.0)}
SINKING = {
    "moment": 1e-30,
    "yaw": 0.0,
    "start": (0.0, 0.0, 0.0),
    "weight": 3e-4,
    "matrix": np.diag([0.1] * 3 + [8e-9] + [6e-6] * 2),
}
SINKING |= {"gravity_center": 0.0}


def test_contact_is_where_and_when_the_oracle_has_it():
    c = oracles.case(**NEAR)
    run = oracles.run(c, 30.0)
    assert run.verdict == "attracted"

    def gap(t, y):
        return np.linalg.norm(y[:3] - oracles.rpm(c, t)[0][0]) - CONTACT

    gap.terminal = True
    end = oracles.solve(c, [30.0], events=gap, rtol=1e-10).t_events[0][0]
    assert run.judgement.end_time == pytest.approx(end, abs=1e-7)
    assert run.dataset.gap.values[-1] == pytest.approx(CONTACT, abs=1e-9)  # 1 ns at 0.2 m/s
    assert run.dataset.gap.values[-1] <= CONTACT
    assert np.all(run.dataset.gap.values[:-1] > CONTACT)
    assert run.judgement.escape_time == run.judgement.end_time


def test_close_to_the_magnet_the_run_stays_accurate():
    """The roll relaxes as 1 / r^3 there; a tight tolerance must give the same path up to just before contact."""
    c = oracles.case(**NEAR)
    end = oracles.run(c, 30.0).judgement.end_time
    usual = oracles.run(c, end - 1e-4)
    tight = oracles.run(c, end - 1e-4, tolerance=1e-11)
    assert usual.dataset.gap.values[-1] < CONTACT + 2e-4
    assert np.abs(usual.final_state[:3] - tight.final_state[:3]).max() < 1e-8
    assert oracles.attitude_difference(usual.final_state[3:], tight.final_state[3:]) < 1e-5


@pytest.mark.parametrize("name", ["floor", "surface", "fall"])
def test_vertical_ends(name):
    """A body that sinks, or floats up, at W / a: it ends where its lowest (highest) part touches."""
    weight = -3e-4 if name == "surface" else 3e-4
    c = oracles.case(**SINKING | {"weight": weight, "distance": 0.05, "beta": 0.0})
    extra = {"floor": '[workspace]\nfloor = "-20 mm"', "surface": '[workspace]\nsurface = "20 mm"', "fall": ""}[name]
    run = hm.simulate(oracles.scenario_of(c, extra), duration=100.0)
    # the coil's end is thicker than the head, and level with it
    way = {"floor": 0.020 - 0.00047, "surface": 0.020 - 0.00047, "fall": 2 * 0.05}[name]
    assert run.judgement.end_time == pytest.approx(way / (3e-4 / 0.1), abs=2e-6)
    assert abs(run.final_state[2]) == pytest.approx(way, abs=1e-8)
    assert run.dataset.attrs["end"] == name
    assert run.verdict == ("fell" if name == "fall" else "wall-limited")
    if name != "fall":
        assert name in run.judgement.reason


@pytest.mark.parametrize(("axis", "side"), [("x", -1), ("x", 1), ("y", -1), ("y", 1)])
def test_walls(axis, side):
    """Pulled by a drive along nothing but a magnet from the side: the nose, or the tail, touches first."""
    c = oracles.case(
        about="magnet", magnets=[((0.0, 0.0, 0.0), 18.89)], distance=0.06, beta=0.0, yaw=0.0, start=(0.0, 0.0, 0.0)
    )
    reach = {("x", 1): 0.0003603, ("x", -1): 0.0003603 + 0.0117 + 0.00047}.get((axis, side), 0.00047)
    limits = sorted([side * (reach + 5e-5), -side * 0.5])
    walls = f'[workspace]\nwalls = {{ {axis} = ["{limits[0]!r} m", "{limits[1]!r} m"] }}'
    run = hm.simulate(oracles.scenario_of(c, walls), duration=60.0, interval=0.01)
    assert run.dataset.attrs["end"] == "wall"
    nose = run.final_state[:3]
    tail = nose - run.dataset.long_axis.values[-1] * (0.0003603 + 0.0117)
    i = "xyz".index(axis)
    far = max(side * nose[i] + 0.0003603, side * tail[i] + 0.00047)
    assert far == pytest.approx(reach + 5e-5, abs=1e-7)
    assert far >= reach + 5e-5


def test_a_start_that_already_touches_ends_at_once():
    c = oracles.case(magnets=[((0.0, 0.0, -0.149), 1e-20)], about="magnet", beta=0.0)
    run = oracles.run(c, 10.0)
    assert run.judgement.end_time <= 1e-6
    assert run.verdict == "attracted"


# ------------------------------------------------------------------------------------------------ the end, and sampling


@pytest.mark.parametrize(
    ("duration", "interval"),
    [(7.1, None), (14.2, None), (1.0, 0.3), (0.3, 0.1), (2.0, 5.0), (1e-7, None), (1.0, 0.1 * (1 - 1.5e-12))],
)
def test_the_end_is_exact(duration, interval):
    """Also where the interval is no divisor, or 1800 of it fall short by rounding (7.1 s).

    Steps get to a sample by equal parts, so that the end has their own accuracy; a leap's is that of leaps.
    """
    run = oracles.run(oracles.case(), duration, interval=interval, method="direct")
    times = run.dataset.time.values
    assert times[-1] == duration
    assert run.judgement.end_time == duration
    assert np.all(np.diff(times) > 0)
    assert run.dataset.attrs["end"] == "horizon"
    step = interval or duration / 1800
    np.testing.assert_allclose(times[:-1], np.arange(len(times) - 1) * step, rtol=1e-15)
    assert duration - times[-2] <= step * (1 + 1e-9)
    same = oracles.run(oracles.case(), duration, interval=duration, method="direct").final_state
    np.testing.assert_allclose(run.final_state[:3], same[:3], atol=1e-10)


def test_sampling_does_not_change_what_a_run_says():
    """Extremes, means and slips are over every step, not over the samples kept."""
    coarse, fine = (oracles.run(oracles.case(), 60.0, interval=i) for i in (20.0, 0.005))
    assert np.abs(coarse.final_state - fine.final_state)[:3].max() < 1e-8
    assert coarse.gain == pytest.approx(fine.gain, abs=5e-6)  # extremes are those at the ends of steps
    heights = fine.dataset.position.values[:, 2]
    assert coarse.judgement.output == pytest.approx(np.ptp(heights), abs=1e-6)
    third = fine.dataset.time.values <= 20.0
    assert coarse.dataset.height_mean.values[1] == pytest.approx(np.trapezoid(heights[third], dx=0.005) / 20, abs=1e-7)
    attack = fine.dataset.attack_angle.values[third]
    assert coarse.dataset.attack_mean.values[1] == pytest.approx(np.trapezoid(attack, dx=0.005) / 20, abs=2e-4)
    assert coarse.dataset.attack_mean_square.values[1] == pytest.approx(
        np.trapezoid(attack**2, dx=0.005) / 20, abs=2e-4
    )
    assert coarse.dataset.height_low.values[1] == pytest.approx(heights[third].min(), abs=1e-6)
    assert coarse.dataset.height_high.values[1] == pytest.approx(heights[third].max(), abs=1e-6)


# ------------------------------------------------------------------------------------------------------------- batches


def mixed_batch():
    cases = [oracles.case(beta=np.radians(8 + k), distance=0.14 + 0.002 * k) for k in range(9)]
    cases += [oracles.case(**NEAR), oracles.case(magnets=[((0.0, 0.05, 0.0), 9.0), ((0.0, -0.05, 0.0), 9.0)])]
    return [oracles.scenario_of(c, f'[run]\nduration = "{3 + i} s"') for i, c in enumerate(cases)]


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_batch_is_the_same_as_single_runs_bit_for_bit(threads):
    scenarios = mixed_batch()
    together = hm.simulate_many(scenarios, threads=threads)
    for scenario, run in zip(scenarios, together, strict=True):
        alone = hm.simulate(scenario)
        assert np.array_equal(oracles.states_of(alone), oracles.states_of(run))
        assert alone.judgement == run.judgement


def test_fill_up_magnets_of_a_batch_touch_nothing():
    """A scenario with one magnet far from the arm's centre must not meet the others' second magnet there."""
    off = oracles.case(
        about="magnet", beta=0.0, yaw=0.0, distance=0.03, magnets=[((0.0, 0.0, 0.12), 18.89)], weight=-3e-3
    )
    two = oracles.case(magnets=[((0.0, 0.05, 0.0), 9.0), ((0.0, -0.05, 0.0), 9.0)])
    scenarios = [oracles.scenario_of(c, '[run]\nduration = "2 s"') for c in (off, two)]
    together, alone = hm.simulate_many(scenarios)[0], hm.simulate(scenarios[0])
    assert alone.judgement == together.judgement
    assert np.array_equal(oracles.states_of(alone), oracles.states_of(together))


def test_progress_reaches_one():
    seen = []
    hm.simulate_many(mixed_batch(), progress=seen.append)
    assert seen[-1] == pytest.approx(1.0, abs=1e-12)
    assert all(b >= a - 1e-12 for a, b in pairwise(seen))
    assert min(seen) >= 0.0


def test_an_interrupted_batch_stops():
    class Enough(Exception):
        pass

    def stop(_):
        raise Enough

    with pytest.raises(Enough):
        hm.simulate_many(mixed_batch(), progress=stop)


# ------------------------------------------------------------------------------------------------- numbers that break


@pytest.mark.parametrize(
    "state",
    [
        [np.nan, 0, 0, 1, 0, 0, 0],
        [0, 0, np.inf, 1, 0, 0, 0],
        [0, 0, 0, 0, 0, 0, 0],
        [0, 0, 0, 1, 0, 0],
        [[0, 0, 0, 1, 0, 0, 0]],
        ["a"] * 7,
        [0, 0, [0], 1, 0, 0, 0],
    ],
)
def test_absurd_initial_states_are_refused(state):
    with pytest.raises(hm.InputError, match="initial_state"):
        oracles.run(oracles.case(), 1.0, initial_state=state)


@pytest.mark.parametrize("changes", [{"weight": 1e300}, {"moment": 1e300}])
def test_a_run_that_breaks_down_says_so(changes):
    with pytest.raises(hm.RunError, match="broke down at"):
        oracles.run(oracles.case(**changes), 1.0)
    (history,) = simulation.advance([oracles.scenario_of(oracles.case(**changes))])
    assert history.status is End.NOT_FINITE


def test_a_start_inside_the_magnet_is_no_number():
    place = oracles.rpm(oracles.case(), 0.0)[0][0]
    with pytest.raises(hm.RunError):
        oracles.run(oracles.case(), 1.0, initial_state=[*place, 1, 0, 0, 0])


@pytest.mark.parametrize("tolerance", [0.0, -1e-9, float("nan")])
def test_tolerance_must_be_positive(tolerance):
    with pytest.raises(hm.InputError, match="tolerance"):
        oracles.run(oracles.case(), 1.0, tolerance=tolerance)


def test_an_empty_batch_is_refused():
    with pytest.raises(hm.InputError, match="at least one"):
        hm.simulate_many([])


def test_runs_of_a_batch_may_differ_in_their_formulas():
    """A dipole, a cylinder and a sampled path side by side: each as if it were alone, in the order given."""
    dipole = oracles.scenario_of(oracles.case(), '[run]\nduration = "2 s"')
    magnet = {"moment": 18.89, "radius": 0.0175, "height": 0.02, "field": "cylinder"}
    cylinder = dipole.replaced({"magnet": [magnet]})
    path = {"time": [0.0, 1.0, 2.0], "position": [[0.0, -0.045, 0.15], [0.001, -0.045, 0.15], [0.002, -0.045, 0.151]]}
    sampled = dipole.replaced({"drive.path": path, "drive.yaw_rate": 0.0, "drive.velocity": (0.0, 0.0, 0.0)})
    scenarios = [dipole, sampled, cylinder, dipole, sampled]
    together = hm.simulate_many(scenarios)
    for scenario, run in zip(scenarios, together, strict=True):
        assert np.array_equal(oracles.states_of(hm.simulate(scenario)), oracles.states_of(run))
    assert not np.array_equal(together[0].final_state, together[2].final_state)
