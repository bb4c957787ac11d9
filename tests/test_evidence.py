"""No verdict on too little: what a run must have lasted and shown before it is called bounded."""

import dataclasses
import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import command_line
from helimag.engine import advance, simulate, slow_times
from helimag.hydrodynamics import net_weight, resistance
from helimag.outcomes import End, Reason, Verdict
from helimag.runs import Heights, SlowTimes, judge
from helimag.scenario import load

TIME = np.linspace(0.0, 1800.0, 1801)
GAP = 0.150
SLOW = SlowTimes(lap=200.0, fold=150.0)


def heights(mean, *, time=TIME, slow=SLOW, end=End.HORIZON):
    mean = np.broadcast_to(np.asarray(mean, float), time.shape).copy()
    level = np.zeros_like(mean)
    return Heights(
        time=time,
        low=mean,
        high=mean,
        mean=mean,
        attack=level,
        attack_square=level,
        slips=0,
        initial_gap=GAP,
        end=end,
        slow=slow,
    )


def settling(time=TIME):
    return -0.02 * (1.0 - np.exp(-time / 100.0))


# --- how slow a scenario is


@pytest.mark.parametrize("name", ["nose-first/fig3a", "nose-first/fig3c", "nose-first/table1-row1"])
def test_errors_of_height_grow_as_in_the_balance_of_pull_and_weight(name):
    """Velocity by height, W ((d / z)^4 - 1) over the drag of a level device, differentiated by numbers at z = d."""
    scenario = load(name)
    matrix, (weight, _) = resistance(scenario.device, scenario.fluid), net_weight(scenario.device, scenario.fluid)
    level = [np.linalg.solve(matrix[:3, :3], weight * axis) @ axis for axis in np.eye(3)[1:]]
    gap = scenario.drive.distance if scenario.drive.pitch_about == "magnet" else None
    if gap is None:  # pitched about the origin: the magnet starts on an arc about it
        gap = math.hypot(scenario.drive.distance * math.sin(scenario.drive.pitch), 0.0)
        gap = math.hypot(gap, scenario.drive.distance * math.cos(scenario.drive.pitch))

    def rising(z):
        return np.mean(level) * ((gap / z) ** 4 - 1.0)

    rate = (rising(gap - 1e-6) - rising(gap + 1e-6)) / 2e-6
    assert slow_times(scenario).fold == pytest.approx(1.0 / rate, rel=1e-6)


def test_laps_are_those_of_the_yaw():
    assert slow_times(load("nose-first/fig3c")).lap == pytest.approx(200.0)
    assert slow_times(load("nose-first/fig3c").replaced({"drive.yaw_rate": "-3.6 deg/s"})).lap == pytest.approx(100.0)
    assert slow_times(load("nose-first/table1-row1")).lap is None


def test_laps_on_a_path_are_those_of_its_usual_yaw():
    """A path at 2 deg/s with a quick turn back: 180 s a lap, whatever it unwinds."""
    path = {
        "position": [["0 mm", "0 mm", "150 mm"]] * 4,
        "time": ["0 s", "90 s", "95 s", "185 s"],
        "yaw": ["0 deg", "180 deg", "0 deg", "180 deg"],
    }
    scenario = load("nose-first/fig3c").replaced(
        {"drive.yaw_rate": "0 deg/s", "drive.path": path, "run.duration": "185 s"}
    )
    assert slow_times(scenario).lap == pytest.approx(180.0)


def test_a_weightless_device_is_as_slow_as_its_pull():
    """The force between antiparallel dipoles side by side is the gradient of their energy, here by differences."""
    scenario = load("nose-first/fig3c").replaced({"device.weight.net_weight": "0 N", "drive.pitch": "0 deg"})
    here, there = scenario.device.magnetic_moment, scenario.magnet[0].dipole_moment

    def energy(z):
        return -1e-7 * here * there / z**3

    force = (energy(0.15 + 1e-6) - energy(0.15 - 1e-6)) / 2e-6
    drag = np.linalg.inv(resistance(scenario.device, scenario.fluid)[:3, :3])
    speed = force * (drag[1, 1] + drag[2, 2]) / 2.0
    assert slow_times(scenario).fold == pytest.approx(0.15 / (4.0 * speed), rel=1e-6)


def test_the_slowest_decides():
    assert SlowTimes(lap=200.0, fold=150.0).decisive == 1000.0
    assert SlowTimes(lap=100.0, fold=150.0).decisive == 900.0
    assert SlowTimes(lap=None, fold=150.0).decisive == 900.0


# --- runs that show too little


@pytest.mark.parametrize("name", ["nose-first/fig3a", "nose-first/fig3b", "nose-first/fig3c"])
@pytest.mark.parametrize("duration", ["5 s", "1 s", "120 s", 1e-9])
def test_a_short_run_is_undecided(name, duration):
    judgement = simulate(load(name), duration=duration).judgement
    assert (judgement.verdict, judgement.cause) == (Verdict.UNDECIDED, Reason.TOO_SHORT)
    assert "run 1000 s or more (run.duration)" in judgement.reason


def test_a_run_in_which_nothing_moves_is_undecided():
    judgement = simulate(load("nose-first/fig3c").replaced({"fluid.viscosity": "1e6 Pa s"})).judgement
    assert (judgement.verdict, judgement.cause) == (Verdict.UNDECIDED, Reason.NOTHING_MOVES)
    assert "fluid.viscosity" in judgement.reason


def test_a_run_far_out_of_the_magnets_reach_is_undecided():
    """It sinks by less than half a metre of the ninety that it would fall."""
    judgement = simulate(load("nose-first/fig3c").replaced({"drive.distance": "90 m"})).judgement
    assert (judgement.verdict, judgement.cause) == (Verdict.UNDECIDED, Reason.TOO_SHORT)


def test_fig3c_is_not_bounded_and_slower_spinning_is():
    """Fig. 3(C) is inside for 1800 s and pulled in at 2275 s; at 2.5 Hz a device comes to a stable orbit."""
    base = load("nose-first/fig3c")
    slower = base.replaced({"drive.frequency": "2.5 Hz"})
    longer = base.replaced({"run.duration": "3000 s"})
    published, bounded, later = (history.judge() for history in advance([base, slower, longer]))
    assert published.verdict is Verdict.DRIFTING
    assert bounded.verdict is Verdict.BOUNDED
    assert later.verdict is Verdict.ATTRACTED
    assert later.end_time == pytest.approx(2275.0, abs=5.0)


def test_a_stored_run_keeps_its_verdict(tmp_path):
    run = simulate(load("nose-first/fig3c"), duration="5 s")
    run.save(tmp_path / "run.nc")
    again = type(run).load(tmp_path / "run.nc")
    assert again.heights.slow == slow_times(load("nose-first/fig3c"))
    assert again.judgement.reason == run.judgement.reason
    assert again.verdict is Verdict.UNDECIDED


def test_the_command_says_undecided():
    status, out, _ = command_line.run("simulate", "nose-first/fig3c", "--duration", "5 s", "--no-orbit", "--json")
    assert status == 0
    assert json.loads(out)["verdict"] == "undecided"
    assert "too short" in json.loads(out)["reason"]


@given(st.floats(1e-320, 999.0), st.floats(0.0, 0.02), st.integers(2, 400))
def test_no_heights_make_a_short_run_bounded(duration, depth, samples):
    time = np.linspace(0.0, duration, samples)
    mean = -depth * (1.0 - np.exp(-time / (duration / 20.0)))
    assert judge(heights(mean, time=time)).verdict is Verdict.UNDECIDED


@pytest.mark.parametrize("end", [End.CONTACT, End.FALL, End.FLOOR])
def test_a_short_run_that_ended_is_decided(end):
    time = np.linspace(0.0, 20.0, 50)
    judgement = judge(heights(-0.3 * time / 20.0, time=time, end=end))
    assert judgement.cause is end.cause


def test_a_run_of_unknown_slowness_is_undecided():
    """A measured run shows that it moves, but not that nothing slower is going on."""
    calm = judge(heights(settling(), slow=None))
    assert (calm.verdict, calm.cause) == (Verdict.UNDECIDED, Reason.SLOWNESS_UNKNOWN)
    assert judge(heights(-0.03 * TIME / 1800.0, slow=None)).cause is Reason.STILL_SINKS


# --- long runs in which something grows that is small yet


def swing(doubling, amplitude=2e-4):
    """A swing of 200 s that is doubled in so many seconds, with this amplitude (m) at the end."""
    return amplitude * np.exp((TIME - 1800.0) * math.log(2.0) / doubling) * np.sin(2.0 * np.pi * TIME / 200.0)


@pytest.mark.parametrize("doubling", [300.0, 1000.0, 4000.0])
def test_a_small_swing_that_grows_is_not_bounded(doubling):
    """0.2 mm of 150 mm: a run that looks settled for 1800 s and fell at 5355 s swung so."""
    judgement = judge(heights(settling() + swing(doubling)))
    assert (judgement.verdict, judgement.cause) == (Verdict.UNDECIDED, Reason.SWINGS_ON)


@pytest.mark.parametrize("doubling", [-300.0, -1000.0, -4000.0])
def test_a_small_swing_that_dies_out_is_bounded(doubling):
    assert judge(heights(settling() + swing(doubling))).cause is Reason.SETTLED


def test_a_steady_slow_rise_is_not_bounded():
    """0.15 mm in 100 s, which a large coming to rest hides from the quarters' means; with 0.4 mm one was pulled in."""
    judgement = judge(heights(0.06 * (1.0 - np.exp(-TIME / 140.0)) + 1.5e-6 * TIME))
    assert judgement.cause is Reason.MOVES_ON
    assert judge(heights(0.06 * (1.0 - np.exp(-TIME / 140.0)))).cause is Reason.SETTLED


def test_noise_of_measurement_does_not_look_like_growth():
    """White noise of 0.1 mm, with slow times known as beside a simulated run: at most one in a hundred."""
    random = np.random.default_rng(0)
    runs = [heights(settling() + 1e-4 * random.standard_normal(TIME.size)) for _ in range(100)]
    assert sum(judge(run).verdict is Verdict.BOUNDED for run in runs) >= 97


def test_too_few_samples_in_one_quarter_are_too_few():
    some = np.r_[np.arange(0, 1300), 1500, 1800]
    run = heights(settling()[some], time=TIME[some])
    assert judge(run).cause is Reason.TOO_FEW_SAMPLES


def test_a_copy_with_other_slow_times_is_judged_by_them():
    run = heights(settling())
    assert judge(run).verdict is Verdict.BOUNDED
    slower = dataclasses.replace(run, slow=SlowTimes(lap=400.0, fold=150.0))
    assert judge(slower).cause is Reason.TOO_SHORT
    assert "run 2000 s or more" in judge(slower).reason


@pytest.mark.parametrize(
    ("slow_growth", "share", "verdict"),
    [(1.0 / 8000.0, 1.0, Verdict.UNDECIDED), (-1.0 / 8000.0, 1.0, Verdict.UNDECIDED), (0.0, 0.0, Verdict.BOUNDED)],
)
def test_a_slow_swing_beneath_one_that_dies_out_is_not_overlooked(slow_growth, share, verdict):
    """Run 106 of seed 132: it shrank by 6 % in its last quarter, grew e-fold in 8,000 s, and fell after 17,300 s."""
    turning = 2.0 * np.pi * TIME / 175.0
    fast = 1.5e-3 * np.exp(-TIME / 250.0) * np.sin(turning)
    slow = 5e-4 * share * np.exp(slow_growth * TIME) * np.cos(turning)
    judged = judge(heights(settling() + fast + slow))
    assert judged.verdict is verdict
    assert (judged.cause is Reason.SWINGS_ON) is (share > 0.0)


def test_swings_that_die_out_evenly_are_bounded():
    """By a fifth a quarter, as beside most stable orbits of the paper's circles."""
    swing = 2e-3 * np.exp(-TIME / 1900.0) * np.sin(2.0 * np.pi * TIME / 202.0)
    assert judge(heights(settling() + swing)).verdict is Verdict.BOUNDED
