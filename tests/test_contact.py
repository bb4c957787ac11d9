"""Walls that hold: pushes against another solver, and runs that rest, slide, leave and come back, in closed form."""

import json
import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from threading import Barrier

import numpy as np
import pytest
import warp as wp
from scipy.optimize import nnls

import helimag as hm
import oracles
from helimag.engine import DOP853, OPEN_WATER, advance, system_of
from helimag.engine.contact import held_in
from helimag.engine.events import pack_bounds
from helimag.engine.medium import Alike
from helimag.engine.packing import pack_bodies
from helimag.geometry import body_rotations
from helimag.orbits import explain
from helimag.orbits.strobe import Problem, open_water
from helimag.outcomes import End, Future, Limit, Reason, Verdict
from helimag.physics.balance import SHEETS, Sheet, Swimmer
from helimag.physics.contact import Six, SixBySix, least_pushes
from helimag.physics.kinematics import State, head_position, rotation_matrix
from helimag.physics.magnetics import FieldSource
from helimag.plots import draw_run
from helimag.plots._quantities import shown, touching_spans
from helimag.robot.rehearsal import Gate
from helimag.runs.gain import judge
from helimag.runs.heights import Heights, SlowTimes
from helimag.runs.touches import Touch
from helimag.sweeps.compute import compute

WEIGHT = 3e-4  # N
DRAG = np.diag([0.1, 0.15, 0.2, 8e-9, 6e-6, 7e-6])
DRAG[0, 3] = DRAG[3, 0] = -5e-6  # rolling swims
DRAG[2, 4] = DRAG[4, 2] = 6e-4  # the coil drags behind the head
HEAD, COIL, TAIL = 0.0003603, 0.00047, 0.0117 + 0.0003603  # m
CLOSING = 1.0 / 32.0  # of a turn
SURFACE = {"floor": None, "surface": "20 mm"}


def tank(duration="100 s", *, weight=WEIGHT, center=-0.005, matrix=DRAG, contact="hold", extra="", **workspace):
    """A device that hardly feels the magnet, in a tank that holds it."""
    changes = {"moment": 1e-30, "yaw": 0.0, "start": (0.0, 0.0, 0.0), "beta": 0.0, "distance": 0.05}
    case = oracles.case(**changes, weight=weight, gravity_center=center, matrix=matrix)
    run = oracles.scenario_of(case, f'[run]\nduration = "{duration}"\n{extra}')
    return run.replaced({"workspace": {"contact": contact, **workspace}})


def test_threads_that_begin_together_get_the_same_medium():
    """Two chunks of a sweep would otherwise pack structures that the other's kernel does not know."""
    medium = replace(OPEN_WATER, alike=Alike.NOWHERE)  # none that anything else has asked for
    together = Barrier(8)

    def asked(_: int) -> int:
        together.wait()
        return id(held_in(medium))

    with ThreadPoolExecutor(8) as pool:
        assert len(set(pool.map(asked, range(8)))) == 1


# ------------------------------------------------------------------------------------------------------------- pushes


@wp.kernel(enable_backward=False)
def solve_pushes(mobility: wp.array(dtype=SixBySix), parting: wp.array(dtype=Six), pushes: wp.array(dtype=Six)):
    i = wp.tid()
    pushes[i] = least_pushes(mobility[i], parting[i])


def test_pushes_are_those_of_another_solver():
    """Least squares with bounds: L of min L W L / 2 + c L over L >= 0, whose optimum is the complementarity."""
    rng = np.random.default_rng(5)
    roots = rng.normal(size=(400, 6, 6))
    mobilities = roots @ roots.transpose(0, 2, 1) + 0.02 * np.eye(6)
    partings = rng.normal(size=(400, 6))
    partings[::7, :3] = math.inf  # no such walls
    found = wp.zeros(400, dtype=Six, device="cpu")
    given = [wp.array(mobilities, dtype=SixBySix, device="cpu"), wp.array(partings, dtype=Six, device="cpu")]
    wp.launch(solve_pushes, dim=400, inputs=[*given, found], device="cpu")
    touching = 0
    for mobility, parting, pushes in zip(mobilities, partings, found.numpy(), strict=True):
        near = np.isfinite(parting)
        root = np.linalg.cholesky(mobility[np.ix_(near, near)])
        expected = np.zeros(6)
        expected[near] = nnls(root.T, -np.linalg.solve(root, parting[near]))[0]
        assert np.abs(pushes - expected).max() < 1e-6 * (1.0 + np.abs(expected).max())
        touching += np.count_nonzero(pushes)
    assert touching > 600


def response_kernel(system):
    local, response = system.medium.local, system.medium.response
    around_type = system.medium.surroundings_type

    @wp.kernel(enable_backward=False, module="unique")
    def respond(
        body: wp.array(dtype=Swimmer),
        around: wp.array(dtype=around_type),
        states: wp.array(dtype=State),
        loads: wp.array(dtype=wp.spatial_vectord),
        motions: wp.array(dtype=wp.spatial_vectord),
    ):
        i = wp.tid()
        place, rotation = head_position(states[i]), rotation_matrix(states[i])
        sheets = wp.zeros(shape=SHEETS, dtype=Sheet)
        motions[i] = response(body[0], local(around[0], place, rotation, sheets), place, rotation, loads[i])

    return respond


def touching_points(scenario, position, rotation):
    """Gaps (m) and pushes of one newton (body frame) of both balls at every wall that there is."""
    low, high = np.array(scenario.workspace.box)
    gaps, pushes = [], []
    for centre, radius in ((np.zeros(3), HEAD), (np.array([-TAIL, 0.0, 0.0]), COIL)):
        place = position + rotation @ centre
        for i in range(3):
            for side, gap in ((1.0, place[i] - radius - low[i]), (-1.0, high[i] - radius - place[i])):
                if np.isfinite(gap):
                    normal = rotation.T @ (side * np.eye(3)[i])
                    gaps.append(gap)
                    pushes.append(np.concatenate([normal, np.cross(centre, normal)]))
    return np.array(gaps), np.array(pushes)


def test_the_kernel_answers_as_the_constrained_balance_does():
    """Random places, attitudes and loads in a corner: motion, no way into a wall, and no energy from one."""
    box = {"floor": "-6 mm", "surface": "60 mm", "walls": {"x": ["-15 mm", "60 mm"], "y": ["-5 mm", "60 mm"]}}
    run = tank(**box)
    rng = np.random.default_rng(8)
    quaternions = rng.normal(size=(600, 4))
    quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
    rotations = body_rotations(quaternions)
    positions, low = np.empty((600, 3)), np.array(run.workspace.box[0])
    for i, rotation in enumerate(rotations):  # pushed into the corner until something touches, then off by a little
        reach = np.minimum(-HEAD, -TAIL * rotation[:, 0] - COIL)
        positions[i] = low - reach + rng.choice([0.0, 1e-6, 1e-3], 3)
    loads = rng.normal(size=(600, 6)) * np.array([3e-4] * 3 + [1e-6] * 3)
    system = system_of(run)
    given = [
        wp.array(pack_bodies([run]), dtype=Swimmer, device="cpu"),
        system.medium.pack([run], "cpu"),
        wp.array(np.column_stack([positions, quaternions]), dtype=State, device="cpu"),
        wp.array(loads, dtype=wp.spatial_vectord, device="cpu"),
    ]
    motions = wp.zeros(600, dtype=wp.spatial_vectord, device="cpu")
    wp.launch(response_kernel(system), dim=600, inputs=[*given, motions], device="cpu")
    mobility, rate = np.linalg.inv(DRAG), run.drive.frequency / CLOSING
    root = np.linalg.cholesky(mobility)
    held = 0
    for position, rotation, load, motion in zip(positions, rotations, loads, motions.numpy(), strict=True):
        gaps, pushes = touching_points(run, position, rotation)
        assert gaps.min() >= -1e-15
        # v = M (F + J' L) is the motion nearest to M F, in the norm of the drag, that every wall allows: its dual
        parting = pushes @ mobility @ load + rate * gaps
        dual = np.vstack([(pushes @ root).T, -parting[None]])
        forces, _ = nnls(dual, np.array([0.0] * 6 + [1.0]), maxiter=500)
        forces = forces / (1.0 + parting @ forces) if forces.any() else forces
        expected = mobility @ (load + pushes.T @ forces)
        size = np.sqrt(expected @ DRAG @ expected)
        off = motion - expected
        assert np.sqrt(off @ DRAG @ off) < 1e-7 * size
        assert (pushes @ motion + rate * gaps).min() > -1e-9
        taken = load @ motion - motion @ DRAG @ motion  # what walls take
        assert taken > -1e-9 * (load @ mobility @ load)
        held += bool(forces.any())
    assert 300 < held < 600


# --------------------------------------------------------------------------------------------------------------- runs


def test_a_contact_is_found_at_the_sample_it_begins_before():
    """The coil's end sinks at W / a up to where that is faster than a wall lets it come: rate times gap."""
    sinking = tank("9 s", center=0.0, matrix=np.diag([0.1] * 3 + [8e-9] + [6e-6] * 2), floor="-20 mm")
    fine = sinking.replaced({"run.interval": 0.001})
    (history,) = advance([fine], method=DOP853)
    assert history.steps < 0.5 * history.time.size
    speed, rate = WEIGHT / 0.1, fine.drive.frequency / CLOSING
    begins = (0.020 - COIL - speed / rate) / speed
    (touch,) = history.touches
    assert 0.0 <= touch.first - begins < 0.0011
    assert touch.total == pytest.approx(9.0 - begins, abs=0.002)
    pressed = history.time[history.records["walls"] != 0]
    assert pressed[0] - 0.001 < touch.first <= pressed[0] + 1e-12
    gap = history.states[:, 2] - TAIL * body_rotations(history.states[:, 3:])[:, 2, 0] - COIL + 0.020
    since = history.time - begins
    closed = speed * np.where(since < 0.0, 1.0 / rate - since, np.exp(-rate * np.maximum(since, 0.0)) / rate)
    np.testing.assert_allclose(gap, closed, rtol=0.0, atol=2e-8)


@pytest.mark.parametrize("box", [{"floor": "-20 mm"}, {"surface": "20 mm"}])
def test_a_device_at_rest_does_not_creep(box):
    """Both ends on the floor, or at the surface: where their balls touch, for ten minutes, to the last picometre."""
    side = 1.0 if "floor" in box else -1.0
    (history,) = advance([tank("600 s", weight=side * WEIGHT, **box)])
    assert history.status is End.HORIZON
    settled = history.states[history.time > 60.0]
    assert np.ptp(settled, axis=0).max() < 1e-12
    tilt = math.asin(side * (HEAD - COIL) / TAIL)
    assert settled[-1, 2] == pytest.approx(side * (HEAD - 0.020), abs=1e-11)
    assert body_rotations(settled[-1, 3:])[2, 0] == pytest.approx(math.sin(tilt), abs=1e-10)
    (touch,) = history.touches
    judgement = history.judge()
    assert touch.wall is (Limit.FLOOR if side > 0 else Limit.SURFACE)
    assert judgement.cause is touch.wall.cause
    assert judgement.verdict is Verdict.WALL_LIMITED
    assert judgement.escape_time == touch.first
    assert touch.count == 1
    assert touch.last == 600.0
    assert touch.total == pytest.approx(600.0 - touch.first, abs=0.05)


PUSH = wp.constant(wp.float64(2e-5))  # N
SWING = wp.constant(wp.float64(6e-4))
SLOW = 0.2  # Hz


@wp.func
def pushing(magnet: FieldSource, r: wp.vec3d, axis: wp.vec3d, m: wp.vec3d):  # noqa: ARG001
    """A steady force along x and one along z that swings with the magnet, and no field."""
    return wp.vec3d(), wp.vec3d(PUSH, wp.float64(0.0), magnet.moment * SWING * axis[2])


def pushed(scenario):
    (history,) = advance([scenario], system=lambda given: replace(system_of(given), magnet=pushing))
    return history


def test_a_device_pressed_at_the_surface_slides_as_the_tangential_balance_says():
    """Two touching points take two freedoms; the rest is the resistance of those that are left, solved by hand."""
    run = tank("60 s", weight=-WEIGHT, surface="1 mm", extra='interval = "50 ms"')
    run = run.replaced({"magnet.moment": 1e-9})  # no swing
    history = pushed(run)
    states = history.states
    for i in range(400, 1200, 100):
        velocity = (states[i + 1, :3] - states[i - 1, :3]) / (history.time[i + 1] - history.time[i - 1])
        rotation = body_rotations(states[i, 3:])
        gaps, pushes = touching_points(run, states[i, :3], rotation)
        assert np.abs(gaps).max() < 1e-11
        up = rotation.T @ [0.0, 0.0, 1.0]
        load = np.concatenate([rotation.T @ [2e-5, 0.0, WEIGHT], np.cross([-0.005, 0.0, 0.0], WEIGHT * up)])
        balance = np.block([[DRAG, -pushes.T], [pushes, np.zeros((2, 2))]])
        solved = np.linalg.solve(balance, np.concatenate([load, np.zeros(2)]))
        assert (solved[6:] > 0.0).all()
        expected = rotation @ solved[:3]
        assert expected[0] > 1e-4
        np.testing.assert_allclose(velocity, expected, atol=2e-5 * expected[0])


def ball(duration, *, weight, extra="", **workspace):
    """A ball of matter that swims not, with the isotropic drag of 0.2 N s/m."""
    drag = np.diag([0.2] * 3 + [1e-6] * 3).tolist()
    device = {
        "magnetic_moment": 1e-30,
        "head": {"shape": "sphere", "radius": HEAD},
        "weight": {"net_weight": weight, "gravity_center": 0.0},
        "hydrodynamics": {"model": "matrix", "resistance": drag},
    }
    return tank(duration, extra=extra, **workspace).replaced({"device": device})


def test_a_ball_that_is_pressed_and_lifted_each_turn_is_reflected():
    """Skorokhod's reflection: free motion plus the least push that keeps it above the floor; the gap closes late."""
    run = ball("100 s", weight=2e-4, floor="-1 mm", extra='interval = "10 ms"')
    run = run.replaced({"magnet.moment": 1.0, "drive.frequency": f"{SLOW} Hz"})
    history = pushed(run)
    turn = 2.0 * math.pi * SLOW
    free = (float(SWING) / turn * (1.0 - np.cos(turn * history.time)) - 2e-4 * history.time) / 0.2
    lowest = HEAD - 0.001
    expected = free + np.maximum.accumulate(np.maximum(lowest - free, 0.0))
    late = CLOSING / SLOW * (float(SWING) + 2e-4) / 0.2
    assert np.abs(history.states[:, 2] - expected).max() < late
    assert np.abs(history.states[:, 2] - expected).mean() < 0.2 * late
    assert history.heights.low.min() > lowest - 1e-10
    (touch,) = history.touches
    assert touch.count == 20  # once a turn
    resting = np.mean(expected - lowest < 1e-9)
    assert touch.total == pytest.approx(100.0 * resting, abs=20 * 3.0 * CLOSING / SLOW)
    assert 0.2 < resting < 0.8
    walls = history.records["walls"]
    assert set(np.unique(walls)) == {0, 1 << Limit.FLOOR.flag}
    assert np.mean(walls > 0) == pytest.approx(touch.total / 100.0, abs=0.01)


@pytest.mark.parametrize("share", [0.8, 1.2])
def test_a_surface_holds_a_ball_with_its_own_force(share):
    """Less than the weight lets it go, later by the integral over the reach of the hold; more keeps it for ever."""
    run = ball("20 s", weight=WEIGHT, surface=HEAD, surface_pull=share * WEIGHT)
    (history,) = advance([run])
    height = history.states[-1, 2]
    if share > 1.0:
        assert np.abs(history.states[:, 2]).max() < 1e-12
        assert history.judge().cause is Reason.HELD_BY_SURFACE
        return
    reach = 0.1 * HEAD
    way = np.linspace(0.0, reach, 20001)
    slow = np.trapezoid(0.2 / (WEIGHT - share * WEIGHT * (1.0 - way / reach) ** 2), way)
    assert height == pytest.approx(-(reach + (20.0 - slow) * WEIGHT / 0.2), abs=1e-8)
    assert not history.touches


def test_smaller_steps_converge():
    """A run that taps the surface two hundred times: halving the step, sixteen times less tolerance a go."""
    run = hm.load("nose-first/table1-row2").replaced({"workspace.contact": "hold", "run.duration": "50 s"})
    exact, *rougher = (advance([run], tolerance=t)[0] for t in (1e-11, 1e-5, 3e-7, 1e-8))
    off = [np.linalg.norm(history.states[-1, :3] - exact.states[-1, :3]) for history in rougher]
    assert off[1] < 1e-7
    assert off[2] < 0.3 * off[1] < 0.3 * off[0]
    assert exact.touches[0].count > 100
    assert exact.status is End.HORIZON


def test_a_run_that_touches_nothing_is_the_same_to_the_last_bit():
    stops = hm.load("nose-first/table1-row1").replaced({"run.duration": "30 s"})
    holds = stops.replaced({"workspace.contact": "hold"})
    (stopping,), (holding,) = advance([stops]), advance([holds])
    assert holding.leapt > 0.9
    assert np.array_equal(stopping.states, holding.states)
    assert stopping.steps == holding.steps
    assert not holding.touches


# ------------------------------------------------------------------------------------------- what is said of contacts


def touch(wall, first, last):
    return Touch(wall=wall, count=2, first=first, last=last, total=last - first)


def judged(*touches, end=End.HORIZON):
    """A settled height of 600 s, and contacts."""
    time = np.linspace(0.0, 600.0, 301)
    still = np.zeros_like(time)
    return judge(
        Heights(
            time=time,
            low=still,
            high=still,
            mean=still,
            attack=still,
            attack_square=still,
            slips=0,
            initial_gap=0.15,
            end=end,
            slow=SlowTimes(lap=None, fold=10.0),
            touches=touches,
        )
    )


def test_walls_that_pushed_before_a_leap_are_told_once():
    """With the sample that ends the interval, which lies within the leap; not with those after it."""
    near = hm.load("nose-first/fig3c")
    surface = near.drive.start[2] + near.device.tail_radius + 1e-6
    changes = {"workspace.surface": surface, "workspace.contact": "hold", "run.duration": 100.0, "run.interval": 50.0}
    (leaping,) = advance([near.replaced(changes)])
    assert leaping.touches[0].last < 1.0
    assert leaping.leapt > 0.6  # so that leaps began before the first sample
    np.testing.assert_array_equal(leaping.records["walls"] > 0, [False, True, False])


def test_a_device_that_comes_to_rest_leaps_until_it_is_near_the_floor():
    """The first contact is one of steps."""
    run = hm.load("nose-first/table1-row5").replaced({"run.duration": "110 s", "workspace.contact": "hold"})
    (leaping,) = advance([run])
    (exact,) = advance([run], method=DOP853, tolerance=1e-11)
    assert leaping.leapt > 0.5
    assert exact.leapt == 0.0
    ours, theirs = leaping.touches[0], exact.touches[0]
    assert ours.count == theirs.count
    assert ours.first == pytest.approx(theirs.first, abs=0.02)  # found at ends of steps
    assert ours.total == pytest.approx(theirs.total, abs=0.02)
    np.testing.assert_array_equal(leaping.records["walls"] > 0, exact.records["walls"] > 0)
    assert np.linalg.norm(leaping.states[:, :3] - exact.states[:, :3], axis=1).max() < 1e-6


def test_a_surface_that_pulls_is_kept_clear_of():
    """Its pull begins before it touches; leaps take it for not there."""
    run = hm.load("nose-first/table1-row1").replaced({"workspace.contact": "hold", "workspace.surface_pull": 1e-5})
    reach = 0.1 * max(run.device.head_radius, run.device.tail_radius)
    assert pack_bounds([run])["pull_reach"] == pytest.approx(reach)
    assert pack_bounds([run.replaced({"workspace.surface_pull": None})])["pull_reach"] == 0.0


def test_a_run_is_wall_limited_where_a_wall_holds_it_in_its_second_half():
    early, late, later = (
        touch(Limit.FLOOR, 1.0, 299.0),
        touch(Limit.LOW_Y, 5.0, 301.0),
        touch(Limit.SURFACE, 9.0, 600.0),
    )
    left = judged(early)
    assert left.verdict is Verdict.BOUNDED
    assert left.touches == (early,)
    assert judged(early, late).cause is Reason.HELD_BY_WALL
    assert "the wall at low y: 2 contacts from 5.0 s to 301.0 s, 296.0 s in all" in judged(late).reason
    held = judged(early, late, later)
    assert (held.cause, held.escape_time) == (Reason.HELD_BY_SURFACE, 9.0)
    assert (held.contacts, held.first_contact, held.contact_time) == (6, 1.0, 298.0 + 296.0 + 591.0)
    assert judged(later, end=End.CONTACT).verdict is Verdict.ATTRACTED
    assert judged(later, end=End.FALL).verdict is Verdict.FELL


@pytest.fixture(scope="module")
def resting():
    return hm.simulate(tank("60 s", floor="-20 mm"))


def test_a_saved_run_keeps_its_contacts(resting, tmp_path):
    resting.save(tmp_path / "run.nc")
    read = hm.Trajectory.load(tmp_path / "run.nc")
    assert read.touches == resting.touches
    assert read.judgement == resting.judgement
    assert read.dataset.walls.attrs["flag_meanings"] == "floor surface low_x high_x low_y high_y"
    assert read.dataset.wall.values.tolist() == [str(wall) for wall in Limit]
    pressed = read.dataset.walls.values & read.dataset.walls.attrs["flag_masks"][Limit.FLOOR.flag] > 0
    assert read.dataset.time.values[pressed][0] == pytest.approx(resting.touches[0].first, abs=60.0 / 1800)
    assert pressed[-1]


def test_a_run_that_is_held_has_no_free_orbit_and_no_programme(resting):
    outlook = explain(resting)
    assert outlook.future is Future.HELD
    assert outlook.orbit is None
    assert outlook.future.leaves
    assert not Gate(resting, outlook).passes
    assert "has no free orbit" in outlook.text


def test_orbits_are_those_of_walls_that_do_not_hold():
    free = hm.load("nose-first/fig3c")
    held = free.replaced({"workspace": {"floor": "-80 mm", "contact": "hold"}})
    wet = free.replaced({"workspace": {"floor": "-80 mm"}})
    assert system_of(held) is not system_of(wet)
    assert Problem([held]).systems == Problem([wet]).systems
    assert open_water(held).workspace == wet.workspace


def test_walls_that_hold_change_nothing_of_how_a_run_is_written_and_named(resting):
    scenario = hm.Scenario.model_validate(tank(floor="-20 mm"))
    assert scenario.replaced({"workspace.contact": None}).hash == tank(contact=None, floor="-20 mm").hash
    assert resting.scenario_toml.count('contact = "hold"') == 1
    stopping = hm.simulate(tank("60 s", contact="stop", floor="-20 mm"))
    assert "walls" not in stopping.dataset
    assert stopping.dataset.attrs["end"] == "floor"
    assert stopping.touches == ()


@pytest.mark.parametrize(
    ("workspace", "told"),
    [
        ({"surface": "1 mm", "surface_pull": "1 uN"}, 'surface and contact = "hold" only'),
        ({"floor": "-9 mm", "contact": "hold", "surface_pull": "1 uN"}, 'surface and contact = "hold" only'),
        ({"surface": "1 mm", "contact": "hold", "surface_pull": "-1 uN"}, "not negative"),
        ({"surface": "1 mm", "contact": "bounce"}, "contact"),
    ],
)
def test_what_does_not_fit_is_refused(workspace, told):
    with pytest.raises(hm.InputError, match=told):
        hm.load("nose-first/fig3c").replaced({"workspace": workspace})


def test_a_start_inside_a_wall_ends_the_run():
    (history,) = advance([tank(floor="-0.3 mm")])
    assert history.status is End.FLOOR
    assert history.time[-1] < 1e-5
    assert history.states[-1] == pytest.approx(history.states[0], abs=1e-6)


def test_a_sweep_stores_and_exports_contacts():
    rows = compute([tank("60 s", floor="-20 mm"), tank("60 s", contact="stop", floor="-20 mm")])
    assert rows["contacts"].tolist() == [1.0, 0.0]
    assert rows["first_contact"][0] == pytest.approx(rows["escape_time"][0])
    assert rows["contact_time"][0] == pytest.approx(60.0 - rows["first_contact"][0], abs=0.05)
    assert np.isnan(rows["first_contact"][1])
    assert rows["reason"].tolist() == [Reason.HELD_BY_FLOOR.flag, Reason.REACHED_FLOOR.flag]


def test_the_command_line_tells_of_contacts(helimag):
    sets = [f"--set=workspace.{one}" for one in ("contact=hold", "floor=-4 mm")]
    done = helimag("simulate", "nose-first/table1-row2", *sets, "--duration=30 s", "--no-orbit", "--json")
    told = json.loads(done.out)
    assert told["verdict"] == "wall-limited"
    assert {"wall", "count", "first_s", "last_s", "total_s"} == told["contacts"][0].keys()
    assert told["contacts"][0]["wall"] == "surface"
    done = helimag("simulate", "nose-first/table1-row2", *sets, "--duration=30 s", "--no-orbit")
    assert "  contact       the surface: " in done.out
    assert "walls         hold a device that comes to them" in helimag("doctor", "nose-first/table1-row2", *sets).out
    assert "walls         stop a run" in helimag("doctor", "nose-first/table1-row2").out


def test_a_figure_marks_when_a_wall_pushes(resting):
    ((begin, end),) = touching_spans(shown(resting))
    assert begin == pytest.approx(resting.touches[0].first, abs=60.0 / 1800)
    assert end == 60.0
    axes = draw_run(resting).axes[-2:]
    assert any("a wall pushes" in each.get_xlabel() for each in axes)
