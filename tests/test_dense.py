"""Samples within a step: the polynomial beside SciPy's own, runs beside exact ones, and what is told of intervals."""

from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from scipy.integrate import DOP853 as SCIPY_DOP853
from scipy.integrate import simpson

import oracles
from helimag.engine import DOP853, KEPT, Control, advance, system_of
from helimag.engine import running as running_module
from helimag.engine.dense import build_course, state_at
from helimag.engine.events import pack_bounds
from helimag.engine.methods import build_dop853
from helimag.engine.observe import observed
from helimag.engine.packing import pack_bodies, pack_drives, pack_magnets
from helimag.engine.system import build_rates
from helimag.outcomes import End
from helimag.physics.balance import OpenWater, Swimmer
from helimag.physics.kinematics import ArmMotion, State, arm_instant
from helimag.physics.magnetics import FieldSource

STEP = 0.004  # s: an eightieth of a turn
FINE = 1e-3  # s: some ten samples a step
COARSE = 0.05  # s: more than an eighth of a turn, which is the longest step, so that steps end there
LANDING = replace(DOP853, course=None)  # steps to each sample


def scenario(duration=5.0, interval=FINE, extra="", **changes):
    text = f'{extra}\n[run]\nduration = "{duration} s"\ninterval = "{interval} s"'
    return oracles.scenario_of(oracles.case(**changes), text)


def directly(run, tolerance=3e-7, method=DOP853):
    (history,) = advance([run], method=method, tolerance=tolerance)
    return history


@pytest.fixture(scope="module")
def fine():
    return directly(scenario())


@pytest.fixture(scope="module")
def exact():
    return directly(scenario(), tolerance=1e-11, method=LANDING)


def test_states_within_a_step_are_scipys():
    """One step of DOP853 and its dense output, with the equations as the oracles have them."""
    case = oracles.case()
    run = oracles.scenario_of(case)
    system = system_of(run)
    trial, course, rates = build_dop853(system), build_course(system), build_rates(system)

    @wp.kernel(enable_backward=False, module="unique")
    def stepped(
        body: wp.array(dtype=Swimmer),
        drive: wp.array(dtype=ArmMotion),
        magnets: wp.array(dtype=FieldSource),
        start: wp.array(dtype=State),
        times: wp.array(dtype=wp.float64),
        found: wp.array(dtype=State),
    ):
        kept = wp.zeros(shape=KEPT, dtype=State)
        t, h, here, control = times[0], wp.float64(STEP), OpenWater(), Control()
        k0 = rates(body[0], here, drive[0], magnets, t, start[0])
        end, error, lag = trial(
            body[0], here, drive[0], magnets, control, arm_instant(drive[0], t), h, start[0], k0, kept, True
        )
        way = course(body[0], here, drive[0], magnets, t, h, start[0], kept)
        for i in range(times.shape[0]):
            found[i] = state_at(way, times[i])
        found[times.shape[0]] = end

    times, start = 0.1 + np.linspace(0.0, STEP, 21), oracles.start_of(case)
    inputs = [
        wp.array(pack_bodies([run]), dtype=Swimmer, device="cpu"),
        pack_drives([run], "cpu"),
        wp.array(pack_magnets([run])[0], dtype=FieldSource, device="cpu"),
        wp.array(start[None], dtype=State, device="cpu"),
        wp.array(times, dtype=wp.float64, device="cpu"),
    ]
    out = wp.zeros(times.size + 1, dtype=State, device="cpu")
    wp.launch(stepped, dim=1, inputs=[*inputs, out], device="cpu")
    found, end = out.numpy()[:-1], out.numpy()[-1]

    theirs = SCIPY_DOP853(oracles.right_hand_side(case), 0.1, start, 1.0, first_step=STEP, rtol=1.0, atol=1e9)
    theirs.step()
    expected = theirs.dense_output()(times).T
    expected[:, 3:] /= np.linalg.norm(expected[:, 3:], axis=1, keepdims=True)
    moved = np.abs(expected[-1] - expected[0])
    assert moved[:3].max() > 5e-6
    assert moved[3:].max() > 0.1
    assert np.abs(found[:, :3] - expected[:, :3]).max() < 1e-13
    assert np.abs(found[:, 3:] - expected[:, 3:]).max() < 2e-10  # they take quaternions of other lengths within it
    np.testing.assert_allclose(found[-1], end, rtol=0.0, atol=1e-15)


def test_samples_within_steps_are_exact_within_the_tolerance(fine, exact):
    """Beside a run at 1e-11 whose steps end at each sample."""
    assert exact.steps > 10 * fine.steps
    assert np.abs(fine.states[:, :3] - exact.states[:, :3]).max() < 1e-9
    assert np.abs(fine.states[:, 3:] - exact.states[:, 3:]).max() < 1e-6
    np.testing.assert_allclose(np.linalg.norm(fine.states[:, 3:], axis=1), 1.0, rtol=0.0, atol=1e-15)


def test_samples_ask_for_hardly_any_steps(fine):
    """Steps are four fifths of what error control allows and end with a sample, but hardly any is rejected."""
    second = directly(scenario(interval=1.0))
    trials, fewest = (history.steps + history.rejected for history in (fine, second))
    assert fine.time.size == 5001
    assert trials < 1.1 * fewest


@pytest.mark.parametrize("share", [0.6, 1.0, 1.5, 4.0])
def test_longer_intervals_are_landed_on_as_before(share):
    """From half the longest step on, an eighth of a turn: to the same bits as without dense output."""
    run = scenario(interval=share / (8.0 * 3.3))
    np.testing.assert_array_equal(directly(run).records, directly(run, method=LANDING).records)


def test_statistics_of_short_intervals_make_up_those_of_long_ones(fine, exact):
    """Extremes are those of the long ones, and means Simpson's integrals of what was sampled."""
    second, per = directly(scenario(interval=1.0), tolerance=1e-11), round(1.0 / FINE)
    low, high = (fine.records[name][1:].reshape(-1, per) for name in ("low", "high"))
    np.testing.assert_allclose(low.min(axis=1), second.records["low"][1:], rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(high.max(axis=1), second.records["high"][1:], rtol=0.0, atol=1e-9)
    for name in ("low", "high"):
        np.testing.assert_allclose(fine.records[name], exact.records[name], rtol=0.0, atol=1e-9)
    assert np.all(fine.records["low"] <= fine.states[:, 2])
    assert np.all(fine.records["high"] >= fine.states[:, 2])
    axes = np.array([oracles.matrix_of(state[3:])[:, 0] for state in exact.states])
    attack = np.arcsin(axes[:, 2])
    sampled = {"height": (exact.states[:, 2], 2e-9), "attack": (attack, 5e-8), "square": (attack**2, 5e-8)}
    for name, (values, atol) in sampled.items():
        for one in range(5):
            mean = simpson(values[one * per : (one + 1) * per + 1], dx=FINE)
            assert fine.records[name][1 + one * per : 1 + (one + 1) * per].mean() == pytest.approx(mean, abs=atol)


def test_events_are_found_alike_and_no_sample_comes_after_one():
    """A device that is pulled against the magnet."""
    changes = {"distance": 0.040, "beta": np.radians(5.0)}
    ours, theirs = (directly(scenario(30.0, interval, **changes)) for interval in (FINE, 1.0))
    assert ours.status is theirs.status is End.CONTACT
    assert ours.time[-1] == pytest.approx(theirs.time[-1], abs=5e-6)
    np.testing.assert_array_equal(ours.time[:-1], FINE * np.arange(ours.time.size - 1))
    assert 0.0 < ours.time[-1] - ours.time[-2] <= FINE + 1e-12
    run = ours.scenario
    magnet = observed(run, ours.time, ours.states)["rpm_position"]
    gaps = np.linalg.norm(ours.states[:, :3] - magnet, axis=1) - pack_bounds([run])["contact"][0]
    assert gaps[:-1].min() > 0.0 >= gaps[-1] > -1e-6
    assert ours.records["low"][-1] <= ours.states[-1, 2] <= ours.records["high"][-1]


def test_slips_are_counted_at_the_sample_they_come_before():
    """A magnet that is too fast: the phase lag of samples says when the field went behind the moment."""
    history = directly(scenario(5.0, frequency=15.0, moment=6.23e-5))
    lag = observed(history.scenario, history.time, history.states)["phase_lag"]
    front = np.cos(lag) > 0.0
    behind = ~front[:-1] & ~front[1:] & (np.sin(lag[:-1]) * np.sin(lag[1:]) <= 0.0)
    expected, locked = [0.0], False
    for now, passed in zip(front[1:], behind, strict=True):
        locked = locked or now
        expected.append(expected[-1] + (locked and passed))
        locked = locked and not passed
    assert expected[-1] > 20
    np.testing.assert_array_equal(history.slips, expected)


def test_they_do_not_depend_on_where_launches_end_nor_on_other_runs(monkeypatch, fine):
    others = [scenario(2.0, 0.003, frequency=8.0), fine.scenario, scenario(3.0, 7e-4, distance=0.13)]
    together = advance(others, method=DOP853)
    np.testing.assert_array_equal(together[1].records, fine.records)
    monkeypatch.setattr(running_module, "FIRST_BUDGET", 3)
    monkeypatch.setattr(running_module, "LAUNCH_SECONDS", 1e-6)
    for whole, cut in zip(together, advance(others, method=DOP853), strict=True):
        np.testing.assert_array_equal(cut.records, whole.records)
        np.testing.assert_array_equal(cut.time, whole.time)
        assert (cut.steps, cut.rejected) == (whole.steps, whole.rejected)


def test_a_path_that_was_sampled():
    """Between points of the path, where the motion has kinks of a higher order."""
    time = np.linspace(0.0, 3.0, 31)
    place = np.stack([2e-3 * np.sin(time), 1e-3 * time - 0.045, 0.15 + 1e-3 * np.cos(2.0 * time)], axis=1)
    path = {"time": time.tolist(), "position": place.tolist()}
    changes = {"drive.path": path, "drive.yaw_rate": 0.0, "drive.velocity": (0.0, 0.0, 0.0)}
    ours, exact = (scenario(3.0, interval).replaced(changes) for interval in (FINE, COARSE))
    found = directly(ours).states[:: round(COARSE / FINE)]
    expected = directly(exact, tolerance=1e-11).states
    assert np.abs(found[:, :3] - expected[:, :3]).max() < 2e-9


def test_runs_that_leap_have_the_same_samples():
    """Samples within direct steps before leaps begin, and within leaps after that."""
    (leaping,) = advance([scenario(15.0)])
    exact = directly(scenario(15.0, COARSE), tolerance=1e-11)
    assert 0.3 < leaping.leapt < 1.0
    found = leaping.states[:: round(COARSE / FINE)]
    assert np.abs(found[:, :3] - exact.states[:, :3]).max() < 2e-8


def test_no_step_has_more_than_a_thousand_samples():
    """One would be enough for this run; a launch, which cannot be heard within a step, would last for all of them."""
    run = scenario(0.01, 1e-6, frequency=0.02)
    history = directly(run)
    assert history.time.size == 10001
    assert history.steps >= 10
    exact = directly(scenario(0.01, 0.005, frequency=0.02), tolerance=1e-11)
    assert np.abs(history.states[::5000, :3] - exact.states[:, :3]).max() < 1e-10
