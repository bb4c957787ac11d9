"""Orbits of the one-period map: known values, brute force, invariances, and what is refused."""

import math
from dataclasses import replace

import numpy as np
import pytest

import helimag as hm
from helimag.engine import advance
from helimag.geometry import long_axes
from helimag.orbits import OrbitStatus, find_orbits, list_orbits, observed_growth
from helimag.orbits.beside_runs.growth import leading_direction
from helimag.orbits.strobe import Problem, chart, describe_rates, solve
from helimag.orbits.strobe.problem import STEPS_PER_TURN
from helimag.orbits.strobe.starts import default_box, on_grid, strobed, to_lab, to_moving

ONE = np.zeros(1, dtype=np.int64)


@pytest.fixture(scope="module")
def scenario() -> hm.Scenario:
    return hm.load("nose-first/fig3c").replaced({"drive.frequency": "2.5 Hz"})


@pytest.fixture(scope="module")
def orbit(scenario: hm.Scenario) -> hm.Orbit:
    return hm.find_orbit(scenario)


@pytest.fixture(scope="module")
def saddle(scenario: hm.Scenario) -> hm.Orbit:
    """The unstable orbit above the stable one, from where Newton's method ends when it begins at the start of a run."""
    problem = Problem([scenario])
    begun, _ = problem.map(ONE, np.array([[*scenario.drive.start, 1.0, 0.0, 0.0, 0.0]]), periods=2)
    return hm.find_orbit(scenario, near=begun[0])


def test_reference_orbit(orbit: hm.Orbit) -> None:
    assert orbit.status is OrbitStatus.FOUND
    assert orbit.stable
    assert orbit.position == pytest.approx([-7.58e-3, -12.77e-3, -11.92e-3], abs=1e-5)
    assert orbit.rates[0] == pytest.approx(-0.00053 + 0.0310j, rel=0.03)
    assert orbit.rates[0].real == pytest.approx(-0.00053, rel=0.03)
    assert orbit.rates[2] == pytest.approx(-0.0022, rel=0.03)
    assert orbit.rates[5].real < -30.0
    assert orbit.position_error < 1e-7


@pytest.mark.parametrize(("frequency", "height"), [(1.8, -50.8), (2.2, -24.8), (2.9, 5.0)])
def test_heights_where_long_runs_settle(scenario: hm.Scenario, frequency: float, height: float) -> None:
    found = hm.find_orbit(scenario.replaced({"drive.frequency": frequency}), thorough=False)
    assert found.stable
    assert 1e3 * found.mean_position[2] == pytest.approx(height, abs=0.1)


def test_no_stable_orbit_at_the_preset_itself() -> None:
    assert not hm.find_orbit(hm.load("nose-first/fig3c")).stable


def test_orbit_repeats_in_the_adaptive_integrator(scenario: hm.Scenario, orbit: hm.Orbit) -> None:
    """The other integrator, in the lab frame, through whole turns: only the change of frame brings the state back."""
    period = 1.0 / scenario.drive.frequency
    turns = 5
    run = scenario.replaced({"run.duration": turns * period, "run.interval": turns * period})
    (history,) = advance([run], initial_states=orbit.state[None], tolerance=1e-11)
    back = to_moving(scenario, np.array([turns * period]), history.states[-1:])
    assert np.abs(chart.coordinates(back, orbit.state[None], np.array([0.15]))).max() < 1e-7
    assert np.linalg.norm(history.states[-1, :3] - orbit.position) > 5e-4


def test_growth_in_full_runs_is_the_floquet_rate(orbit: hm.Orbit, saddle: hm.Orbit) -> None:
    for found in (orbit, saddle):
        seen = observed_growth(found, duration=600.0)
        assert seen.rate.real == pytest.approx(found.growth, rel=0.02)
        assert seen.rate.imag == pytest.approx(abs(found.rates[0].imag), rel=0.02)


def test_runs_stay_by_a_stable_orbit_and_leave_an_unstable_one(orbit: hm.Orbit, saddle: hm.Orbit) -> None:
    assert saddle.found
    assert not saddle.stable
    away = []
    for found in (orbit, saddle):
        direction, _ = leading_direction(found)
        start = chart.moved(found.state[None], 1e-3 * direction[None], np.array([0.15]))
        (run,) = strobed(found.scenario, 6000.0, samples=200, states=start)
        away.append((run.status.name, np.linalg.norm(run.states[-1, :3] - found.position)))
    assert away[0][0] == "HORIZON"
    assert away[0][1] < 0.15e-3 * 0.1
    assert away[1][0] != "HORIZON" or away[1][1] > 0.02


def test_sum_of_rates_is_the_mean_divergence(scenario: hm.Scenario, orbit: hm.Orbit) -> None:
    """Liouville: det of the monodromy is exp of the divergence's integral, here by short pieces of the period."""
    problem = Problem([scenario])
    parts = 48
    state, total = orbit.state[None], 0.0
    for k in range(parts):
        begin, end = np.array([k / parts]), np.array([(k + 1) / parts])
        steps = np.array([2])
        _, jacobian, _ = problem.linearized(ONE, state, begin=begin, end=end, steps=steps)
        total += math.log(np.linalg.det(jacobian[0]))
        state, _ = problem.advance(ONE, state, steps, begin, end)
    assert orbit.rates.real.sum() == pytest.approx(total * scenario.drive.frequency, rel=1e-5)


def test_map_error_falls_with_the_order_of_the_method(scenario: hm.Scenario, orbit: hm.Orbit) -> None:
    problem = Problem([scenario])
    away = chart.moved(orbit.state[None], np.array([[0.02, 0.01, -0.01, 0.0, 0.1, 0.05]]), problem.length)
    begun, _ = problem.map(ONE, away, periods=2)
    images = [problem.advance(ONE, begun, np.array([n]), np.zeros(1), np.ones(1))[0] for n in (24, 48, 192)]
    errors = [np.abs(image - images[2])[0, :3].max() for image in images[:2]]
    assert 6.5 < math.log2(errors[0] / errors[1]) < 10.0


def test_frame_change_is_its_own_inverse(scenario: hm.Scenario) -> None:
    moving = scenario.replaced({"drive.velocity": (0.0, 0.0, 1e-4)})
    rng = np.random.default_rng(1)
    states = rng.normal(size=(5, 7))
    states[:, 3:] /= np.linalg.norm(states[:, 3:], axis=1, keepdims=True)
    times = rng.uniform(0.0, 100.0, 5)
    assert to_moving(moving, times, to_lab(moving, times, states)) == pytest.approx(states, abs=1e-12)


def test_chart_is_inverse_to_moving() -> None:
    rng = np.random.default_rng(2)
    states = rng.normal(size=(20, 7))
    states[:, 3:] /= np.linalg.norm(states[:, 3:], axis=1, keepdims=True)
    by = rng.uniform(-1.0, 1.0, (20, 6))
    length = rng.uniform(0.1, 2.0, 20)
    moved = chart.moved(states, by, length)
    assert chart.coordinates(moved, states, length) == pytest.approx(by, abs=1e-12)
    moved[:, 3:] *= -1.0
    assert chart.coordinates(moved, states, length) == pytest.approx(by, abs=1e-12)


def test_scaled_problem_has_the_scaled_orbit(scenario: hm.Scenario, orbit: hm.Orbit) -> None:
    """Half the viscosity, twice frequency and yaw rate: the same place, everything twice as fast."""
    faster = scenario.replaced(
        {"fluid.viscosity": 0.5, "drive.frequency": 5.0, "drive.yaw_rate": 2.0 * scenario.drive.yaw_rate}
    )
    found = hm.find_orbit(faster, near=orbit)
    assert found.position == pytest.approx(orbit.position, abs=1e-8)
    assert found.rates[:5] == pytest.approx(2.0 * orbit.rates[:5], rel=1e-4)


def test_batch_gives_the_same_orbits_as_one_by_one(scenario: hm.Scenario, orbit: hm.Orbit) -> None:
    scenarios = [scenario.replaced({"drive.pitch": math.radians(p)}) for p in (12.0, 13.0, 13.5)]
    batch = find_orbits(scenarios, np.repeat(orbit.state[None], 3, axis=0))
    for one, found in zip(scenarios, batch, strict=True):
        assert found.stable
        assert found.position == pytest.approx(hm.find_orbit(one, near=orbit).position, abs=1e-9)


def test_straight_run_under_the_magnet_is_unstable() -> None:
    """Force rises as the gap shrinks, so that the vertical balance loses itself within tens of seconds at 102 mm."""
    data = hm.load("nose-first/table1-row1").model_dump(mode="python")
    straight = hm.Scenario.model_validate(data | {"workspace": {}})
    found = hm.find_orbit(straight)
    assert found.found
    assert not found.stable
    assert 10.0 < 1.0 / found.growth < 50.0
    assert observed_growth(found, duration=60.0).rate.real == pytest.approx(found.growth, rel=0.02)


def test_walls_in_the_way_are_named(scenario: hm.Scenario, orbit: hm.Orbit) -> None:
    found = hm.find_orbit(scenario.replaced({"workspace.floor": "-5 mm"}), near=orbit)
    assert found.status is OrbitStatus.WALL_LIMITED
    assert found.status.remedy in found.text
    ceiling = scenario.replaced({"workspace.surface": "1 mm"})
    assert hm.find_orbit(ceiling, near=orbit).stable


def test_search_near_the_magnet_ends_with_a_reason(scenario: hm.Scenario, orbit: hm.Orbit) -> None:
    far = hm.find_orbit(scenario.replaced({"drive.frequency": "40 Hz"}), near=orbit)
    assert not far.stable
    assert far.found or far.status.remedy in far.text


def test_refusals(scenario: hm.Scenario) -> None:
    both = scenario.replaced({"drive.velocity": ["1 mm/s", "0 mm/s", "0 mm/s"]})
    with pytest.raises(hm.InputError, match=r"drive\.yaw_rate and drive\.velocity"):
        hm.find_orbit(both)
    with pytest.raises(hm.InputError, match="near must be"):
        hm.find_orbit(scenario, near=np.full(7, np.nan))
    with pytest.raises(hm.InputError, match="corners of a box"):
        list_orbits(scenario, low=(0.0, 0.0, 0.0), high=(-1.0, 0.0, 0.0))


def test_rising_drive_has_a_moving_frame(scenario: hm.Scenario, orbit: hm.Orbit) -> None:
    """A drive that also rises slowly repeats in a frame that rises with it, and its orbit lies a little lower."""
    rising = hm.find_orbit(scenario.replaced({"drive.velocity": ["0 mm/s", "0 mm/s", "0.0005 mm/s"]}), near=orbit)
    assert rising.found
    assert rising.position[2] != pytest.approx(orbit.position[2], abs=2e-5)


def test_words_for_rates() -> None:
    text = describe_rates(np.array([-0.001 + 0.1j, -0.001 - 0.1j, -0.01, -5.0]))
    assert text == "a swing of period 62.83 s decays in 1000 s; a displacement decays in 100 s"
    assert describe_rates(np.array([0.02 + 0j]), 1) == "a displacement grows e-fold in 50 s"


def test_walls_matter_where_the_device_comes(scenario: hm.Scenario, orbit: hm.Orbit) -> None:
    """On its circle to all sides; where nothing turns, only where it is: its head there, its tail behind it."""
    reach = np.hypot(*orbit.position[:2])
    wide, tight = (scenario.replaced({"workspace.walls.x": [-r, r]}) for r in (4.0 * reach, 0.9 * reach))
    assert hm.find_orbit(wide, near=orbit).stable
    assert hm.find_orbit(tight, near=orbit).status is OrbitStatus.WALL_LIMITED
    one_side = scenario.replaced({"workspace.walls.y": [-4.0 * reach, 0.9 * reach]})
    assert hm.find_orbit(one_side, near=orbit).status is OrbitStatus.WALL_LIMITED
    still = scenario.replaced({"drive.yaw_rate": 0.0})
    found = hm.find_orbit(still)
    x = found.position[0]
    assert found.found
    assert x < -0.1
    (tip,) = found.position[:1] - 0.014 * long_axes(found.state[None, 3:])[:, 0]
    beyond, between = (still.replaced({"workspace.walls.x": [at, 0.2]}) for at in (min(x, tip) - 2e-3, max(x, tip)))
    assert hm.find_orbit(beyond, near=found).found
    assert hm.find_orbit(between, near=found).status is OrbitStatus.WALL_LIMITED
    assert hm.find_orbit(between.replaced({"drive.velocity": (1e-7, 0.0, 0.0)}), near=found).found


def test_an_orbit_keeps_the_sign_of_the_quaternion_that_its_search_begins_with(orbit: hm.Orbit) -> None:
    """Either sign is the same attitude; one that changed on the way would tear curves of states apart."""
    by = np.array([np.zeros(6), [0.01, 0.0, -0.01, 0.05, 0.02, 0.0], [0.0, 0.02, 0.0, 0.0, 0.0, 0.04]])
    near = chart.moved(np.repeat(orbit.state[None], 3, axis=0), by, np.full(3, 0.15))
    near[2, 3:] *= -1.0
    orbits = find_orbits([orbit.scenario] * 3, near)
    assert {found.iterations % 2 for found in orbits} == {0, 1}, "each evaluation is a turn, which changes the sign"
    for begun, found in zip(near, orbits, strict=True):
        assert found.found
        assert found.state[3:] @ begun[3:] > 0.9


def test_searches_from_far_away_arrive(scenario: hm.Scenario) -> None:
    """Of 22 places all around the magnet 10 lead to an orbit; where the residual decides what step counts, 6 do."""
    problem = Problem([scenario])
    starts = on_grid(problem, 0, *default_box(scenario, problem.arm[0]), (3, 3, 5))
    assert len(starts) > 15
    assert solve(problem, np.zeros(len(starts), dtype=np.int64), starts).converged.mean() > 0.36


@pytest.mark.parametrize(
    ("place", "side"),
    [
        ((0.0, 0.0, 0.0), "below"),
        ((0.09, 0.0, 0.0), "below"),
        ((0.11, 0.0, 0.0), "beside"),
        ((0.0, -0.08, 0.159), "beside"),
        ((0.01, 0.0, 0.16), "above"),
    ],
)
def test_an_orbit_says_on_which_side_of_the_magnet_it_is(place, side):
    """The magnet of Table I, row 1 is 102 mm straight above the device's start."""
    scenario = hm.load("nose-first/table1-row1")
    orbit = hm.Orbit(scenario=scenario, status=OrbitStatus.FOUND, state=np.array([*place, 1.0, 0.0, 0.0, 0.0]))
    assert orbit.side == side
    named = replace(orbit, rates=np.full(6, -1.0 + 0j), multipliers=np.full(6, 0.5 + 0j))
    assert (f"{side.upper()} the magnet, not below it" in named.text) is (side != "below")


def test_states_that_a_search_has_lost_cost_the_fewest_steps_and_no_warning() -> None:
    """Far away nothing is fast; a number that overflows when cubed is only far away."""
    problem = Problem([hm.load("paper/fig3c")])
    states = np.tile(np.append(problem.arm[0], [1.0, 0.0, 0.0, 0.0]), (3, 1))
    states[:, 2] -= [0.03, 1e3, 1e200]
    near, far, lost = problem.steps(np.zeros(3, np.int64), states)
    assert near > far == lost == STEPS_PER_TURN
