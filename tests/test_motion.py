"""Runs against closed forms, dissipation along a run, and the measured order of the integrator."""

import numpy as np
import pytest
import warp as wp

import helimag as hm
import oracles
from helimag.engine import DOP853, advance, system_of
from helimag.engine.batch import Stepping, packed
from helimag.engine.loop import build_advance
from helimag.engine.observe import observed
from helimag.engine.progress import Progress
from helimag.engine.samples import Record
from helimag.engine.structures import structs
from helimag.engine.turn_memory import pack_memory

DIAGONAL = np.diag([0.10, 0.13, 0.13, 8e-9, 6e-6, 6e-6])
NO_MAGNET = {"moment": 1e-30, "yaw": 0.0, "velocity": (0.0, 0.0, 0.0), "start": (0.0, 0.0, 0.0)}


def test_sedimentation_sideways():
    """A tilted rod of diagonal resistance, held at its centre, drifts sideways as it sinks, for ever alike."""
    c = oracles.case(**NO_MAGNET, matrix=DIAGONAL, gravity_center=0.0, weight=3e-5)
    q = np.array([np.cos(0.4), 0.1, -np.sin(0.4), 0.2])
    rotation = oracles.matrix_of(q)
    velocity = rotation @ (rotation.T @ [0, 0, -3e-5] / np.diag(DIAGONAL)[:3])
    state = np.array([1e-3, 2e-3, 3e-3, *q])
    run = oracles.run(c, 200.0, initial_state=state)
    np.testing.assert_allclose(run.final_state[:3], state[:3] + 200.0 * velocity, rtol=0, atol=1e-14)
    assert oracles.attitude_difference(run.final_state[3:], q) < 1e-14
    assert abs(velocity[0]) > 1e-5  # it does drift
    np.testing.assert_allclose(
        run.dataset.height_mean.values[1:],
        (run.dataset.position.values[1:, 2] + run.dataset.position.values[:-1, 2]) / 2,
        atol=1e-14,
    )


def test_sedimentation_of_the_helix_begins_with_mobility_times_weight():
    c = oracles.case(**NO_MAGNET)
    load = np.array([0, 0, -c["weight"], 0, c["gravity_center"] * c["weight"], 0])  # the torque of a weight behind
    motion = np.linalg.solve(oracles.resistance(c), load)
    end = oracles.run(c, 1e-6).final_state
    np.testing.assert_allclose(end[:3] / 1e-6, motion[:3], rtol=1e-4, atol=1e-9)
    np.testing.assert_allclose(2 * end[4:] / 1e-6, motion[3:], rtol=1e-4, atol=1e-6)


def test_heavy_tail_turns_the_nose_up():
    """An overdamped pendulum: theta' = (W l / d) cos theta, so tan(theta/2 + pi/4) grows exponentially."""
    c = oracles.case(**NO_MAGNET, matrix=DIAGONAL, weight=3e-5, gravity_center=-2e-3)
    run = oracles.run(c, 150.0)
    rate = 3e-5 * 2e-3 / DIAGONAL[4, 4]
    theta = 2 * np.arctan(np.exp(rate * run.dataset.time.values)) - np.pi / 2
    assert theta[-1] > 0.8
    np.testing.assert_allclose(run.dataset.attack_angle.values, theta, atol=1e-7)


# The one place where a spinning dipole's field turns uniformly is on its axis. From afar it is uniform in space too.
FAR = 90.0  # m
SPIN_DRAG = 8e-9
CREEP = {"about": "magnet", "beta": 0.0, "yaw": 0.0, "start": (0.0, 0.0, 0.0), "weight": 0.0, "gravity_center": 0.0}


def on_axis_case(step_out, frequency):
    """A roller in a field that turns uniformly about its long axis; ``step_out`` in rad/s."""
    field = step_out * SPIN_DRAG / 6.23e-4
    magnet = ((FAR, 0.0, -0.150), field * FAR**3 / 1e-7)
    return oracles.case(**CREEP, matrix=DIAGONAL, magnets=[magnet], frequency=frequency, distance=0.150)


def roll(trajectory):
    """Roll angle about x, unwrapped."""
    _, _, _, w, x, _, _ = oracles.states_of(trajectory).T
    return np.unwrap(2 * np.arctan2(x, w), period=2 * np.pi)


@pytest.mark.parametrize(("method", "within"), [("direct", 1e-6), ("multirevolution", 1e-4)])  # rad
def test_in_step_the_roller_lags_by_a_constant_angle(method, within):
    """sin(lag) = omega / step-out; leaps take the roll from turns of twelve steps."""
    run = oracles.run(on_axis_case(30.0, 2.0), 20.0, interval=0.01, method=method)
    lag = run.dataset.phase_lag.values
    np.testing.assert_allclose(lag[-100:], np.arcsin(2 * np.pi * 2.0 / 30.0), atol=within)
    rolled = roll(run)
    assert rolled[-1] - rolled[-51] == pytest.approx(2 * np.pi * 2.0 * 0.5, abs=within)
    assert run.judgement.slips == 0


@pytest.mark.parametrize("frequency", [2.0, -2.0])
def test_beyond_step_out(frequency):
    """The lag turns at the mean rate sqrt(omega^2 - step_out^2); each turn of it is a slip."""
    omega, step_out, slips = 2 * np.pi * 2.0, 10.0, 9
    period = 2 * np.pi / np.sqrt(omega**2 - step_out**2)
    run = oracles.run(on_axis_case(step_out, frequency), slips * period, interval=0.01)
    rolled = np.sign(frequency) * (roll(run)[-1] - roll(run)[0])
    assert rolled == pytest.approx(omega * slips * period - 2 * np.pi * slips, abs=2e-5)
    assert rolled / (slips * period) == pytest.approx(omega - np.sqrt(omega**2 - step_out**2), rel=1e-5)
    # it starts exactly behind the field, which is no slip; so the last of the nine has just not happened or just has
    assert run.judgement.slips in (slips - 1, slips)
    longer = oracles.run(on_axis_case(step_out, frequency), (slips + 0.5) * period)
    assert longer.judgement.slips == slips


@pytest.mark.parametrize(("name", "duration"), [("nose-first/fig3b", 130.0), ("nose-first/fig3c", 150.0)])
def test_slips_are_those_of_a_fine_record_of_the_lag(name, duration):
    """Where the field swings nearly along the device's axis it goes from front to back within a step, and counts."""
    scenario = hm.load(name).replaced({"run.duration": duration})
    (fine,) = advance([scenario.replaced({"run.interval": 0.002})], tolerance=1e-10)
    lag = observed(scenario, fine.time, fine.states)["phase_lag"]
    turns = np.floor(np.unwrap(lag) / (2.0 * np.pi) + 0.5)
    slips, since = 0, 0
    for passage in np.flatnonzero(np.diff(turns)):
        if (np.cos(lag[since : passage + 1]) > 0.0).any():
            slips, since = slips + 1, passage + 1
    assert slips > 30
    (steps,), (rough,) = advance([scenario], tolerance=1e-10), advance([scenario])
    assert (fine.slips[-1], steps.slips[-1]) == (slips, slips)
    assert abs(rough.slips[-1] - slips) <= 1  # whose places are others by then


def test_dissipation_is_positive_along_a_run():
    """What the loads do on the motion found by differences is positive, and equals what the fluid takes."""
    c = oracles.case()
    run = oracles.run(c, 3.0, interval=1e-4)
    states, times = oracles.states_of(run), run.dataset.time.values
    matrix = oracles.resistance(c)
    for i in range(100, len(times) - 2, 997):
        rotation = oracles.matrix_of(states[i, 3:])
        velocity = (8 * (states[i + 1, :3] - states[i - 1, :3]) - states[i + 2, :3] + states[i - 2, :3]) / 12e-4
        turns = [oracles.matrix_of(states[i + k, 3:]) for k in (-2, -1, 1, 2)]
        spin = (8 * (turns[2] - turns[1]) - turns[3] + turns[0]) / 12e-4 @ rotation.T
        omega = np.array([spin[2, 1], spin[0, 2], spin[1, 0]])
        force, torque = oracles.loads(c, times[i], states[i, :3], rotation)
        power = force @ velocity + torque @ omega
        motion = np.concatenate([rotation.T @ velocity, rotation.T @ omega])
        assert power > 0.0
        assert power == pytest.approx(motion @ matrix @ motion, rel=1e-5)


def fixed_steps(c, duration, steps):
    """The final state with equal steps: no tolerance can be missed, and the longest step is what is asked for."""
    scenario = oracles.scenario_of(c, f'[run]\nduration = "{duration!r} s"\ninterval = "{duration!r} s"')
    system = system_of(scenario)
    progress = wp.array(structs(Progress, [{"state": oracles.start_of(c), "step": 1.0}]), dtype=Progress, device="cpu")
    records = wp.zeros((1, 2), dtype=Record, device="cpu")
    runs = packed(system, [scenario], Stepping(DOP853, 1e300), progress, records, pack_memory((), "cpu"))
    control = runs.controls.numpy()
    control["longest"] = duration / steps * (1 + 1e-12)
    runs.controls.assign(control)
    wp.launch(build_advance(system, DOP853), dim=1, inputs=[runs, 2 * steps], device="cpu")
    end = progress.numpy()[0]
    assert end["steps"] == steps
    assert end["rejected"] == 0
    return end["state"]


def test_order_of_convergence():
    """Halving the step divides the error by 2^8."""
    c = oracles.case()
    turns = 4
    exact = fixed_steps(c, turns / 3.3, turns * 96)
    counts = np.array([14, 18, 22, 28, 34])
    errors = [
        np.linalg.norm((fixed_steps(c, turns / 3.3, turns * n) - exact) / ([0.0117] * 3 + [1] * 4)) for n in counts
    ]
    order = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert errors[-1] > 1e-12  # well above rounding
    assert 7.6 < order < 8.6, (order, errors)
    np.testing.assert_allclose(exact[:3], oracles.solve(c, [turns / 3.3], rtol=1e-12).y[:3, 0], atol=1e-13)


def test_tighter_tolerance_is_closer():
    """Errors after 20 s fall with the tolerance, nearly in proportion."""
    c = oracles.case()
    ends = [oracles.run(c, 20.0, interval=20.0, tolerance=t).final_state for t in (1e-5, 1e-7, 1e-9, 1e-12)]
    errors = [np.abs(end - ends[-1])[:3].max() for end in ends[:-1]]
    assert errors[0] > 20 * errors[1] > 400 * errors[2]


def test_falling_in_from_behind_is_no_slip():
    """A moment that starts behind the field and is overtaken once, before it has ever been in step, has not slipped."""
    start = [0.0, 0.0, 0.0, np.cos(0.1), np.sin(0.1), 0.0, 0.0]  # the field is 0.2 rad short of opposite
    run = oracles.run(on_axis_case(30.0, 2.0), 10.0, interval=0.01, initial_state=start)
    lag = np.unwrap(run.dataset.phase_lag.values)
    assert lag[0] == pytest.approx(np.pi - 0.2)
    assert lag[-1] == pytest.approx(2 * np.pi + np.arcsin(2 * np.pi * 2.0 / 30.0), abs=1e-6)
    assert run.judgement.slips == 0
