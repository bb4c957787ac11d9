"""Leaps over turns of the magnet, held against direct steps at a tolerance of 1e-11."""

from contextlib import closing

import numpy as np
import pytest
import warp as wp
from scipy.spatial.transform import Rotation

import helimag as hm
import oracles
from helimag.engine import DOP853, MULTIREVOLUTION, accuracy_of, advance, advancing
from helimag.engine.charts import Place, far_off, from_chart, to_chart
from helimag.engine.filling import Level, looked_through
from helimag.engine.leaps import remembered
from helimag.engine.progress import Leap
from helimag.engine.samples import Statistics, turned_within
from helimag.engine.turn_memory import Heights, Memory, Weights, heights_between, pack_memory
from helimag.engine.turns import Nodes, Shape
from helimag.outcomes import End
from helimag.physics.kinematics import State

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
    (exact,), (leaping,) = advance([run], method=DOP853, tolerance=1e-11), advance([run])
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
    assert leaping.steps < 0.5 * advance([leaping.scenario], method=DOP853)[0].steps


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


def test_extremes_are_found_between_ends_of_steps_and_looks(random_runs):
    """Beside samples two hundred times a turn; at ends alone they would be 3e-7 m off directly, and 6e-8 m by leaps."""
    run = random_runs.random_run(0)[1].replaced({"run.duration": 40.0, "run.interval": 4.0})
    dense = run.replaced({"run.interval": 0.005 / run.drive.frequency})
    (exact,) = advance([dense], method=DOP853, tolerance=1e-9)
    for method, least in ((DOP853, 0.0), (MULTIREVOLUTION, 0.9)):
        (history,) = advance([run], method=method)
        assert history.leapt >= least
        for name, edge in (("low", np.min), ("high", np.max)):
            assert edge(history.records[name]) == pytest.approx(edge(exact.states[:, 2]), rel=0.0, abs=3e-8), name


def test_a_height_turns_where_the_cubic_through_its_ends_does():
    """Random cubics over a step, by NumPy's roots; where rates have one sign there is nothing to find."""
    rng = np.random.default_rng(3)
    turned = 0
    for _ in range(200):
        cubic = np.polynomial.Polynomial(rng.normal(size=4))
        rate = cubic.deriv()
        stats = Statistics()
        stats.low, stats.high = min(cubic(0.0), cubic(1.0)), max(cubic(0.0), cubic(1.0))
        ends = (cubic(0.0), rate(0.0), cubic(1.0), rate(1.0))
        found = turned_within(stats, *(wp.float64(float(end)) for end in ends))
        there = np.array([cubic(0.0), cubic(1.0)])
        if rate(0.0) * rate(1.0) < 0.0:
            roots = rate.roots()
            there = np.append(there, cubic(roots[np.isreal(roots) & (roots.real > 0.0) & (roots.real < 1.0)].real))
            turned += 1
        assert [float(found.low), float(found.high)] == pytest.approx([there.min(), there.max()], rel=0.0, abs=1e-9)
    assert 50 < turned < 150


@wp.kernel(enable_backward=False, module="unique")
def keep_two(memory: Memory, ends: wp.array(dtype=State), heights: wp.array(dtype=Heights)):
    leap = Leap()
    weights = Weights()
    beginning = State()
    beginning[3] = wp.float64(1.0)
    for turn in range(ends.shape[0]):
        leap.pushes = turn
        leap.aim = beginning
        shape = Shape()
        for node in range(12):
            for i in range(7):
                shape[node, i] = ends[turn][i]
        remembered(memory, 0, leap, ends[turn], shape)
    weights[0] = wp.float64(1.0)
    heights[0] = heights_between(memory, 0, weights)


def test_a_turn_whose_numbers_broke_down_is_in_no_leap():
    """Neither as one that counts nothing."""
    ends = np.array([[0.0, 0.0, 2.0, 1.0, 0.0, 0.0, 0.0], [np.nan] * 7])
    memory, heights = pack_memory([{}], "cpu"), wp.zeros(1, dtype=Heights, device="cpu")
    wp.launch(keep_two, dim=1, inputs=[memory, wp.array(ends, dtype=State, device="cpu"), heights], device="cpu")
    np.testing.assert_allclose(heights.numpy()[0, 1::2], 2.0 * (1.0 - np.arange(1, 13) / 12), rtol=0.0, atol=1e-12)


LOOKS = 24  # at a turn that was leapt over, from the first after its begin to its end


@wp.kernel(enable_backward=False, module="unique")
def look_through(
    turns: wp.array(dtype=Heights), attacks: wp.array(dtype=Nodes), level: Level, found: wp.array(dtype=Statistics)
):
    run = wp.tid()
    begun, period = Statistics(), wp.float64(0.5)
    begun.low = level.height + turns[run][LOOKS - 1]
    begun.high = begun.low
    begun.last_height = begun.low
    begun.last_attack = level.attack + attacks[run][LOOKS // 2 - 1]
    stop = run % (LOOKS + 1)
    start = wp.float64(3.0)
    some, last = looked_through(begun, level, turns[run], attacks[run], start, period, 0, stop, start)
    all, last = looked_through(some, level, turns[run], attacks[run], start, period, stop, LOOKS, last)
    found[run] = all


def test_looks_at_a_turn_give_its_extremes_and_means_wherever_it_is_interrupted():
    """Cosines that begin anywhere, on a slope: extremes by parabolas through three looks, means by the trapezoid."""
    begins, rise = np.linspace(0.0, 2.0 * np.pi, 75, endpoint=False), 0.1
    begins = begins[np.mod(-begins, np.pi) > 1.1 * np.pi / LOOKS]  # sooner, the turn before has it
    phases = 2.0 * np.pi * np.arange(1, LOOKS + 1) / LOOKS
    turns, nodes = (np.cos(begins[:, None] + at) for at in (phases, phases[1::2]))
    level = Level()
    level.height, level.rise, level.attack, level.climb = 5.0, rise, 0.2, 0.0
    found = wp.zeros(len(begins), dtype=Statistics, device="cpu")
    inputs = [wp.array(turns, dtype=Heights, device="cpu"), wp.array(nodes, dtype=Nodes, device="cpu"), level, found]
    wp.launch(look_through, dim=len(begins), inputs=inputs, device="cpu")
    stats = found.numpy()
    fine = np.linspace(0.0, 1.0, 20001)
    exact = 5.0 + rise * fine + np.cos(begins[:, None] + 2.0 * np.pi * fine)
    np.testing.assert_allclose(stats["low"], exact.min(axis=1), rtol=0.0, atol=5e-4)
    np.testing.assert_allclose(stats["high"], exact.max(axis=1), rtol=0.0, atol=5e-4)
    np.testing.assert_allclose(stats["height"], 0.5 * (5.0 + 0.5 * rise), rtol=1e-12)
    np.testing.assert_allclose(stats["attack"], 0.5 * 0.2, rtol=1e-12)
    np.testing.assert_allclose(stats["square"], 0.5 * (0.2**2 + 0.5), rtol=1e-12)
    np.testing.assert_allclose(stats["last_height"], exact[:, -1], rtol=1e-12)


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
    (direct,), (leaping,) = advance([run], method=DOP853), advance([run])
    assert direct.slips[-1] > 3
    assert leaping.leapt == 0.0
    np.testing.assert_array_equal(direct.states, leaping.states)


def test_what_comes_to_nothing_is_tried_ever_more_rarely():
    """This run has hardly a turn to leap over: what it follows for leaps is to cost less than its steps."""
    (leaping,) = advance([hm.load("paper/table1-row3")])
    assert leaping.leapt < 0.1
    assert 12 * leaping.progress["leap"]["followed"] < 0.6 * (leaping.steps + leaping.rejected)


def test_runs_of_few_turns_are_stepped_directly_from_the_start():
    """Alone and among others, bit for bit: 36 turns is where leaps begin to pay."""
    runs = [scenario(f"{turns / 3.3!r} s", **TAIL_FIRST) for turns in (35.9, 80.0, 3.3)]
    together, direct = advance(runs), advance(runs, method=DOP853)
    alone = [advance([run])[0] for run in runs]
    for few in (0, 2):
        assert together[few].progress["leap"]["followed"] == 0
        for history in (together[few], alone[few]):
            np.testing.assert_array_equal(history.records, direct[few].records)
    assert together[1].leapt > 0.5
    np.testing.assert_array_equal(together[1].records, alone[1].records)
    told = hm.simulate(runs[0]).dataset.attrs
    assert told["integrator"] == "DOP853, adaptive"
    assert "turns_followed_for_leaps" not in told


def test_no_leaps_where_no_frame_moves_with_the_drive():
    run = scenario("30 s", **TAIL_FIRST | {"velocity": (1e-4, 0.0, 0.0)})
    (direct,), (leaping,) = advance([run], method=DOP853), advance([run])
    assert leaping.leapt == 0.0
    np.testing.assert_array_equal(direct.states, leaping.states)


def test_samples_between_turns_of_a_magnet_that_turns_the_other_way_are_those_of_direct_steps():
    """Once the device has settled; before, the roll at samples is less exact."""
    changes = {"run.duration": 30.0, "run.interval": 0.13, "drive.frequency": -4.0, "drive.distance": 0.16}
    exact, leaping = both(hm.load("nose-first/fig3c").replaced(changes))
    assert leaping.leapt > 0.9
    np.testing.assert_allclose(leaping.states[:, :3], exact.states[:, :3], rtol=0.0, atol=5e-7)
    settled = leaping.time > 15.0
    np.testing.assert_allclose(leaping.states[settled, 3:], exact.states[settled, 3:], rtol=0.0, atol=2e-5)


def test_heights_between_turns_rise_with_a_drive_that_climbs():
    """The frame that moves with it rises too: extremes are of the lab."""
    exact, leaping = both(scenario("60 s", **TAIL_FIRST | {"velocity": (0.0, 0.0, 1e-4)}))
    assert leaping.leapt > 0.3
    for name in ("low", "high", "height"):
        np.testing.assert_allclose(leaping.records[name], exact.records[name], rtol=0.0, atol=2e-6, err_msg=name)


def test_going_on_after_a_stop_gives_the_same_bits():
    runs = [scenario("30000 s", **TAIL_FIRST), scenario("30000 s", **TAIL_FIRST | {"weight": 50e-6})]
    whole = advance(runs)
    looks = advancing(runs, threads=1)
    first = []
    with closing(looks):
        for underway in looks:
            first = underway.histories()
            if all(history.progress["leap"]["stage"] > 0 for history in first):
                break
    assert all(history.status is End.RUNNING for history in first)
    again = []
    for underway in advancing(runs, after=first):
        again = underway.histories()
    for one, other in zip(whole, again, strict=True):
        assert one.leapt > 0.8
        np.testing.assert_array_equal(one.records, other.records)


def test_the_result_says_which_engine_did_what():
    run = scenario("300 s", **TAIL_FIRST)
    leaping, direct = hm.simulate(run), hm.simulate(run, method="direct")
    assert "multi-revolution" in leaping.dataset.attrs["integrator"]
    assert 0.5 < leaping.dataset.attrs["share_of_turns_leapt_over"] < 1.0
    assert direct.dataset.attrs["integrator"] == "DOP853, adaptive"
    with pytest.raises(hm.InputError, match="method must be one of multirevolution, direct; got 'euler'"):
        hm.simulate(run, method="euler")


def attitude(state):
    return Rotation.from_quat(np.array(state)[[4, 5, 6, 3]])


def random_states(count):
    rng = np.random.default_rng(6)
    for _ in range(count):
        near = rng.normal(size=4)
        away = near + 0.3 * rng.normal(size=4)
        reference, state = (
            State(*rng.normal(size=3), *(q / np.linalg.norm(q))) for q in (near, away * np.sign(near @ away))
        )
        yield reference, state


def test_a_chart_gives_the_swing_of_the_long_axis_and_the_roll_about_it():
    """Beside SciPy's rotations: the least rotation that takes the long axis along, and what is left about it."""
    for reference, state in random_states(20):
        place = np.array(to_chart(reference, state))
        relative = attitude(reference).inv() * attitude(state)
        axis = relative.apply([1.0, 0.0, 0.0])
        half = np.arccos(axis[0]) / 2.0
        across = np.cross([1.0, 0.0, 0.0], axis)
        swing = 2.0 * np.sin(half) * across / np.linalg.norm(across)
        np.testing.assert_allclose(place[3:5], swing[1:], rtol=0.0, atol=1e-12)
        swung = Rotation.from_rotvec(2.0 * half * across / np.linalg.norm(across))
        np.testing.assert_allclose([place[5], 0.0, 0.0], (swung.inv() * relative).as_rotvec(), rtol=0.0, atol=1e-12)


def test_a_chart_leads_back_to_the_state():
    for reference, state in random_states(20):
        there = to_chart(reference, state)
        np.testing.assert_allclose(np.array(from_chart(reference, there)), np.array(state), rtol=0.0, atol=1e-14)


def test_a_chart_ends_before_its_coordinates_do():
    assert not far_off(Place(9.0, 9.0, 9.0, 0.7, -0.7, -1.4))
    assert all(far_off(Place(0.0, 0.0, 0.0, *place)) for place in ((0.9, 0.0, 0.0), (0.0, -0.9, 0.0), (0.0, 0.0, -1.6)))


def test_a_device_that_is_swung_and_not_rolled_has_its_attitude_at_samples(random_runs):
    """In step, but the field swings across it: a turn that takes the roll back again is none to leap over."""
    run = random_runs.random_run(98)[1]
    exact, leaping = both(run.replaced({"run.duration": 60.0, "run.interval": 1.0 / (3.0 * run.drive.frequency)}))
    alike = np.abs(np.sum(exact.states[:, 3:] * leaping.states[:, 3:], axis=1))
    np.testing.assert_allclose(alike, 1.0, rtol=0.0, atol=1e-9)


def test_leaps_that_begin_after_a_slip_are_as_exact_as_others(random_runs):
    """What steps of a turn miss is not what it will be when the device has settled, so it must be little."""
    exact, leaping = both(random_runs.random_run(290)[1].replaced({"run.duration": 150.0, "run.interval": 1.0}))
    assert exact.slips[-1] == 1
    assert leaping.leapt > 0.8
    assert np.linalg.norm(exact.states[:, :3] - leaping.states[:, :3], axis=1).max() < 2e-8


def test_random_runs_are_those_of_exact_steps(random_runs):
    """Some of benchmarks/random_runs.py: in circles and straight, losing step, touching the magnet, meeting walls."""
    numbers = (0, 1, 2, 3, 5, 12, 17, 19, 21, 27)
    kinds, runs = zip(*(random_runs.random_run(number) for number in numbers), strict=True)
    exact, leaping = advance(runs, method=DOP853, tolerance=1e-11), advance(runs)
    told = [accuracy_of(history) for history in leaping]
    rows = zip(kinds, numbers, ["leaps"] * len(runs), leaping, told, exact, strict=True)
    found = [random_runs.compared(*row) for row in rows]
    assert all(one.good and one.bounded for one in found), found
    assert {one.status for one in exact} == {End.HORIZON, End.CONTACT, End.SURFACE}
    assert np.mean([one.leapt for one in found]) > 0.7
