"""Scenarios: presets and their marks, TOML there and back, refusals that name field, value and expectation."""

import hashlib
import json
import math
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import BaseModel

import helimag as hm
import oracles
from helimag import quantities as q
from helimag.scenario import MARKS, Scenario, parse, schema

PRESETS = hm.preset_names()
TEXT = hm.load("nose-first/fig3c").to_toml()


def leaves(model, prefix=""):
    """Dotted names of all values that a scenario's file gives, one for an array."""
    for name, held in model:
        single = isinstance(held, tuple) and len(held) == 1 and isinstance(held[0], BaseModel)
        value = held[0] if single else held
        if isinstance(value, BaseModel):
            yield from leaves(value, f"{prefix}{name}.")
        elif value is not None:
            yield f"{prefix}{name}"


# -------------------------------------------------------------------------------------------------------------- presets


def test_the_papers_presets_are_there():
    runs = [f"fig3{x}" for x in "abc"] + [f"table1-row{i}" for i in range(1, 8)]
    assert sorted(f"{family}/{run}" for family in ("paper", "nose-first") for run in runs) == PRESETS


@pytest.mark.parametrize("name", PRESETS)
def test_every_value_of_a_preset_is_marked(name):
    scenario = hm.load(name)
    assert scenario.name == name
    silent = {"name", "provenance", "magnet.offset"}  # the offset of a single magnet is what places it
    values = {leaf for leaf in leaves(scenario) if leaf not in silent}
    marked = set(scenario.provenance)
    # walls are marked as a whole
    values = {"workspace.walls" if value.startswith("workspace.walls") else value for value in values}
    assert marked <= values, "marks of fields that are not there"
    assert values - marked <= {"workspace.walls"} if scenario.workspace.walls.x is None else values == marked
    for mark in scenario.provenance.values():
        kind, colon, source = mark.partition(":")
        assert kind in MARKS
        assert colon
        assert len(source) > 5, "a mark must name its source"


PUBLISHED = {
    f"{family}/fig3{run}": numbers
    for family in ("paper", "nose-first")
    for run, numbers in {
        "a": (3.3, 15.0, 0.152, 1.8, 1800.0),
        "b": (3.3, 10.0, 0.150, 1.8, 1800.0),
        "c": (3.3, 12.7, 0.150, 1.8, 1800.0),
    }.items()
}
TABLE_1 = [
    (13, 102, 0.825),
    (0, 102, 0.825),
    (20, 102, 0.825),
    (13, 91.34, 0.825),
    (13, 111.87, 0.825),
    (13, 102, 0.412),
]
TABLE_1 += [(13, 102, 1.571)]


@pytest.mark.parametrize("name", PUBLISHED)
def test_circular_presets_hold_the_captions_numbers(name):
    scenario = hm.load(name)
    drive = scenario.drive
    ours = (
        drive.frequency,
        math.degrees(drive.pitch),
        drive.distance,
        math.degrees(drive.yaw_rate),
        scenario.run.duration,
    )
    assert ours == pytest.approx(PUBLISHED[name], rel=1e-14)
    # Fig. 3(B) may start a micrometre aside, if its mark says so
    assert drive.start == pytest.approx((0.0, -0.045, 0.0), abs=1.1e-6)
    if drive.start != (0.0, -0.045, 0.0):
        assert scenario.provenance["drive.start"].startswith("assumed")
    device = scenario.device
    assert (device.magnetic_moment, scenario.magnet[0].moment) == (6.23e-4, 18.89)
    sizes = device.helix.length, device.helix.outer_diameter, device.helix.pitch
    assert sizes == pytest.approx((0.0117, 0.00094, 0.00259), rel=1e-15)
    assert scenario.fluid.density == 971.0
    if scenario.fluid.viscosity != 1.0:
        assert scenario.provenance["fluid.viscosity"].startswith("fitted")
        assert "1 Pa s" in scenario.provenance["fluid.viscosity"]


@pytest.mark.parametrize("row", range(1, 8))
@pytest.mark.parametrize("family", ["paper", "nose-first"])
def test_straight_presets_hold_the_tables_numbers(family, row):
    scenario = hm.load(f"{family}/table1-row{row}")
    pitch, distance, speed = TABLE_1[row - 1]
    assert scenario.drive.frequency == 3.5
    assert math.degrees(abs(scenario.drive.pitch)) == pytest.approx(pitch)
    if scenario.drive.pitch < 0.0:
        assert "assumed: the axis dips" in scenario.provenance["drive.pitch"]
    assert scenario.drive.distance == pytest.approx(1e-3 * distance, rel=1e-14)
    assert np.linalg.norm(scenario.drive.velocity) == pytest.approx(1e-3 * speed, rel=1e-14)
    assert scenario.drive.yaw_rate == 0.0
    assert scenario.run.duration * speed == pytest.approx(160.0, rel=1e-3)
    low, high = np.array(scenario.workspace.box)
    assert np.all(high[:2] - low[:2] <= np.array([0.2, 0.08]) * (1 + 1e-12))
    assert high[2] - low[2] <= 0.08


def test_the_experiments_presets_keep_what_is_published_and_fit_three_values():
    rows = [hm.load(f"paper/table1-row{row}") for row in range(1, 8)]
    for row in rows:
        assert (row.fluid.viscosity, row.device.head.radius) == (1.0, 0.5e-3)
        assert row.device.hydrodynamics.model == "boundary"
        assert row.drive.heading == "helix"
        fitted = {path for path, mark in row.provenance.items() if mark.startswith("fitted")}
        assert fitted == {"device.weight.net_weight", "device.weight.gravity_center", "workspace.surface"}
    assert len({(row.device, row.workspace) for row in rows}) == 1, "one device in one tank"


def test_the_simulations_presets_are_one_device_that_starts_helix_first_where_the_paper_says():
    runs = [hm.load(f"paper/fig3{run}") for run in "abc"]
    assert len({(run.device, run.fluid) for run in runs}) == 1
    for run in runs:
        assert run.device.hydrodynamics.model == "lighthill"
        assert (run.drive.heading, run.drive.start) == ("helix", (0.0, -0.045, 0.0))
        assert run.provenance["drive.heading"].startswith("assumed")


# ------------------------------------------------------------------------------------------------------ there and back

sizes = st.floats(1e-6, 1e3) | st.floats(min_value=1e-300, max_value=1e300)
anything = st.floats(allow_nan=False, allow_infinity=False)


def signed(most, least=0.0):
    """Numbers of either sign within the limits of a kind."""
    return st.builds(math.copysign, st.floats(least, most), st.sampled_from([-1.0, 1.0]))


@given(
    viscosity=st.floats(1e-6, 1e6),
    density=st.floats(min_value=0, allow_infinity=False, allow_nan=False),
    moment=sizes,
    weight=anything,
    place=signed(100.0),
    frequency=signed(1e4, 1e-6),
    pitch=st.floats(-1.57, 1.57),
    yaw=signed(62.0),
    velocity=st.tuples(signed(100.0), signed(100.0), signed(100.0)),
    duration=st.floats(1e-3, 1e8),
    interval=st.none() | st.floats(1e-3, 10.0),
    name=st.text(st.characters(codec="utf-8", exclude_categories=("Cc", "Zl", "Zp"))),
    head=st.sampled_from(
        [
            {"shape": "sphere", "radius": 3.3e-4},
            {"shape": "cylinder", "length": 1 / 3e3, "diameter": 1e-3 / 7},
            {"shape": "spheroid", "length": 1 / 3e3, "diameter": 1e-3 / 7},
        ]
    ),
)
@settings(max_examples=40, deadline=None)
def test_toml_there_and_back_is_exact(
    viscosity, density, moment, weight, place, frequency, pitch, yaw, velocity, duration, interval, name, head
):
    scenario = hm.load("nose-first/table1-row1").replaced(
        {
            "name": name,
            "fluid": {"viscosity": viscosity, "density": density},
            "device.magnetic_moment": moment,
            "device.weight": {"net_weight": weight, "gravity_center": place},
            "device.head": head,
            "drive.frequency": frequency,
            "drive.pitch": pitch,
            "drive.yaw_rate": yaw,
            "drive.velocity": velocity,
            "run": {"duration": duration, "interval": None if interval is None else interval * duration},
        }
    )
    again = parse(scenario.to_toml())
    assert again == scenario
    assert again.hash == scenario.hash
    assert again.to_toml() == scenario.to_toml()


@pytest.mark.parametrize("name", PRESETS)
def test_presets_survive_being_written(name):
    assert parse(hm.load(name).to_toml()) == hm.load(name)


def test_several_magnets_and_a_matrix_survive_being_written():
    magnets = [((0.01, -0.05, 0.02), 18.89), ((-0.03, 0.04, 0.01), 1 / 3)]
    scenario = oracles.scenario_of(oracles.case(magnets=magnets, matrix=np.eye(6) / 3))
    assert parse(scenario.to_toml()) == scenario


@given(
    value=anything, kind=st.sampled_from([q.LENGTH, q.ANGLE, q.ANGULAR_RATE, q.FREQUENCY, q.FORCE, q.VISCOSITY, q.TIME])
)
@settings(max_examples=200, deadline=None)
def test_quantities_there_and_back_are_exact(value, kind):
    assert q.parse(q.show(value, kind), kind) == value


@given(
    text=st.text(max_size=30) | st.from_regex(r"[-+]?\d+(\.\d*)?([eE][-+]?\d+)? ?[a-zA-Z0-9 /*^.°µ-]*", fullmatch=True)
)
@settings(max_examples=300, deadline=None)
def test_any_text_is_a_finite_number_or_refused(text):
    try:
        assert math.isfinite(q.parse(text, q.LENGTH))
    except hm.InputError as error:
        message = str(error)
    else:
        return
    assert message.startswith("must be a length such as '150 mm'; got ")


@pytest.mark.parametrize(
    ("text", "kind", "value"),
    [
        ("150 mm", q.LENGTH, 0.15),
        ("15cm", q.LENGTH, 0.15),
        ("-2.189 mm", q.LENGTH, -2.189e-3),
        ("180 deg", q.ANGLE, math.pi),
        ("180°", q.ANGLE, math.pi),
        ("60 rpm", q.ANGULAR_RATE, 2 * math.pi),
        ("1 Hz", q.FREQUENCY, 1.0),
        ("28.28 uN", q.FORCE, 28.28e-6),
        ("28.28 µN", q.FORCE, 28.28e-6),
        ("10 P", q.VISCOSITY, 1.0),
        ("1 g/cm^3", q.DENSITY, 1000.0),
        ("0.971 g/cm³", q.DENSITY, 971.0),
        ("30 min", q.TIME, 1800.0),
    ],
)
def test_units(text, kind, value):
    assert q.parse(text, kind) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(("text", "kind", "value"), [("5 um", q.LENGTH, 5e-6), ("28.28 uN", q.FORCE, 28.28e-6)])
def test_decimal_units_are_exact(text, kind, value):
    """To the last bit, so that a file and Python's own literal are the same run."""
    assert q.parse(text, kind) == value


def test_a_grade_is_remanence_times_volume():
    """35 x 20 mm of N45: the 20.67 A m^2 found elsewhere for the paper's magnet, whose own 18.89 lies outside."""
    text = TEXT.replace('moment = "18.89 A m^2"', 'grade = "N45"')
    magnet = parse(text).magnet[0]
    volume = math.pi * 0.0175**2 * 0.020
    assert magnet.dipole_moment == pytest.approx(1.35 * volume / (4e-7 * math.pi), rel=1e-12)
    assert magnet.dipole_moment == pytest.approx(20.67, abs=0.005)
    assert magnet.dipole_moment_uncertainty == pytest.approx(0.03 * volume / (4e-7 * math.pi), rel=1e-9)
    assert magnet.dipole_moment - 18.89 > 3 * magnet.dipole_moment_uncertainty
    assert parse(parse(text).to_toml()) == parse(text)
    # changing a size changes the moment with it
    assert parse(text).replaced({"magnet.height": "40 mm"}).magnet[0].dipole_moment == 2 * magnet.dipole_moment


def test_a_remanence_is_a_grade_without_a_range():
    magnet = parse(TEXT.replace('moment = "18.89 A m^2"', 'remanence = "1350 mT"')).magnet[0]
    assert magnet.dipole_moment == pytest.approx(20.67, abs=0.005)
    assert magnet.dipole_moment_uncertainty is None
    known = hm.load("nose-first/fig3c").replaced({"magnet.moment_uncertainty": "0.5 A m^2"})
    assert known.magnet[0].dipole_moment_uncertainty == 0.5
    assert known.hash == hm.load("nose-first/fig3c").hash


def test_a_run_of_a_grade_is_that_of_its_moment():
    graded = parse(TEXT.replace('moment = "18.89 A m^2"', 'grade = "N45"'))
    given = hm.load("nose-first/fig3c").replaced({"magnet.moment": graded.magnet[0].dipole_moment})
    assert (
        hm.simulate(graded, duration=2.0).final_state.tolist() == hm.simulate(given, duration=2.0).final_state.tolist()
    )


# ------------------------------------------------------------------------------------------------------------- refusals

REFUSED = [
    # change of the text, what the message must hold
    (('pitch = "12.7 deg"', 'pitch = "150 mm"'), ["drive.pitch", "an angle such as '12.7 deg'", "'150 mm'"]),
    (('pitch = "12.7 deg"', "pitch = 12.7"), ["drive.pitch", "unit", "12.7"]),
    (('pitch = "12.7 deg"', 'pitch = "12.7"'), ["drive.pitch", "no unit"]),
    (('pitch = "12.7 deg"', 'pitch = "91 deg"'), ["drive.pitch", "90 deg", "'91 deg'"]),
    (('pitch = "12.7 deg"', 'pitch = "nan deg"'), ["drive.pitch", "nan deg", "finite"]),
    (('pitch = "12.7 deg"', 'pitch = "inf deg"'), ["drive.pitch", "inf deg"]),
    (('pitch = "12.7 deg"', 'pitch = "1e999 deg"'), ["drive.pitch", "1e999 deg", "finite"]),
    (('pitch = "12.7 deg"', "pitch = nan"), ["drive.pitch", "nan"]),
    (('pitch = "12.7 deg"', "pitch = true"), ["drive.pitch", "True"]),
    (('pitch = "12.7 deg"', 'pich = "12.7 deg"'), ["drive.pich", "not a known key"]),
    (('frequency = "3.3 Hz"', 'frequency = "20 rad/s"'), ["drive.frequency", "Hz, 1/s, rev/s, rpm", "20 rad/s"]),
    (('frequency = "3.3 Hz"', 'frequency = "0 Hz"'), ["drive.frequency", "zero"]),
    (('yaw_rate = "1.8 deg/s"', 'yaw_rate = "1.8 Hz"'), ["drive.yaw_rate", "1.8 Hz"]),
    (('distance = "150 mm"', 'distance = "-150 mm"'), ["drive.distance", "positive", "-150 mm"]),
    (('distance = "150 mm"', 'distance = "15 mm"'), ["drive.distance", "exceed", "15 mm"]),
    (('radius = "0.3603 mm"', 'radius = "-1 mm"'), ["device.head", "radius", "positive", "-1 mm"]),
    (('wire_radius = "0.2128 mm"', 'wire_radius = "0.5 mm"'), ["wire_radius", "0.47 mm", "0.5 mm"]),
    (('wire_radius = "0.2128 mm"', 'wire_radius = "0 mm"'), ["wire_radius", "positive"]),
    (('handedness = "left"', 'handedness = "sinister"'), ["device.helix.handedness", "left", "sinister"]),
    (('viscosity = "1 Pa s"', 'viscosity = "0 Pa s"'), ["fluid.viscosity", "positive"]),
    (('viscosity = "1 Pa s"', 'viscosity = "1 m^2/s"'), ["fluid.viscosity", "1 m^2/s"]),
    (('duration = "1800 s"', 'duration = "0 s"'), ["run.duration", "positive"]),
    (('net_weight = "28.28 uN"', ""), ["device.weight", "net_weight"]),
    (('model = "lighthill"', 'model = "matrix"'), ["device.hydrodynamics", "resistance"]),
    (('model = "lighthill"', 'model = "guess"'), ["device.hydrodynamics.model", "guess", "lighthill"]),
    (('shape = "sphere"', 'shape = "cube"'), ["device.head", "cube"]),
    (('shape = "sphere"', 'shape = "cylinder"'), ["device.head", "length"]),
    (('moment = "18.89 A m^2"', ""), ["magnet needs one of moment, grade and remanence", "none"]),
    (('moment = "18.89 A m^2"', 'moment = "18.89 A m^2"\ngrade = "N45"'), ["magnet needs one of", "moment and grade"]),
    (('moment = "18.89 A m^2"', 'grade = "N44"'), ["magnet.grade", "N44", "N45"]),
    (('moment = "18.89 A m^2"', 'remanence = "-1 T"'), ["magnet.remanence", "positive"]),
    (('moment = "18.89 A m^2"', 'remanence = "1 Hz"'), ["magnet.remanence", "a flux density", "1 Hz"]),
    (
        ('moment = "18.89 A m^2"', 'grade = "N45"\nmoment_uncertainty = "1 A m^2"'),
        ["magnet.moment_uncertainty", "leave it out"],
    ),
    (('field = "dipole"', 'field = "octopole"'), ["magnet.field", "octopole"]),
]


@pytest.mark.parametrize(("change", "expected"), REFUSED, ids=[change[1] or "missing" for change, _ in REFUSED])
def test_refusals_name_field_value_and_expectation(change, expected):
    assert change[0] in TEXT
    with pytest.raises(hm.InputError) as caught:
        parse(TEXT.replace(*change), "my.toml")
    message = str(caught.value)
    assert message.startswith("my.toml: ")
    assert "\n" not in message
    for part in expected:
        assert part in message


@pytest.mark.parametrize(
    "text", ["", "[device]", "= 3", "x = 1", "\0", "a = " + "[" * 5000 + "]" * 5000, "a = " + "1" * 5000, TEXT + TEXT]
)
def test_files_that_are_no_scenario(text):
    with pytest.raises(hm.InputError):
        parse(text)


@given(st.text(max_size=60) | st.binary(max_size=60).map(lambda b: b.decode("latin-1")))
@settings(max_examples=150, deadline=None)
def test_any_text_is_refused_politely(text):
    with pytest.raises(hm.InputError):
        parse(text)


json_values = st.recursive(
    st.none()
    | st.booleans()
    | st.floats()
    | st.integers()
    | st.text(max_size=8)
    | st.sampled_from(["1 mm", "-2 Hz", "3 deg"]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=4,
)
PATHS = [
    *sorted(leaves(hm.load("nose-first/table1-row1"))),
    "device",
    "magnet",
    "drive",
    "run",
    "workspace",
    "nothing",
    "drive.x",
    "",
    ".",
]


@given(path=st.sampled_from(PATHS), value=json_values)
@settings(max_examples=400, deadline=None)
def test_any_change_is_made_or_refused(path, value):
    base = hm.load("nose-first/table1-row1")
    try:
        changed = base.replaced({path: value})
    except hm.InputError:
        return
    assert isinstance(changed, Scenario)
    assert parse(changed.to_toml()) == changed


def test_a_changed_value_loses_its_mark():
    base = hm.load("nose-first/table1-row1")
    assert "drive.pitch" not in base.replaced({"drive.pitch": "14 deg"}).provenance
    assert "drive.pitch" in base.replaced({"drive.distance": "100 mm"}).provenance
    whole = base.replaced({"device.head": {"shape": "sphere", "radius": "1 mm"}}).provenance
    assert not any(key.startswith("device.head") for key in whole)
    assert "workspace.walls" not in base.replaced({"workspace.walls.x": ["-1 m", "1 m"]}).provenance
    assert base.drive.pitch == hm.load("nose-first/table1-row1").drive.pitch


@pytest.mark.parametrize("name", ["paper/fig3c", "nose-first/table1-row3"])
def test_the_hash_is_that_of_all_that_decides_as_json(name):
    """It is put together from texts that parts keep, which no copy may inherit."""
    scenario = hm.load(name)
    assert len(scenario.hash) == 64
    held = scenario.model_copy(update={"workspace": scenario.workspace.model_copy(update={"floor": -0.07})})
    marked = scenario.replaced({"magnet.moment_uncertainty": 0.1}) if scenario.magnet[0].grade is None else scenario
    for one in (scenario, held, scenario.replaced({"drive.pitch": 0.1}), marked):
        whole = json.dumps(one.decisive, sort_keys=True)
        assert one.hash == hashlib.sha256(whole.encode()).hexdigest()
    assert held.hash != scenario.hash == marked.hash
    assert {field for field, _ in scenario.workspace} == set(type(scenario.workspace).model_fields)


@pytest.mark.parametrize("name", PRESETS)
def test_a_changed_scenario_is_the_same_as_one_checked_and_written_as_a_whole(name):
    scenario = hm.load(name)
    changes = {"drive.frequency": 1.7, "device.magnetic_moment": 3e-3, "magnet.radius": 0.0123, "run.duration": 77.0}
    changes |= {"workspace.surface": None, "drive.heading": "head", "device.weight.net_weight": 1e-4}
    for path, value in changes.items():
        for begun in (scenario, scenario.replaced({"drive.pitch": 0.1, "fluid.viscosity": 0.9})):
            changed = begun.replaced({path: value})
            whole = Scenario.model_validate(changed.model_dump())
            told = json.dumps(whole.decisive, sort_keys=True)
            assert changed == whole
            assert changed.hash == whole.hash == hashlib.sha256(told.encode()).hexdigest()
            for part in ("device", "drive", "fluid", "run", "workspace"):
                assert hash(getattr(changed, part)) == hash(getattr(whole, part))
            found = changed.model_dump()
            for step in path.split("."):
                found = found[step][0] if step == "magnet" else found[step]
            assert found == value


def test_what_is_refused_of_a_change_is_said_as_of_a_file():
    scenario = hm.load("nose-first/fig3c")
    for changes, told in (
        ({"drive.pitch": 2.0}, "drive.pitch must be between -90 deg and 90 deg; got '114.59155902616465 deg'"),
        ({"drive.frequency": 0.0}, "drive.frequency must not be zero; a negative one turns the magnet the other way"),
        ({"workspace.surface_pull": 1e-4}, 'workspace.surface_pull goes with a surface and contact = "hold" only'),
        (
            {"fluid.viscosity": -1.0, "drive.pitch": "15"},
            "fluid.viscosity must be positive; got '-1 Pa s'; drive.pitch must be an angle",
        ),
        ({"drive.pitsch": 0.1}, "'drive.pitsch' is not a field of a scenario; drive has frequency, pitch, "),
        ({"drive.distance": 1e-3}, "drive.distance must exceed "),
    ):
        with pytest.raises(hm.InputError) as caught:
            scenario.replaced(changes)
        assert str(caught.value).startswith(told)


def test_what_is_kept_of_a_part_does_not_go_with_its_copies():
    """Nor with a pickle, as another process has other hashes of the same words."""
    drive = hm.load("nose-first/fig3c").drive
    assert hash(drive) == hash(hm.load("nose-first/fig3c").drive)
    other = drive.model_copy(update={"frequency": 1.0})
    assert hash(other) != hash(drive)
    assert other.canonical != drive.canonical
    assert pickle.loads(pickle.dumps(drive)) == drive
    assert "_hash" in vars(drive)
    assert "_hash" not in vars(pickle.loads(pickle.dumps(drive)))


def test_scenarios_are_frozen_and_hash_what_decides():
    scenario = hm.load("nose-first/fig3c")
    with pytest.raises(ValueError, match="frozen"):
        scenario.name = "other"
    with pytest.raises(ValueError, match="frozen"):
        scenario.drive.pitch = 0.0
    assert scenario.replaced({"name": "other"}).hash == scenario.hash
    assert scenario.replaced({"drive.pitch": scenario.drive.pitch + 1e-15}).hash != scenario.hash


def test_schema_is_json_and_knows_every_field():
    told = json.loads(json.dumps(schema()))
    assert set(told["properties"]) == set(Scenario.model_fields)
    pitch = told["$defs"]["Drive"]["properties"]["pitch"]
    assert pitch["type"] == "string"
    assert pitch["description"].startswith("Elevation of the axis")
    assert pitch["description"].endswith("an angle with its unit.")


def test_every_key_says_what_it_means():
    told = schema()
    for name, part in {"Scenario": told, **told["$defs"]}.items():
        for key, rule in part["properties"].items():
            assert rule.get("description", "").endswith("."), f"{name}.{key} has no meaning"


def test_coil_of_a_million_turns_is_refused():
    scenario = hm.load("nose-first/fig3c").replaced({"device.helix.length": "99 m", "device.helix.pitch": "10 um"})
    with pytest.raises(hm.InputError, match=r"device\.helix\.length"):
        hm.simulate(scenario, duration=1.0)
