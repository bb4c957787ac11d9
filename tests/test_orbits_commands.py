"""The commands map, flow and basin beside ``helimag orbit``: what they print, write and refuse."""

import json
import math
import tomllib
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
import xarray

import helimag as hm
from helimag import plots
from helimag.cli import orbit_grids
from helimag.cli._orbit_reports import flow_report, print_basin
from helimag.orbits import (
    Agreement,
    Basin,
    agreement,
    basin,
    basin_dataset,
    counterparts,
    fixed_points,
    list_orbits,
    map_dataset,
    save_dataset,
    slow_flow,
    stability_map,
)
from helimag.orbits.averaged import SlowFlow, attraction

pytestmark = pytest.mark.filterwarnings("ignore:Cyclopts application invoked without tokens")  # as from a shell
SCENARIO = ["nose-first/fig3c", "--set", "drive.frequency=2.5 Hz"]
RANGES = ["--vary", "drive.pitch=11 deg..17 deg", "--vary", "drive.frequency=2.4 Hz..2.6 Hz"]
REACH = 0.036


@pytest.fixture
def run(helimag):
    return helimag


@pytest.fixture(scope="module")
def orbit() -> hm.Orbit:
    return hm.find_orbit(hm.load("nose-first/fig3c").replaced({"drive.frequency": "2.5 Hz"}))


@pytest.fixture(scope="module")
def flow(orbit: hm.Orbit) -> SlowFlow:
    return slow_flow(orbit, low=orbit.position - REACH, high=orbit.position + REACH, shape=(7, 7, 7))


def read(path: Path) -> xarray.Dataset:
    """A file as xarray sees it, after h5py has found nothing in it but numbers in one group."""
    with h5py.File(path) as raw:
        for name, item in raw.items():
            assert isinstance(item, h5py.Dataset), f"{name} is a group"
            assert item.dtype.kind in "fi", f"{name} is not numbers but {item.dtype}"
        assert "scenario" in raw.attrs
    with xarray.open_dataset(path, engine="h5netcdf", decode_timedelta=False) as opened:
        dataset = opened.load()
    for name, variable in dataset.variables.items():
        assert "long_name" in variable.attrs, name
        if variable.dtype.kind == "f":
            assert variable.attrs["units"], name
        elif "flag_values" in variable.attrs:
            assert variable.attrs["flag_values"].dtype == variable.dtype, "CF: flags have the variable's type"
            words, values = variable.attrs["flag_meanings"].split(), np.atleast_1d(variable.attrs["flag_values"])
            assert len(words) == len(values)
            assert set(np.unique(variable)) <= set(values)
    assert hm.Scenario.model_validate(tomllib.loads(dataset.attrs["scenario"])).drive.frequency > 0.0
    assert json.loads(dataset.attrs["versions"])["helimag"]
    return dataset


def test_orbit_alone_still_works_and_writes_data(run, tmp_path):
    status, out, _ = run("orbit", *SCENARIO, "--json")
    assert status == 0
    assert json.loads(out)["stable"]
    target = tmp_path / "branch.nc"
    limits = ["--vary", "drive.pitch", "--from", "12 deg", "--to", "16 deg"]
    status, out, _ = run("orbit", *SCENARIO, *limits, "-o", target, "-o", tmp_path / "branch.svg", "--json")
    assert status == 0
    report, data = json.loads(out), read(target)
    assert (tmp_path / "branch.svg").stat().st_size > 0
    assert data.drive_pitch.values.tolist() == [point["value"] for point in report["branches"][0]["points"]]
    assert data.position.values.tolist() == [point["position_m"] for point in report["branches"][0]["points"]]
    assert data.stable.values.tolist() == [point["stable"] for point in report["branches"][0]["points"]]
    assert data.change_drive_pitch.values.tolist() == [change["value"] for change in report["branches"][0]["changes"]]
    assert data.change_kind.attrs["flag_meanings"] == "fold"
    assert data.drive_pitch.attrs["units"] == "rad"


def test_a_scenario_named_like_a_command_is_given_with_its_folder(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("map").write_text(hm.load("nose-first/fig3c").replaced({"drive.frequency": "2.5 Hz"}).to_toml())
    status, out, _ = run("orbit", "./map", "--json")
    assert status == 0
    assert json.loads(out)["stable"]


def test_map_as_json_and_in_files(run, tmp_path):
    figure, target = tmp_path / "map.png", tmp_path / "map.nc"
    status, out, err = run("orbit", "map", *SCENARIO, *RANGES, "--nodes", "4", "-o", figure, "-o", target, "--json")
    assert (status, err.strip()) == (0, "")
    report, data = json.loads(out), read(target)
    assert figure.read_bytes()[:4] == b"\x89PNG"
    assert [given["path"] for given in report["inputs"]] == ["drive.pitch", "drive.frequency"]
    assert report["nodes"] == 16
    assert report["files"] == [str(figure), str(target)]
    assert data.growth.dims == ("drive_pitch", "drive_frequency")
    assert np.count_nonzero(data.stability == 2) == report["stable"] == np.count_nonzero(data.growth < 0.0)
    assert np.count_nonzero(data.stability > 0) == report["with_orbit"]
    assert math.degrees(data.drive_pitch[-1]) == pytest.approx(17.0)
    # at 11 deg the orbit is stable and at 17 deg it is gone, and in between is the fold that continuation finds
    assert (data.stability[0] == 2).all()
    assert (data.stability[-1] == 0).all()
    (curve,) = report["boundary"]
    assert curve["kind"] == "fold"
    assert data.boundary_drive_pitch.values.tolist() == curve["first"]
    assert data.boundary_drive_frequency.values.tolist() == curve["second"]
    assert data.boundary_kind.attrs["flag_meanings"] == "fold"
    order = np.argsort(curve["second"])
    at = np.interp(2.5, np.array(curve["second"])[order], np.degrees(curve["first"])[order])
    assert at == pytest.approx(15.419, abs=0.02)


def test_map_in_words(run):
    status, out, _ = run("orbit", "map", *SCENARIO, *RANGES, "--nodes", "3")
    assert status == 0
    assert "of 9 nodes of pitch and frequency" in out
    assert "steadiest     pitch" in out
    assert "boundary      fold" in out
    nowhere = ["--vary", "drive.pitch=17 deg..18 deg", "--vary", "drive.frequency=3.8 Hz..4 Hz"]
    status, out, _ = run("orbit", "map", *SCENARIO, *nowhere, "--nodes", "2")
    assert status == 0
    assert "nowhere stable" in out


def test_curves_of_a_boundary_go_into_the_file(tmp_path):
    """Point by point, each with the number of its curve."""
    scenario = hm.load("nose-first/fig3c").replaced({"drive.frequency": "2.5 Hz"})
    result = stability_map(scenario, ("drive.pitch", [0.2, 0.22]), ("drive.frequency", [2.4, 2.6]))
    curves = [
        SimpleNamespace(
            kind=kind,
            first=np.linspace(0.20, 0.22, size),
            second=np.linspace(2.4, 2.6, size),
            states=np.full((size, 7), float(size)),
            swing=np.full(size, 0.03),
            ends=("edge of the map", "closed"),
        )
        for kind, size in (("fold", 3), ("Neimark-Sacker", 2))
    ]
    save_dataset(map_dataset(result, curves), tmp_path / "map.nc")
    data = read(tmp_path / "map.nc")
    assert data.boundary_curve.values.tolist() == [0, 0, 0, 1, 1]
    assert data.boundary_kind.values.tolist() == [0, 0, 0, 1, 1]
    assert data.boundary_kind.attrs["flag_meanings"] == "fold Neimark-Sacker"
    assert data.boundary_position.values[:, 0].tolist() == [3.0, 3.0, 3.0, 2.0, 2.0]
    assert data.boundary_drive_frequency.values.tolist() == [2.4, 2.5, 2.6, 2.4, 2.6]


def test_fixed_points_of_the_flow_are_the_orbits(orbit: hm.Orbit, flow: SlowFlow) -> None:
    """Each within the error that it states, which knows nothing of the orbits; and none is missing."""
    listed = list_orbits(orbit.scenario, low=list(orbit.position - REACH), high=list(orbit.position + REACH))
    points = fixed_points(flow)
    pairs = counterparts(points, listed, flow)
    assert len(points) == len(pairs) == 2
    assert all(pair.point is not None and pair.orbit is not None for pair in pairs)
    cell = flow.axes[0][1] - flow.axes[0][0]
    for pair in pairs:
        assert pair.distance < 1.2 * pair.point.error + 1e-8
        assert pair.distance > 0.5 * pair.point.error - 1e-7
        assert pair.point.error < 0.2 * cell
        assert pair.point.stable == pair.orbit.stable
        assert pair.point.rates[0].real == pytest.approx(pair.orbit.rates[0].real, rel=0.4)
    assert [pair.point.kind for pair in pairs] == ["spiral sink", "spiral saddle, 1 of 3 directions unstable"]
    assert pairs[1].point.error > 1e-4, "the saddle lies between nodes, so its error is not rounding"
    # the third orbit of this box has its nose the other way: it is none of this flow
    assert len(listed) == 3


def test_a_flow_without_zeros_has_no_fixed_points(orbit: hm.Orbit, flow: SlowFlow) -> None:
    steady = SlowFlow(flow.scenario, flow.axes, np.ones_like(flow.velocity), flow.states, flow.settled)
    assert fixed_points(steady) == []
    (alone,) = counterparts([], [orbit], steady)
    assert alone.point is None
    assert alone.orbit is orbit
    assert math.isnan(alone.distance)


def test_fixed_points_of_a_flow_known_in_closed_form(flow: SlowFlow) -> None:
    """Linear in each coordinate but for z, where it is cubic: three zeros, of which the middle one is a sink."""
    x, y, z = np.meshgrid(*flow.axes, indexing="ij")
    a, b, c = (axis.mean() for axis in flow.axes)
    width = 0.5 * (flow.axes[2][-1] - c)
    height = (z - c) / width
    velocity = np.stack(
        [-0.01 * (x - a) - 0.03 * (y - b), 0.03 * (x - a) - 0.01 * (y - b), 1e-4 * (height**3 - height)]
    )
    known = SlowFlow(flow.scenario, flow.axes, np.moveaxis(velocity, 0, -1), flow.states, flow.settled | True)
    points = fixed_points(known)
    # the spline's edges are not the cubic's, so zeros near them are off a little
    assert [point.stable for point in points] == [True, False, False]
    assert points[0].position == pytest.approx([a, b, c], abs=1e-9)
    assert sorted(points[0].rates.imag) == pytest.approx([-0.03, 0.0, 0.03], abs=1e-3)
    assert sorted(points[0].rates.real)[0] == pytest.approx(-0.01, abs=5e-4)
    assert sorted(point.position[2] for point in points[1:]) == pytest.approx([c - width, c + width], abs=2e-3)


def test_flow_as_json_and_in_files(run, orbit, monkeypatch, tmp_path):
    monkeypatch.setattr(orbit_grids, "STARTS", 4)
    figure, target = tmp_path / "flow.pdf", tmp_path / "flow.nc"
    words = ["orbit", "flow", *SCENARIO, "--box", "36 mm", "--nodes", "7", "-o", figure, "-o", target, "--json"]
    status, out, err = run(*words)
    assert (status, err.strip()) == (0, "")
    report, data = json.loads(out), read(target)
    assert figure.read_bytes()[:4] == b"%PDF"
    assert report["nodes"] == 7**3
    assert report["box_m"][0] == pytest.approx([orbit.position[0] - 0.036, orbit.position[0] + 0.036])
    averaged, floquet = (np.array(report[f"{name}_rates_per_s"]) for name in ("averaged", "floquet"))
    assert averaged[:, 1] == pytest.approx(floquet[:, 1], abs=1e-3)
    assert floquet[0] == pytest.approx([-0.00053, 0.0310], rel=0.03)
    assert len(report["fixed_points"]) == 2
    assert report["orbits_without_fixed_point_m"] == []
    assert report["orbits_of_other_sense"] == 1
    assert all(0.0 < error["mean_m"] <= error["worst_m"] < 3e-3 for error in report["averaging_error"])
    assert data.velocity.shape == (7, 7, 7, 3)
    assert int(data.settled.sum()) == report["settled"]
    assert data.fixed_point_position.values.tolist() == [point["position_m"] for point in report["fixed_points"]]
    assert data.orbit_position.values[0] == pytest.approx(orbit.position, abs=1e-7)


def test_flow_in_words_with_corners_of_a_box(run, monkeypatch):
    monkeypatch.setattr(orbit_grids, "STARTS", 3)
    box = "-30 mm..20 mm, -40 mm..10 mm, -35 mm..10 mm"
    status, out, _ = run("orbit", "flow", *SCENARIO, "--box", box, "--nodes", "5")
    assert status == 0
    assert "125 nodes" in out
    assert "Floquet  -0.0005352 ± 0.03104i" in out
    assert "spiral sink" in out
    assert "beside a full run of 1800 s" in out


def test_basin_by_runs(run, tmp_path):
    figure, target = tmp_path / "basin.png", tmp_path / "basin.nc"
    words = ["--box", "12 mm", "--nodes", "2", "--duration", "900 s", "-o", figure, "-o", target]
    status, out, err = run("orbit", "basin", *SCENARIO, *words, "--json")
    assert (status, err.strip()) == (0, "")
    report, data = json.loads(out), read(target)
    assert figure.read_bytes()[:4] == b"\x89PNG"
    assert report["ends"] == {"captured": 8}
    assert report["volume_m3"] == pytest.approx(0.024**3)
    assert report["reaches_edge"]
    assert report["agreement"] is None
    assert data.captured.values.all()
    assert data.attrs["engine"] == "full"
    assert data.attrs["duration"] == 900.0
    assert "end_by_full_run" not in data


def test_basin_by_the_averaged_model_says_how_far_to_trust_it(run, monkeypatch, tmp_path):
    monkeypatch.setattr(attraction, "ENGINE_NODES", 8)
    target = tmp_path / "basin.nc"
    words = ["--engine", "averaged", "--box", "40 mm", "--nodes", "4", "--check", "6", "-o", target]
    status, out, _ = run("orbit", "basin", *SCENARIO, *words, "--duration", "1200 s", "--json")
    assert status == 0
    report, data = json.loads(out), read(target)
    agreed = report["agreement"]
    assert agreed["starts"] == 6 == sum(agreed[name] for name in ("both", "only_averaged", "only_full", "neither"))
    assert agreed["share"] == (agreed["both"] + agreed["neither"]) / 6
    assert agreed["interval"][0] <= agreed["share"] <= agreed["interval"][1]
    run_too = data.end_by_full_run.values != 8
    assert run_too.sum() == 6
    full = data.end_by_full_run.values[run_too] == 0
    assert (full == data.captured.values[run_too]).mean() == agreed["share"]
    assert report["captured_share"] == pytest.approx(report["volume_m3"] / 0.08**3)


def test_agreement_counts_and_interval():
    """Wilson's interval against its table: 54 of 60 is 0.90, from 0.799 to 0.953."""
    averaged = np.array(["captured"] * 40 + ["left"] * 20)
    full = np.array(["captured"] * 38 + ["fell"] * 2 + ["captured"] * 4 + ["attracted"] * 16)
    found = Agreement(np.arange(60), averaged, full)
    assert found.counts == {"both": 38, "only_averaged": 2, "only_full": 4, "neither": 16}
    assert found.share == pytest.approx(0.9)
    assert found.interval == pytest.approx((0.7985, 0.9534), abs=2e-4)


def test_basin_refuses_a_comparison_with_itself(orbit: hm.Orbit) -> None:
    cells = np.zeros((8, 3))
    full = Basin(orbit, (2, 2, 2), cells, np.ones(8, bool), np.full(8, "captured"), 1.0, 1200.0, "full")
    with pytest.raises(hm.InputError, match="averaged"):
        agreement(full)


def test_a_basin_says_how_little_a_few_starts_tell(orbit: hm.Orbit, capsys: pytest.CaptureFixture[str]) -> None:
    """Eight of eight captured is a share of 0.676 to 1 (Wilson: n / (n + 1.96^2)), of a box of 8 cm3."""
    places = np.stack(np.meshgrid(*[[-0.005, 0.005]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    ends = np.full(8, "captured")
    caught = Basin(orbit, (2, 2, 2), places, np.ones(8, bool), ends, 8e-6, 0.5 / -orbit.growth, "full")
    least = 8.0 / (8.0 + 1.96**2)
    assert caught.interval == pytest.approx((least, 1.0))
    assert f"basin of 8.0 cm3 ({8.0 * least:.1f} to 8.0) in this box: of 8 starts 8 captured" in caught.text
    print_basin(caught, None, (places.min(axis=0), places.max(axis=0)), None, json=False)
    said = capsys.readouterr().out
    assert "captured      100 % of the box of 10 x 10 x 10 mm; 68 to 100 %, with 95 % confidence" in said
    assert f"end before the orbit's longest decay time, {-1.0 / orbit.growth:.0f} s" in said
    print_basin(replace(caught, duration=-1.1 / orbit.growth), None, (places[0], places[-1]), None, json=False)
    assert "end before" not in capsys.readouterr().out


def test_flow_is_known_on_the_faces_of_its_grid(flow: SlowFlow) -> None:
    for axis in range(3):
        for side in (0, -1):
            places = np.take(flow.states[..., :3], side, axis=axis)[np.take(flow.settled, side, axis=axis)]
            assert np.isfinite(flow.at(places)).all()
    beyond = np.array([axis[-1] + 1e-6 for axis in flow.axes])
    assert np.isnan(flow.at(beyond[None])).all()


def test_cells_fill_the_box(orbit: hm.Orbit, flow: SlowFlow) -> None:
    low, high = orbit.position - 0.01, orbit.position + np.array([0.01, 0.02, 0.01])
    caught = basin(orbit, low=low, high=high, shape=(2, 3, 2), flow=flow, duration=1200.0)
    assert caught.cell == pytest.approx([0.01, 0.01, 0.01])
    assert [axis[0] for axis in caught.axes] == pytest.approx(low + 0.005)
    assert caught.volume == pytest.approx(12e-6 * caught.captured.mean())
    assert basin_dataset(caught)["end"].shape == (2, 3, 2)


def test_pictures_show_every_end_and_fixed_point(orbit: hm.Orbit, flow: SlowFlow) -> None:
    names = np.array(["captured", "stayed", "attracted", "fell", "wall-limited", "out of step", "left", "left"])
    steps = np.linspace(-0.01, 0.01, 2)
    places = orbit.position + np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
    caught = Basin(orbit, (2, 2, 2), places, names == "captured", names, 1e-6, 1200.0, "full")
    figure = plots.draw_basin(caught)
    shown = [text.get_text() for text in figure.legends[0].get_texts()]
    assert shown[:7] == [
        "captured (1)",
        "stayed (1)",
        "attracted (1)",
        "fell (1)",
        "wall-limited (1)",
        "out of step (1)",
        "left (2)",
    ]
    points = fixed_points(flow)
    figure = plots.draw_flow(flow, orbit, caught, fixed_points=points)
    shown = [text.get_text() for text in figure.legends[0].get_texts()]
    assert {"stable fixed point", "saddle"} <= set(shown)
    faces = [
        [line.get_markerfacecolor() for line in axis.lines if line.get_marker() == "o"] for axis in figure.axes[:3]
    ]
    assert all(len(set(each)) == len(points) == 2 for each in faces), "stable full, saddle open"


def test_nothing_slow_where_the_device_is_drawn_in(orbit: hm.Orbit) -> None:
    """Beside the magnet a turn moves the device far; such nodes are left out, and the rest stays smooth."""
    arm = np.array([-0.033, -0.045, 0.138])
    near = slow_flow(orbit, low=arm - np.array([0.05, 0.05, 0.09]), high=arm + 0.05, shape=(5, 5, 5), lag_stages=1)
    assert not near.settled.all()
    gap = np.linalg.norm(near.states[..., :3] - arm, axis=-1)
    period = 1.0 / orbit.scenario.drive.frequency
    speed = np.linalg.norm(near.velocity, axis=-1)
    assert (speed[near.settled] * period < 0.1 * gap[near.settled]).all()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["map", "nose-first/fig3c", "--vary", "drive.pitch=4 deg..20 deg"], "--vary must be given twice"),
        (
            ["map", "nose-first/fig3c", "--vary", "drive.pitch=4 deg..5 deg", "--vary", "drive.pitch=4 deg..5 deg"],
            "two diff",
        ),
        (["map", "nose-first/fig3c", "--vary", "drive.pitch=20 deg..4 deg", RANGES[2], RANGES[3]], "from low to high"),
        (["map", "nose-first/fig3c", "--vary", "drive.pitch=4 deg", RANGES[2], RANGES[3]], "--vary must be an input"),
        (
            ["map", "nose-first/fig3c", "--vary", "drive.pitch=4 mm..5 mm", RANGES[2], RANGES[3]],
            "drive.pitch must be an angle",
        ),
        (["map", "nose-first/fig3c", "--vary", "drive.pitch=nan deg..5 deg", RANGES[2], RANGES[3]], "nan"),
        (["map", "nose-first/fig3c", "--vary", "drive.pith=4 deg..5 deg", RANGES[2], RANGES[3]], "not a field"),
        (
            ["map", "nose-first/fig3c", *RANGES, "--nodes", "1"],
            "--nodes must be a whole number from 2 to 1000; got '1'",
        ),
        (["map", "nose-first/fig3c", *RANGES, "-o", "map.txt"], "--output must end in"),
        (["map", "nose-first/fig3c", *RANGES, "-o", "nowhere/map.nc"], "nowhere"),
        (["map", "nowhere.toml", *RANGES], "nowhere.toml"),
        (["flow", "nose-first/fig3c", "--nodes", "3"], "--nodes must be a whole number from 4 to 100; got '3'"),
        (["flow", "nose-first/fig3c", "--box", "40 deg"], "a length"),
        (["flow", "nose-first/fig3c", "--box", "-40 mm"], "farther than nothing"),
        (["flow", "nose-first/fig3c", "--box", "1 mm..2 mm"], "three ranges"),
        (["flow", "nose-first/fig3c", "--box", "1 mm..2 mm, 2 mm..1 mm, 0 mm..1 mm"], "from low to high"),
        (["flow", "nose-first/fig3c", "-o", "flow.nc", "-o", "flow.txt"], "--output must end in"),
        (["basin", "nose-first/fig3c", "--nodes", "1"], "--nodes must be a whole number from 2 to 100; got '1'"),
        (["basin", "nose-first/fig3c", "--engine", "exact"], "engine"),
        (["basin", "nose-first/fig3c", "--duration", "0 s"], "--duration must be positive"),
        (["basin", "nose-first/fig3c", "--duration", "3 mm"], "a time"),
        (["basin", "nose-first/fig3c", "--check", "0"], "--check must be a whole number from 1 to 100000"),
        (["basin", "nose-first/fig3c", "-o", "."], "--output must end in"),
    ],
)
def test_bad_input_is_one_line_and_writes_nothing(run, tmp_path, monkeypatch, words, said):
    monkeypatch.chdir(tmp_path)
    refused(run("orbit", *words), said)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["flow", "nose-first/fig3c", "--set", "drive.distance=1 m"], "no orbit that this could be around: lost step"),
        (["basin", "nose-first/fig3a", "--engine", "averaged"], "needs a stable orbit"),
    ],
)
def test_a_scenario_without_the_orbit_is_one_line_and_writes_nothing(run, tmp_path, monkeypatch, words, said):
    """Only runs show that there is none: these two may compile."""
    monkeypatch.chdir(tmp_path)
    refused(run("orbit", *words, refused_by_a_run=True), said)
    assert list(tmp_path.iterdir()) == []


def refused(done, said):
    status, out, err = done
    assert status == 2, err
    assert out == ""
    assert said in err
    assert err.count("\n") == 1


def test_a_flow_beside_its_orbit_has_no_rates_to_compare(orbit: hm.Orbit) -> None:
    low = orbit.position + np.array([0.004, 0.0, 0.0])
    aside = slow_flow(orbit, low=low, high=low + 0.006, shape=(4, 4, 4), lag_stages=1)
    report = flow_report(aside, orbit, [], 0, [])
    assert report["averaged_rates_per_s"] is None
    assert np.isfinite(report["floquet_rates_per_s"]).all()
