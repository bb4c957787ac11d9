"""Plans: axes with units, crossed, zipped and sampled; what they refuse, and in which words."""

import math
from pathlib import Path

import numpy as np
import pytest

from helimag import InputError, Plan, load
from helimag.scenario import Input, varied
from helimag.sweeps import Axis, Boundary, Sampling, load_plan, parse_plan, resolve

BASE = "nose-first/fig3c"
TEXT = """
name = "both"
base = "nose-first/fig3c"
duration = "100 s"

[changes]
"drive.distance" = "149 mm"

[[axis]]
field = "drive.frequency"
values = ["2 Hz", "2.5 Hz"]

[[axis]]
field = "drive.pitch"
start = "10 deg"
stop = "13 deg"
step = "0.3 deg"
"""


def plan(*axes: Axis, **more: object) -> Plan:
    return Plan(base=BASE, duration="100 s", axis=axes, **more)


def all_points(design):
    return [point for chunk in range(len(design.chunks)) for point in design.points(chunk)]


def test_a_plan_survives_its_own_file():
    first = parse_plan(TEXT)
    assert parse_plan(first.to_toml()) == first
    assert resolve(parse_plan(first.to_toml())).identity == resolve(first).identity


def test_crossed_axes_give_every_combination_once_with_values_as_read_from_text():
    design = resolve(parse_plan(TEXT))
    assert design.shape == {"frequency": 2, "pitch": 11}
    points = all_points(design)
    pitches = [10.0 + 0.3 * i for i in range(11)]
    expected = {
        (f, load(BASE).replaced({"drive.pitch": f"{p:.12g} deg"}).drive.pitch) for f in (2.0, 2.5) for p in pitches
    }
    assert {(point["drive.frequency"], point["drive.pitch"]) for point in points} == expected
    assert len(points) == 22
    scenario = design.scenario(points[0])
    assert (scenario.drive.frequency, scenario.drive.distance, scenario.run.duration) == (2.0, 0.149, 100.0)


@pytest.mark.parametrize("shape", [(7,), (3, 19), (5, 40, 6), (300,), (2, 1000)])
def test_chunks_cover_every_run_once(shape):
    names = ("drive.frequency", "drive.pitch", "drive.yaw_rate")
    units = ("Hz", "deg", "deg/s")
    axes = [
        Axis(field=name, start=f"1 {unit}", stop=f"2 {unit}", count=count)
        for name, unit, count in zip(names, units, shape, strict=False)
    ]
    design = resolve(plan(*axes))
    seen = np.zeros(shape, int)
    for chunk in range(len(design.chunks)):
        seen[design.block(chunk)] += 1
        assert math.prod(design.extent(chunk)) <= max(8, math.prod(shape) // 16)
    assert np.all(seen == 1)


@pytest.mark.parametrize(
    ("duration", "count", "runs", "chunks"),
    [("1800 s", 10_000, 60, 167), ("1 s", 10_000, 590, 17), ("1800 s", 10**6, 4000, 250)],
)
def test_chunks_grow_with_the_sweep_and_where_runs_are_short(duration, count, runs, chunks):
    """In half-hour runs a kill costs 64 at most; a million runs lie in some hundred chunks: reopening reads each."""
    frequency = Axis(field="drive.frequency", start="1 Hz", stop="2 Hz", count=count // 10)
    pitch = Axis(field="drive.pitch", start="1 deg", stop="2 deg", count=10)
    design = resolve(plan(frequency, pitch).model_copy(update={"duration": duration}))
    assert (math.prod(design.chunk_shape), len(design.chunks)) == (runs, chunks)


def test_trajectories_keep_chunks_small():
    """What a chunk of a large sweep holds stays within 64 MiB."""
    axis = Axis(field="drive.frequency", start="1 Hz", stop="2 Hz", count=500_000)
    design = resolve(plan(axis, trajectory="0.1 s"))
    assert 0.9 * 2**26 < math.prod(design.chunk_shape) * 1001 * 56 <= 2**26


def test_samples_are_counted_of_the_longest_runs():
    """Durations may be swept: those of the base would let a store of terabytes begin."""
    pitch = Axis(field="drive.pitch", start="1 deg", stop="2 deg", count=1000)
    resolve(plan(pitch, Axis(field="run.duration", values=("100 s", "900 s")), trajectory="0.1 s"))
    with pytest.raises(InputError, match=r"trajectory keeps 2e\+09 samples of all runs"):
        resolve(plan(pitch, Axis(field="run.duration", values=("100 s", "100000 s")), trajectory="0.1 s"))
    both = pitch, Axis(field="run.duration", start="10 s", stop="900 s", count=4)
    assert resolve(plan(*both, boundary=Boundary(budget=5000))).longest == 900.0


@pytest.mark.parametrize("field", ["drive.pitch", "run.duration", "drive.speed"])
@pytest.mark.parametrize("trajectory", [None, "0.5 s"])
def test_a_point_is_the_base_changed_whichever_way_it_is_made(field, trajectory):
    """Points of the base's duration are made of a base that is sampled already; none can tell."""
    value = {"drive.pitch": 0.2, "run.duration": 40.0, "drive.speed": 1e-3}[field]
    shown = {"drive.pitch": ["11 deg", "12 deg"], "run.duration": ["40 s", "50 s"], "drive.speed": ["1 mm/s", "2 mm/s"]}
    plan = Plan(
        base="paper/fig3c",
        duration="60 s",
        samples=20,
        trajectory=trajectory,
        axis=(Axis(field=field, values=shown[field]),),
    )
    resolved = resolve(plan)
    interval = 0.5 if trajectory else (2.0 if field == "run.duration" else 3.0)
    direct = varied(resolved.base, {field: value, "run.interval": interval})
    made = resolved.scenario({field: value})
    assert made == direct
    assert (made.title, made.hash, made.provenance) == (direct.title, direct.hash, direct.provenance)


def test_spread_points_are_runs_of_the_plan_each_once_and_the_corners_where_asked():
    axes = [Axis(field=f"drive.{name}", start=f"1 {unit}", stop=f"2 {unit}", count=50)
            for name, unit in (("frequency", "Hz"), ("pitch", "deg"))]  # fmt: skip
    design = resolve(plan(*axes))
    every = {tuple(point.values()) for point in all_points(design)}
    some = [tuple(point.values()) for point in design.spread(100)]
    assert len(set(some)) == len(some) == 100
    assert set(some) <= every
    frequencies, pitches = (axis.values for axis in design.axes)
    corners = {(f, p) for f in (frequencies[0], frequencies[-1]) for p in (pitches[0], pitches[-1])}
    assert corners <= {tuple(point.values()) for point in design.spread(100, corners=True)}
    assert {tuple(point.values()) for point in design.spread(10**6)} == every


def test_zipped_axes_move_together_and_cross_with_the_others():
    design = resolve(
        plan(
            Axis(field="drive.frequency", values=("2 Hz", "3 Hz"), zip="case"),
            Axis(field="drive.pitch", values=("14 deg", "11 deg"), zip="case"),
            Axis(field="drive.distance", values=("140 mm", "150 mm", "160 mm")),
        )
    )
    assert design.shape == {"case": 2, "distance": 3}
    pairs = {
        (point["drive.frequency"], round(math.degrees(float(point["drive.pitch"])))) for point in all_points(design)
    }
    assert pairs == {(2.0, 14), (3.0, 11)}
    with pytest.raises(InputError, match="as many values each; got 2 and 3"):
        resolve(
            plan(
                Axis(field="drive.frequency", values=("2 Hz", "3 Hz"), zip="case"),
                Axis(field="drive.pitch", values=("1 deg", "2 deg", "3 deg"), zip="case"),
            )
        )


@pytest.mark.parametrize("method", ["sobol", "latin-hypercube"])
def test_samples_lie_in_their_bounds_spread_evenly_and_repeat_with_the_seed(method):
    def made(seed):
        design = resolve(
            plan(
                Axis(field="drive.frequency", start="2 Hz", stop="3 Hz"),
                Axis(field="drive.pitch", start="5 deg", stop="15 deg"),
                sample=Sampling(method=method, count=48, seed=seed),
            )
        )
        return np.array([list(point.values()) for point in all_points(design)])

    points = made(1)
    assert points.shape == (48, 2)
    assert points[:, 0].min() >= 2.0
    assert points[:, 0].max() <= 3.0
    assert np.all((points[:, 1] >= math.radians(5.0)) & (points[:, 1] <= math.radians(15.0)))
    quarters = np.histogram(points[:, 0], bins=4, range=(2.0, 3.0))[0]
    assert quarters.min() >= 10  # 12 +- 2; by mere chance one in three such sets would fail
    np.testing.assert_array_equal(points, made(1))
    assert not np.array_equal(points, made(2))


def test_speed_is_the_length_of_the_velocity_in_its_direction():
    axis = Axis(field="drive.speed", values=("1 mm/s", "2 mm/s"))
    straight = resolve(plan(axis))
    assert straight.scenario({"drive.speed": 0.002}).drive.velocity == (0.002, 0.0, 0.0)
    oblique = resolve(plan(axis, changes={"drive.velocity": ["3 mm/s", "4 mm/s", "0 mm/s"]}))
    assert oblique.scenario({"drive.speed": 0.01}).drive.velocity == pytest.approx((0.006, 0.008, 0.0), rel=1e-15)


def test_any_field_may_be_an_axis_under_a_name_of_its_own():
    axes = (
        Axis(field="device.helix.pitch", values=("2.5 mm", "2.6 mm")),
        Axis(field="device.hydrodynamics.model", values=("lighthill", "gray-hancock")),
        Axis(field="workspace.floor", values=("-80 mm", "-60 mm")),
    )
    design = resolve(plan(*axes))
    assert list(design.shape) == ["helix_pitch", "hydrodynamics_model", "floor"]
    scenario = design.scenario(list(design.points(0))[-1])
    assert scenario.device.hydrodynamics.model == "gray-hancock"
    assert scenario.workspace.floor == -0.06


def test_kinds_come_from_the_scenario():
    scenario = load(BASE)
    fields = {"drive.pitch": "rad", "run.interval": "s", "device.head.radius": "m", "magnet.moment": "A m^2"}
    assert {field: Input(field).kind(scenario).si for field in fields} == fields


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ('values = ["2 Hz", "2.5 Hz"]', ("values = [2.0, 2.5]", "must be a frequency written with its unit")),
        ('values = ["2 Hz", "2.5 Hz"]', ('values = ["2 mm"]', "must be a frequency such as '3.3 Hz'; got '2 mm'")),
        ('values = ["2 Hz", "2.5 Hz"]', ('values = ["2 Hz", "2 Hz"]', "must not have a value twice")),
        ('field = "drive.pitch"', ('field = "drive.pich"', "'drive.pich' is not a field")),
        ('field = "drive.pitch"', ('field = "drive.start"', "must be a single number")),
        ('step = "0.3 deg"', ('step = "-0.3 deg"', "a step that leads from start to stop")),
        ('step = "0.3 deg"', ('step = "0.3 deg"\ncount = 3', "must have values, or start and stop")),
        ('step = "0.3 deg"', ('stepp = "0.3 deg"', "stepp is not a known key")),
        ('duration = "100 s"', ("duration = 100.0", "duration must be a time written with its unit")),
        ('base = "nose-first/fig3c"', ('base = "paper/none"', "preset")),
        ('name = "both"', ("[", "not valid TOML")),
    ],
)
def test_what_does_not_fit_is_named(change, words):
    text, message = TEXT.replace(change, words[0], 1), words[1]
    assert text != TEXT
    with pytest.raises((InputError, OSError)) as caught:
        resolve(parse_plan(text, "p.toml"))
    assert message in str(caught.value)


def test_sampling_and_boundaries_refuse_axes_of_another_form():
    grid = Axis(field="drive.pitch", start="5 deg", stop="15 deg", count=5)
    bounds = Axis(field="drive.frequency", start="2 Hz", stop="3 Hz")
    for axes, more in (
        ((grid, bounds), {}),
        ((grid, bounds), {"sample": Sampling(method="sobol", count=8)}),
        ((grid, bounds), {"boundary": Boundary(budget=64)}),
        ((grid,), {"boundary": Boundary(budget=64)}),
    ):
        with pytest.raises(ValueError, match=r"must be a|needs two axes"):
            plan(*axes, **more)


def test_a_base_beside_the_plan_is_found_from_anywhere(tmp_path: Path):
    (tmp_path / "mine.toml").write_text(load(BASE).to_toml(), encoding="utf-8")
    (tmp_path / "plan.toml").write_text(TEXT.replace("nose-first/fig3c", "mine.toml"), encoding="utf-8")
    assert resolve(load_plan(tmp_path / "plan.toml")).identity == resolve(parse_plan(TEXT)).identity
