"""The engine's seams: another method, drag that depends on the place, another magnet, launches of any size, a look at
runs under way, stopped and gone on with."""

import math
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from scipy.integrate import DOP853 as SCIPY_DOP853

import helimag as hm
import oracles
from helimag.engine import (
    DOP853,
    MAGNET_MODELS,
    Control,
    Medium,
    Method,
    advance,
    advancing,
    build_rates,
    build_rates_at,
    system_of,
)
from helimag.engine import running as running_module
from helimag.engine.control import scaled_square
from helimag.engine.events import pack_bounds
from helimag.engine.kernels import ready
from helimag.engine.observe import build_observe
from helimag.engine.packing import pack_bodies, pack_magnets
from helimag.engine.stages import weighted_sum
from helimag.outcomes import End
from helimag.physics.balance import Sheet, Swimmer
from helimag.physics.kinematics import Instant, State, normalized
from helimag.physics.magnetics import FieldSource, dipole_field, dipole_force

SINKING = {
    "moment": 1e-30,
    "yaw": 0.0,
    "start": (0.0, 0.0, 0.0),
    "weight": 3e-4,
    "gravity_center": 0.0,
    "matrix": np.diag([0.1] * 3 + [8e-9] + [6e-6] * 2),
    "beta": 0.0,
}
HALF, SIXTH, TWO = (wp.constant(wp.float64(value)) for value in (0.5, 1.0 / 6.0, 2.0))
FIFTEENTH = wp.constant(wp.float64(1.0 / 15.0))


def scenario(duration="20 s", extra="", **changes):
    return oracles.scenario_of(oracles.case(**changes), f'{extra}\n[run]\nduration = "{duration}"')


# ------------------------------------------------------------------------------------------------------- other methods


def build_rk4(system):
    """The classical Runge-Kutta step, its error from one step beside two of half the length."""
    rates, drive_type, here_type = build_rates(system), system.drive_type, system.medium.here_type
    rates_at, pose = build_rates_at(system), system.pose

    @wp.func
    def step(
        body: Swimmer,
        around: here_type,
        drive: drive_type,
        magnets: wp.array(dtype=FieldSource),
        t: wp.float64,
        h: wp.float64,
        state: State,
        k0: State,
    ) -> State:
        k1 = rates(body, around, drive, magnets, t + HALF * h, state + HALF * h * k0)
        k2 = rates(body, around, drive, magnets, t + HALF * h, state + HALF * h * k1)
        k3 = rates(body, around, drive, magnets, t + h, state + h * k2)
        return state + SIXTH * h * (k0 + TWO * (k1 + k2) + k3)

    @wp.func
    def trial(
        body: Swimmer,
        around: here_type,
        drive: drive_type,
        magnets: wp.array(dtype=FieldSource),
        control: Control,
        now: Instant,
        h: wp.float64,
        state: State,
        k0: State,
        kept: wp.array(dtype=State),
        keep: bool,
    ):
        t = now.time
        whole = step(body, around, drive, magnets, t, h, state, k0)
        middle = step(body, around, drive, magnets, t, HALF * h, state, k0)
        k, lag = rates_at(body, around, magnets, pose(drive, t + HALF * h), middle)
        halves = step(body, around, drive, magnets, t + HALF * h, HALF * h, middle, k)
        return normalized(halves), wp.sqrt(scaled_square(FIFTEENTH * (halves - whole), control)), lag

    return trial


RK4 = Method("RK4", 5, build_rk4, safety=0.8, growth=1.5)


def test_another_method_gives_the_same_run_samples_and_events():
    run = scenario("30 s", distance=0.040, beta=np.radians(5.0))
    (ours,), (theirs,) = advance([run], method=DOP853), advance([run], method=RK4, tolerance=1e-8)
    assert theirs.status is ours.status is End.CONTACT
    assert theirs.steps > 2 * ours.steps
    assert theirs.time[-1] == pytest.approx(ours.time[-1], abs=5e-6)
    # up to a tenth of a second before contact, where everything is fast
    early = int(np.searchsorted(ours.time, ours.time[-1] - 0.1))
    assert np.abs(theirs.states[:early, :3] - ours.states[:early, :3]).max() < 1e-8
    assert np.abs(theirs.heights.low[:early] - ours.heights.low[:early]).max() < 1e-6
    assert theirs.heights.slips == ours.heights.slips


def test_the_coefficients_are_scipys():
    """A weighted sum over stages is SciPy's own row, whatever it leaves out."""
    rows = [SCIPY_DOP853.A[7, :7], SCIPY_DOP853.B, SCIPY_DOP853.E5[:12]]
    stages = np.random.default_rng(1).normal(size=(12, 7))

    for row in rows:
        total = weighted_sum(row)

        @wp.kernel(enable_backward=False, module="unique")
        def sums(k: wp.array(dtype=wp.types.matrix(shape=(12, 7), dtype=wp.float64)), out: wp.array(dtype=State)):
            out[0] = total(k[0])  # noqa: B023

        given = wp.array(stages[None], dtype=wp.types.matrix(shape=(12, 7), dtype=wp.float64), device="cpu")
        out = wp.zeros(1, dtype=State, device="cpu")
        wp.launch(sums, dim=1, inputs=[given, out], device="cpu")
        np.testing.assert_allclose(out.numpy()[0], row @ stages[: row.size], rtol=1e-13, atol=1e-14)


# ------------------------------------------------------------------------------------------- drag that depends on place

DEPTH = 0.02  # m, over which the drag doubles


@wp.struct
class Thickening:
    depth: wp.float64


@wp.func
def as_everywhere(
    surroundings: Thickening, position: wp.vec3d, rotation: wp.mat33d, sheets: wp.array(dtype=Sheet)
) -> Thickening:
    return surroundings


@wp.func
def thickening(
    body: Swimmer, here: Thickening, position: wp.vec3d, rotation: wp.mat33d, load: wp.spatial_vectord
) -> wp.spatial_vectord:
    """A fluid whose drag grows linearly with depth."""
    return (body.mobility * load) / (wp.float64(1.0) - position[2] / here.depth)


def thickening_around(scenarios, device):
    around = np.zeros(len(scenarios), dtype=Thickening.numpy_dtype())
    around["depth"] = DEPTH
    return wp.array(around, dtype=Thickening, device=device)


def test_a_mobility_that_depends_on_height():
    """Sinking at W / (a (1 + s / l)) covers the depth s = l (sqrt(1 + 2 W t / (a l)) - 1)."""
    run = scenario("20 s", **SINKING, distance=0.05)

    def formulas(given):
        return replace(system_of(given), medium=Medium(thickening, as_everywhere, thickening_around))

    (thick,), (plain,) = advance([run], system=formulas), advance([run])
    speed = 3e-4 / 0.1
    depth = DEPTH * (np.sqrt(1.0 + 2.0 * speed * thick.time / DEPTH) - 1.0)
    np.testing.assert_allclose(thick.states[:, 2], -depth, atol=1e-9)
    np.testing.assert_allclose(plain.states[:, 2], -speed * plain.time, atol=1e-9)


def test_extremes_and_means_of_an_interval_are_of_that_interval():
    """A device that sinks is highest where the sample before was, and lowest at its own."""
    (run,) = advance([scenario("20 s", **SINKING, distance=0.05)])
    heights = run.states[:, 2]
    assert np.all(np.diff(heights) < -1e-5)
    np.testing.assert_allclose(run.records["high"][1:], heights[:-1], rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(run.records["low"][1:], heights[1:], rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(run.records["height"][1:], 0.5 * (heights[:-1] + heights[1:]), rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("turns", [0.0, 0.4, math.nan])
def test_a_medium_whose_steps_would_be_longer_than_poses_are_known_for_is_refused(turns):
    with pytest.raises(hm.InputError, match="longest_step must be greater than zero and at most 0"):
        Medium(longest_step=turns)


# ------------------------------------------------------------------------------------------------------ another magnet


@wp.func
def halved(magnet: FieldSource, r: wp.vec3d, axis: wp.vec3d, m: wp.vec3d):
    """A magnet that has lost half its strength."""
    moment = HALF * magnet.moment * axis
    return dipole_field(r, moment), dipole_force(r, moment, m)


def test_a_new_magnet_model():
    weak, strong = scenario("20 s", magnets=[((0.0, 0.0, 0.0), 9.445)]), scenario("20 s")
    (expected,) = advance([weak], method=DOP853)
    (found,) = advance([strong], method=DOP853, system=lambda given: replace(system_of(given), magnet=halved))
    assert halved not in MAGNET_MODELS.values()
    np.testing.assert_allclose(found.states, expected.states, atol=1e-9)


# ------------------------------------------------------------------------------------------ launches, stopped, gone on


def test_what_comes_out_does_not_depend_on_where_launches_end(monkeypatch):
    """A launch may end after any trial step, between samples too."""
    runs = [scenario("9 s"), scenario("30 s", distance=0.040, beta=np.radians(5.0))]
    whole = advance(runs)
    monkeypatch.setattr(running_module, "FIRST_BUDGET", 3)
    monkeypatch.setattr(running_module, "LAUNCH_SECONDS", 1e-5)
    for before, after in zip(whole, advance(runs), strict=True):
        assert np.array_equal(before.time, after.time)
        assert np.array_equal(before.records, after.records)
        assert (before.steps, before.rejected) == (after.steps, after.rejected)


@pytest.mark.parametrize(
    ("stepping", "reading", "next_"),
    [(0.1, 1e-3, 1000), (0.05, 1e-3, 2000), (1e-9, 0.0, 4000), (0.2, 1e-3, 500), (900.0, 0.0, 1), (0.1, 0.3, 3000)],
)
def test_launches_are_short_but_take_as_long_as_reading_what_they_leave(stepping, reading, next_):
    """A thousand steps; of the last, on a GPU with many runs, reading takes three times as long as the steps."""
    assert running_module.next_budget(1000, stepping, reading) == pytest.approx(next_, rel=1e-3)


def test_a_long_run_is_stopped_at_once_keeps_what_it_has_and_goes_on_to_the_same_numbers():
    """Ten hours of direct steps, given up after a moment: at once, and nothing computed is lost."""
    run = hm.load("nose-first/fig3c").replaced(
        {"drive.frequency": "2.5 Hz", "run.duration": "10 h", "run.interval": "1 s"}
    )
    looks = advancing([run], method=DOP853)
    with closing(looks):
        for underway in looks:
            if underway.fraction > 0.001:
                break
        begun = time.perf_counter()
    stopped_within = time.perf_counter() - begun
    (kept,) = underway.histories()
    assert stopped_within < 2.0
    assert kept.status is End.RUNNING
    assert kept.time.size > 30
    assert np.array_equal(kept.time, np.arange(kept.time.size))
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("helimag-runs")]
    short = run.replaced({"run.duration": "600 s", "run.interval": "1 s"})
    np.testing.assert_array_equal(kept.states[:30], advance([short], method=DOP853)[0].states[:30])

    with pytest.raises(hm.InputError, match="same scenarios"):
        next(advancing([short], after=[kept]))


def test_going_on_gives_the_same_bits():
    runs = [scenario("40 s"), scenario("3 s", weight=2e-5)]
    whole = advance(runs)
    looks = advancing(runs)
    with closing(looks):
        first = next(looks).histories()
    for underway in advancing(runs, after=first):
        again = underway.histories()
    for one, other in zip(whole, again, strict=True):
        assert np.array_equal(one.records, other.records)
        assert one.status is other.status is End.HORIZON


def test_a_run_of_decades_can_be_stopped():
    """Its samples lie weeks apart: a launch is bounded by its steps, not by the time between samples."""
    run = hm.load("nose-first/fig3c").replaced({"drive.frequency": "2.5 Hz", "run.duration": "1e9 s"})
    looks = advancing([run])
    with closing(looks):
        next(looks)
        next(looks)
        begun = time.perf_counter()
    assert time.perf_counter() - begun < 5.0


def test_kernels_are_made_for_one_thread_at_a_time():
    """Warp's modules, and what is kept for a system, are not made for two: a page asks from several threads."""
    kernel = build_observe(system_of(hm.load("nose-first/fig3c")))
    inside, most = [], []

    def build():
        inside.append(None)
        most.append(len(inside))
        time.sleep(0.02)
        inside.pop()
        return kernel

    with ThreadPoolExecutor(4) as pool:
        made = list(pool.map(lambda _: ready(build, "cpu"), range(4)))
    assert made == [kernel] * 4
    assert max(most) == 1


def test_what_runs_share_is_packed_as_by_itself():
    """Parts that are the same object, equal ones, and others; magnets that a scenario has less are there as nothing."""
    one = hm.load("nose-first/fig3c")
    two = one.replaced({"magnet": [{**one.magnet[0].model_dump(), "offset": (0.0, y, 0.0)} for y in (0.0, 1e-2)]})
    thick = one.replaced({"fluid.viscosity": 2.0, "workspace.surface": "10 mm"})
    again = hm.load("nose-first/fig3c").replaced({"drive.distance": "0.2 m"})
    runs = [two, one, thick, one.replaced({"drive.pitch": 0.1}), again, two, thick]
    for pack in (pack_bodies, pack_bounds, pack_magnets):
        for run, packed in zip(runs, pack(runs), strict=True):
            alone = pack([run])[0]
            assert np.array_equal(packed[: len(run.magnet)] if pack is pack_magnets else packed, alone)
    assert not pack_magnets(runs)["moment"][1:5, 1].any()
