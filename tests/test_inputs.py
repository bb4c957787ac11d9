"""Scalar inputs: each reads back what was written; sweeps, orbits, maps and design mean and refuse the same."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy import stats

from helimag import InputError, Plan, load, preset_names
from helimag.cli._shared import input_range, scenario_from
from helimag.design import design
from helimag.orbits import stability_map, survey
from helimag.scenario import Input, LogUniform, Normal, Parameters, Uniform, scalar_inputs, varied
from helimag.sweeps import Axis, resolve

PRESETS = {name: load(name) for name in preset_names()}
SCENARIO = PRESETS["nose-first/fig3c"]
PITCH = Axis(field="drive.pitch", values=("1 deg", "2 deg"))
TWO_MAGNETS = SCENARIO.replaced(
    {"magnet": [{**SCENARIO.magnet[0].model_dump(), "offset": (0.0, y, 0.0)} for y in (0, 1e-2)]}
)


def test_every_preset_has_all_kinds_of_inputs():
    for name, scenario in PRESETS.items():
        paths = [given.path for given in scalar_inputs(scenario)]
        assert len(paths) == len(set(paths))
        assert {"drive.speed", "drive.start.y", "magnet.moment", "device.weight.net_weight", "fluid.viscosity"} <= {
            *paths
        }
        assert ("workspace.floor" in paths) == (scenario.workspace.floor is not None), name


@pytest.mark.parametrize("name", PRESETS)
@settings(max_examples=8, deadline=None)
@given(factor=st.floats(0.2, 5.0), shift=st.floats(-1e-3, 1e-3))
def test_what_is_written_is_read_back_and_changes_nothing_else(name, factor, shift):
    scenario = PRESETS[name]
    inputs = list(scalar_inputs(scenario))
    before = {each: each.value(scenario) for each in inputs}
    velocity = ("drive.velocity", "drive.speed")
    for one in inputs:
        value = before[one] * factor if before[one] != 0.0 else shift
        try:
            changed = one.changed(scenario, value)
        except InputError:
            continue  # such as a start outside the tank
        assert one.value(changed) == (abs(value) if one.path == "drive.speed" else value)
        touched = [each.path for each in inputs if each != one and each.value(changed) != before[each]]
        assert all(path.startswith(velocity) and one.path.startswith(velocity) for path in touched), (one, touched)


@pytest.mark.parametrize("name", PRESETS)
def test_every_input_can_be_set_to_what_it_is(name):
    for one in scalar_inputs(PRESETS[name]):
        assert one.changed(PRESETS[name], one.value(PRESETS[name])).hash == PRESETS[name].hash
        shown = one.show(PRESETS[name], one.value(PRESETS[name]), 17)
        assert one.read(PRESETS[name], shown) == pytest.approx(one.value(PRESETS[name]), rel=1e-15)


@settings(max_examples=50, deadline=None)
@given(velocity=st.tuples(*[st.floats(-1e-3, 1e-3)] * 3), speed=st.floats(0.0, 1e-2))
def test_speed_is_a_length_and_keeps_the_direction(velocity, speed):
    assume(math.hypot(*velocity) > 1e-6)
    base = SCENARIO.replaced({"drive.yaw_rate": 0.0, "drive.velocity": velocity})
    changed = Input("drive.speed").changed(base, speed).drive.velocity
    assert math.hypot(*changed) == pytest.approx(speed, rel=1e-14, abs=1e-300)
    np.testing.assert_allclose(np.cross(changed, velocity), 0.0, atol=1e-20)
    assert np.dot(changed, velocity) >= 0.0


def test_speed_from_rest_is_along_x_in_a_sweep_an_orbit_and_a_vector():
    rest = SCENARIO.replaced({"drive.yaw_rate": 0.0})
    swept = resolve(Plan(base=rest, axis=[Axis(field="drive.speed", values=("1 mm/s", "2 mm/s"))]))
    in_sweep = swept.scenario({"drive.speed": 2e-3}).drive
    orbits = stability_map(rest, ("drive.speed", [1e-3, 2e-3]), ("drive.frequency", [2.0, 3.3]))
    assert in_sweep.velocity == (2e-3, 0.0, 0.0)
    assert in_sweep == orbits.scenario_at(1, 1).drive
    assert in_sweep == Parameters.within(rest, {"drive.speed": (0.0, 1.0)}).scenario_at([2e-3]).drive
    assert in_sweep == scenario_from("nose-first/fig3c", ["drive.yaw_rate=0 deg/s", "drive.speed=2 mm/s"]).drive
    assert in_sweep == resolve(Plan(base=rest, changes={"drive.speed": "2 mm/s"}, axis=[PITCH])).base.drive
    assert Input("drive.speed").value(rest) == 0.0
    assert Input("drive.speed").changed(rest, -1e-3).drive.velocity == (-1e-3, 0.0, 0.0)


CANNOT = [
    (SCENARIO, "drive.start", "vary one of drive.start.x, drive.start.y, drive.start.z"),
    (SCENARIO, "drive.start.w", "drive.start has x, y, z"),
    (SCENARIO, "drive.pich", "is not a field of a scenario; drive has frequency, pitch"),
    (SCENARIO, "device.head.length", "device.head has shape, radius"),
    (SCENARIO, "device.weight.head_density", "vary one of device.weight.gravity_center, device.weight.net_weight"),
    (SCENARIO, "workspace.walls.x.low", "workspace.walls.x, which is not given"),
    (SCENARIO, "name", "it is text"),
    (SCENARIO, "magnet.0.moment", "magnet has moment, grade"),
    (TWO_MAGNETS, "magnet.moment", "by its index: magnet.0, magnet.1"),
]


@pytest.mark.parametrize(("scenario", "path", "words"), CANNOT, ids=[path for _, path, _ in CANNOT])
def test_what_cannot_be_varied_is_refused_alike_everywhere(scenario, path, words):
    limits = {path: (1.0, 2.0)}
    ways = [
        lambda: Input(path).changed(scenario, 1.0),
        lambda: Input(path).value(scenario),
        lambda: resolve(Plan(base=scenario, axis=[Axis(field=path, values=(1.0, 2.0))])),
        lambda: resolve(Plan(base=scenario, axis=[Axis(field=path, start="1 m", stop="2 m", count=3)])),
        lambda: survey(scenario, path, 1.0, 2.0),
        lambda: stability_map(scenario, (path, [1.0, 2.0]), ("drive.frequency", [2.0, 3.0])),
        lambda: design(scenario, limits=limits | {"drive.frequency": (2.0, 3.0)}),
        lambda: Parameters.within(scenario, limits),
        lambda: input_range("--vary", scenario, f"{path}=1 m..2 m"),
    ]
    messages = set()
    for way in ways:
        with pytest.raises(InputError) as caught:
            way()
        messages.add(str(caught.value))
    assert len(messages) == 1, messages
    assert words in messages.pop()


def test_words_are_listed_by_a_sweep_and_have_nothing_in_between():
    path = "device.helix.handedness"
    swept = resolve(Plan(base=SCENARIO, axis=[Axis(field=path, values=("left", "right"))]))
    assert swept.scenario({path: "right"}).device.helix.handedness == "right"
    messages = set()
    for way in (
        lambda: resolve(Plan(base=SCENARIO, axis=[Axis(field=path, start=1.0, stop=2.0, count=3)])),
        lambda: survey(SCENARIO, path, 1.0, 2.0),
    ):
        with pytest.raises(InputError, match="a choice of left, right") as caught:
            way()
        messages.add(str(caught.value))
    assert len(messages) == 1


def test_components_magnets_and_what_is_not_given_work_alike():
    cases = [
        (SCENARIO, "drive.start.y", -0.044),
        (TWO_MAGNETS, "magnet.1.offset.y", 0.02),
        (SCENARIO, "workspace.floor", -0.1),
    ]
    for scenario, path, value in cases:
        swept = resolve(Plan(base=scenario, axis=[Axis(field=path, values=("1 mm", "2 mm"))]))
        made = [
            Input(path).changed(scenario, value),
            swept.scenario({path: value}).replaced({"run.interval": scenario.run.interval}),
            Parameters.within(scenario, {path: (-1.0, 1.0)}).scenario_at([value]),
            scenario.replaced({path: f"{1e3 * value:g} mm"}),
        ]
        assert len({each.hash for each in made}) == 1
        assert Input(path).value(made[0]) == value
    assert SCENARIO.replaced({"drive.start.y": -0.044}).drive.start == (0.0, -0.044, SCENARIO.drive.start[2])
    assert TWO_MAGNETS.replaced({"magnet.1.moment": 3.0}).magnet[0] == TWO_MAGNETS.magnet[0]
    assert not Input("workspace.floor").within(SCENARIO, -1.0, 1.0)
    with pytest.raises(InputError, match="give it a value first"):
        Input("workspace.floor").value(SCENARIO)


def test_a_component_takes_the_mark_of_its_vector_away():
    assert "drive.start" in SCENARIO.provenance
    assert "drive.start" not in SCENARIO.replaced({"drive.start.y": -0.044}).provenance
    marks = {"magnet.moment": "measured: here", "magnet.radius": "measured: here"}
    marked = TWO_MAGNETS.replaced({"provenance": marks})
    assert list(marked.replaced({"magnet.1.moment": 3.0}).provenance) == ["magnet.radius"]


def test_inputs_that_change_the_same_field_are_refused_together():
    both = {"drive.speed": 1e-3, "drive.velocity.y": 1e-3}
    axes = [Axis(field=path, values=("1 mm/s", "2 mm/s")) for path in both]
    for way in (
        lambda: varied(SCENARIO, both),
        lambda: Parameters.within(SCENARIO, dict.fromkeys(both, (0.0, 1.0))),
        lambda: resolve(Plan(base=SCENARIO, axis=axes)),
    ):
        with pytest.raises(InputError, match="change the same field"):
            way()
    with pytest.raises(InputError, match=r"'run\.interval' has no effect"):
        resolve(Plan(base=SCENARIO, axis=[Axis(field="run.interval", values=("1 s", "2 s"))]))


def test_labels_and_names():
    labels = {
        "drive.pitch": "pitch",
        "device.helix.pitch": "helix_pitch",
        "drive.start.y": "start_y",
        "magnet.moment": "moment",
        "magnet.1.moment": "magnet_1_moment",
        "workspace.walls.x.low": "walls_x_low",
    }
    assert {path: Input(path).label for path in labels} == labels
    assert (Input("drive.yaw_rate").name, Input("drive.start.y").name) == ("yaw rate", "start y")


PRIORS = {
    "drive.pitch": (Uniform(0.1, 0.3), stats.uniform(0.1, 0.2)),
    "fluid.viscosity": (LogUniform(0.1, 10.0), stats.loguniform(0.1, 10.0)),
    "drive.distance": (Normal(0.15, 0.01), stats.norm(0.15, 0.01)),
    "drive.frequency": (Normal(2.0, 1.0, low=1.0, high=4.0), stats.truncnorm(-1.0, 2.0, loc=2.0, scale=1.0)),
}
VECTOR = Parameters.of(SCENARIO, {path: prior for path, (prior, _) in PRIORS.items()})


def test_the_prior_transform_is_the_quantile_of_each_prior():
    """Against scipy's cumulative distributions, which the transform does not use."""
    shares = np.random.default_rng(0).random((5, 7, 4))
    values = VECTOR.from_unit(shares)
    assert values.shape == shares.shape
    for i, (_, law) in enumerate(PRIORS.values()):
        np.testing.assert_allclose(law.cdf(values[..., i]), shares[..., i], rtol=1e-9, atol=1e-12)
    np.testing.assert_array_equal(VECTOR.low, [0.1, 0.1, -np.inf, 1.0])
    np.testing.assert_array_equal(VECTOR.high, [0.3, 10.0, np.inf, 4.0])


def test_vectors_and_scenarios_are_each_others_inverse():
    rows = VECTOR.from_unit(np.random.default_rng(1).random((6, 4)))
    np.testing.assert_array_equal([VECTOR.vector(each) for each in VECTOR.scenarios(rows)], rows)
    assert VECTOR.names == ("pitch", "viscosity", "distance", "frequency")
    assert VECTOR.units == ("rad", "Pa s", "m", "Hz")
    assert VECTOR.show([math.radians(12.7), 1.0, 0.15, 3.3])["drive.pitch"] == "12.7 deg"


def test_inside_clip_and_nearest():
    inner = [0.2, 1.0, 0.15, 2.0]
    outer = [0.4, 1.0, 0.15, 2.0]
    np.testing.assert_array_equal(VECTOR.inside([inner, outer, [math.nan, *inner[1:]]]), [True, False, False])
    np.testing.assert_array_equal(VECTOR.clip(outer), [0.3, 1.0, 0.15, 2.0])
    floor = Parameters.within(SCENARIO, {"workspace.floor": (-0.2, -0.1), "drive.distance": (0.2, 0.3)})
    np.testing.assert_allclose(floor.nearest(SCENARIO), [-0.15, 0.2])


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (lambda: Uniform(2.0, 1.0), "finite low below its high; got 2, 1"),
        (lambda: Uniform(math.nan, 1.0), "finite low below"),
        (lambda: LogUniform(0.0, 1.0), "a low above zero; got 0"),
        (lambda: Normal(0.0, 0.0), "a deviation above zero"),
        (lambda: Normal(0.0, 1.0, low=math.nan), "a low below its high"),
        (lambda: Parameters.of(SCENARIO, {}), "at least one input"),
        (lambda: Parameters(SCENARIO, (("drive.pitch", Uniform(0.0, 1.0)),) * 2), "'drive.pitch' twice"),
        (lambda: Parameters.within(SCENARIO, {"drive.pitch": (1.0, 1.0)}), "limits of drive.pitch must be a lower"),
        (lambda: VECTOR.from_unit([0.5, 0.5, 0.5, 1.5]), "unit cube"),
        (lambda: VECTOR.from_unit([0.5, 0.5, 0.5, math.nan]), "unit cube"),
        (lambda: VECTOR.scenarios([[0.2, 1.0, 0.15]]), "one for each of 4 inputs"),
        (lambda: VECTOR.scenario_at([math.nan, 1.0, 0.15, 2.0]), "drive.pitch must be a finite number"),
        (lambda: varied(SCENARIO, {"drive.speed": math.nan}), "drive.speed must be a finite number of m/s"),
        (lambda: varied(SCENARIO, {"drive.speed": "2 mm"}), "drive.speed must be a velocity"),
        (lambda: varied(SCENARIO, {"drive.speed": 1e-3, "drive.velocity": (0.0, 0.0, 0.0)}), "change the same field"),
        (lambda: Input("drive.pitch").read(SCENARIO, "12 mm"), "drive.pitch must be an angle"),
    ],
)
def test_what_is_wrong_is_named_in_a_line(wrong, words):
    with pytest.raises(InputError) as caught:
        wrong()
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)
