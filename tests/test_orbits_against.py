"""Orbits over grids of any dimension, over a whole range of an input, and against the verdicts of a sweep."""

import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray

import helimag as hm
from command_line import Said
from helimag.cli.orbit_against import _inputs
from helimag.orbits import OrbitComparison, Why, compare_with_orbits, comparison_dataset, stable_segments, survey
from helimag.orbits.beside_runs.against import _why, away_from_boundary
from helimag.orbits.curves import OrbitGrid
from helimag.orbits.strobe import Watch, open_water
from helimag.outcomes import End, Verdict
from helimag.sweeps import Nodes, nodes_of

PLAN = """
base = "nose-first/fig3c"
duration = "1800 s"
[[axis]]
field = "drive.pitch"
values = ["4.2 deg", "8 deg", "12.7 deg", "20 deg"]
[[axis]]
field = "drive.frequency"
values = ["2.2 Hz", "2.5 Hz", "3.3 Hz"]
"""


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("against")
    (folder / "plan.toml").write_text(PLAN)
    hm.sweep(folder / "plan.toml", out=folder / "runs.zarr")
    return folder / "runs.zarr"


def test_spread_over_three_inputs_finds_what_is_found_one_by_one() -> None:
    base = hm.load("nose-first/fig3c")
    values = {
        "drive.frequency": [2.2, 2.5, 2.8],
        "drive.pitch": [math.radians(p) for p in (8.0, 11.0, 14.0)],
        "drive.distance": [0.145, 0.150],
    }

    def scenario_at(node: tuple[int, ...]) -> hm.Scenario:
        return base.replaced({path: line[i] for (path, line), i in zip(values.items(), node, strict=True)})

    found = OrbitGrid(scenario_at, (3, 3, 2), length=0.15)
    found.seek_all_over(Watch())
    found.spread(Watch())
    for node in ((0, 0, 0), (2, 1, 1), (2, 2, 0)):
        orbit = hm.find_orbit(scenario_at(node))
        assert found.stable[node] == orbit.stable
        if orbit.stable:
            assert found.growth[node] == pytest.approx(orbit.growth, rel=1e-4)
            assert found.states[node][:3] == pytest.approx(orbit.position, abs=1e-8)
    assert found.stable.sum() > 9


def test_seeds_are_sought_on_a_grid_of_starts_where_runs_lead_to_none() -> None:
    """At 3.3 Hz and 8 degrees a run from the usual start leaves, though there is a stable orbit."""
    scenario = hm.load("nose-first/fig3c").replaced({"drive.pitch": "8 deg"})
    found = OrbitGrid(lambda _: scenario, (1,), length=0.15)
    found.seek((0,), Watch())
    assert not found.stable.any()
    found.seek_all_over(Watch())
    assert found.stable.all()


def test_survey_finds_the_stable_stretch_that_the_scenario_is_not_in() -> None:
    scenario = hm.load("nose-first/fig3c")
    assert not hm.find_orbit(scenario).stable
    (branch,) = survey(scenario, "drive.pitch", math.radians(6.5), math.radians(13.0))
    (part,) = stable_segments(branch)
    assert part.why_high == "fold"
    inside, outside = (
        hm.find_orbit(scenario.replaced({"drive.pitch": part.high + by}), near=branch.events[-1].orbit)
        for by in (-1e-4, 1e-4)
    )
    assert inside.found
    assert not outside.stable
    assert survey(scenario, "drive.pitch", math.radians(6.5), math.radians(13.0), known=[branch]) == [branch]


def test_nodes_of_a_sweep_are_the_scenarios_that_were_run(store: Path) -> None:
    nodes = nodes_of(hm.load_sweep(store))
    assert nodes.verdicts.shape == (4, 3)
    node = (2, 1)
    assert nodes.values_at(node) == {"drive.pitch": pytest.approx(math.radians(12.7)), "drive.frequency": 2.5}
    scenario = nodes.scenario_at(node)
    assert scenario is not None
    assert scenario.run.duration == 1800.0
    assert str(hm.simulate(scenario).verdict) == nodes.verdicts[node]


def test_nodes_need_a_grid(tmp_path: Path) -> None:
    (tmp_path / "plan.toml").write_text(
        'base = "nose-first/fig3c"\nduration = "10 s"\nsample = { method = "sobol", count = 4 }\n'
        '[[axis]]\nfield = "drive.pitch"\nstart = "4 deg"\nstop = "8 deg"\n'
    )
    dataset = hm.sweep(tmp_path / "plan.toml", out=tmp_path / "runs.zarr")
    with pytest.raises(hm.InputError, match="grid"):
        nodes_of(dataset)


def test_each_difference_is_run_on_and_named(store: Path) -> None:
    nodes = nodes_of(hm.load_sweep(store))
    result = compare_with_orbits(nodes.scenario_at, nodes.verdicts)
    assert result.stable[2].tolist() == [True, True, False]
    assert not result.stable[3].any()
    listed = {case.node: case for case in result.cases}
    for node in np.ndindex(result.verdicts.shape):
        inside = result.verdicts[node] in ("bounded", "drifting", "undecided")
        told = result.verdicts[node] not in ("drifting", "undecided")
        assert (node in listed) == (not told or inside != result.stable[node])
    late = listed[2, 2]  # Fig. 3(C): inside at its horizon, attracted at 2275 s
    assert late.why is Why.SLOW_DRIFT
    assert late.later is Verdict.ATTRACTED
    assert late.later_end == pytest.approx(2275.0, abs=5.0)
    assert listed[0, 0].why is Why.SHORT
    assert listed[1, 2].why is Why.BASIN
    assert result.beside[1, 2]
    assert "starts outside the basin" in result.text
    counted = result.decided & result.away
    assert f"{(result.agree & counted).sum()} of {counted.sum()} " in result.text
    assert "nan" not in result.text


@pytest.mark.parametrize(
    ("verdict", "stable", "stays", "beside", "why"),
    [
        (Verdict.FELL, True, False, True, Why.BASIN),
        (Verdict.DRIFTING, True, False, True, Why.BASIN),
        (Verdict.FELL, True, True, True, Why.SOON),
        (Verdict.DRIFTING, True, True, True, Why.SLOW_DRIFT),
        (Verdict.DRIFTING, False, False, False, Why.SLOW_DRIFT),
        (Verdict.UNDECIDED, False, False, False, Why.SLOW_DRIFT),
        (Verdict.BOUNDED, False, False, False, Why.SHORT),
        (Verdict.BOUNDED, False, True, False, Why.OTHER),
        (Verdict.FELL, True, False, False, Why.UNEXPLAINED),
    ],
)
def test_reasons(verdict: Verdict, stable: bool, stays: bool, beside: bool, why: Why) -> None:
    assert _why(verdict, stable, stays, beside) is why
    assert why.sentence


def test_nodes_beside_the_boundary_are_those_with_a_neighbour_of_the_other_kind() -> None:
    stable = np.zeros((5, 5), dtype=bool)
    stable[0, 0] = True
    away = away_from_boundary(stable)
    assert not away[:2, :2].any()
    assert away.sum() == 21


def test_the_command_prints_draws_and_reports(helimag: Callable[..., Said], store: Path, tmp_path: Path) -> None:
    picture, data = tmp_path / "map.png", tmp_path / "map.nc"
    status, out, err = helimag("orbit", "against", store, "--json", "-o", picture, "-o", data)
    assert (status, err) == (0, "")
    report = json.loads(out)
    assert report["nodes"] == 12
    assert {case["why"] for case in report["cases"]} >= {"slow drift", "starts outside the basin"}
    assert picture.stat().st_size > 10_000
    with xarray.open_dataset(data, engine="h5netcdf", decode_timedelta=False) as opened:
        meanings = opened.why.attrs["flag_meanings"].split()
        explained = int((opened.why > 0).sum())
        assert meanings[int(opened.why.values[2, 2])] == "slow_drift"
    assert explained == len(report["cases"])


def a_case_of(*plan: str, folder: Path) -> tuple[Nodes, OrbitComparison]:
    (folder / "plan.toml").write_text('base = "nose-first/fig3c"\nduration = "60 s"\n' + "\n".join(plan))
    nodes = nodes_of(hm.sweep(folder / "plan.toml", out=folder / "runs.zarr"))
    return nodes, compare_with_orbits(nodes.scenario_at, nodes.verdicts)


def an_axis(field: str, *values: str, along: str = "") -> str:
    return f'[[axis]]\nfield = "{field}"\nvalues = {list(values)}\n' + (f'zip = "{along}"' if along else "")


def test_a_grid_without_any_stable_orbit_is_compared_too(tmp_path: Path) -> None:
    nodes, result = a_case_of(an_axis("drive.pitch", "19 deg"), an_axis("drive.frequency", "4 Hz"), folder=tmp_path)
    assert not result.stable.any()
    assert not result.beside.any()
    assert math.isnan(result.share(beside=True))
    assert "nan" not in result.text
    assert [case.node for case in result.cases] == [(0, 0)]
    with pytest.raises(hm.InputError, match="must have a node"):
        compare_with_orbits(lambda _: None, nodes.verdicts)


def test_inputs_may_be_zipped_text_or_absent_from_the_base(tmp_path: Path) -> None:
    """Two that run along one dimension, models of the magnet's field, and a floor where the base has none."""
    nodes, result = a_case_of(
        an_axis("drive.pitch", "8 deg", "12 deg", along="both"),
        an_axis("drive.frequency", "2.4 Hz", "2.5 Hz", along="both"),
        an_axis("magnet.field", "dipole", "cylinder"),
        an_axis("workspace.floor", "-200 mm", "-1 mm"),
        folder=tmp_path,
    )
    assert result.stable[..., 0].all(), "both models of the field have the orbit"
    assert not result.stable[..., 1].any(), "a floor above it has not"
    states = result.states[:, :, 0, :3]
    assert np.linalg.norm(states[:, 1] - states[:, 0], axis=1).min() > 1e-6
    inputs = _inputs(nodes)
    data = comparison_dataset(result, nodes.base, inputs, nodes.dimensions)
    assert data.stability.dims == ("both", "magnet_field", "workspace_floor")
    assert data.drive_pitch.dims == data.drive_frequency.dims == ("both",)
    assert data.workspace_floor.attrs["units"] == "m"
    assert data.workspace_floor.values.tolist() == [-0.2, -0.001]
    assert data.magnet_field.attrs["flag_meanings"] == "dipole cylinder"


def test_shares_count_what_they_say() -> None:
    """Neither nodes beside the boundary, nor undecided runs, nor nodes without a run."""
    verdicts = np.array(["bounded", "fell", "drifting", "", "bounded", "fell"])
    growth = np.array([-1.0, -1.0, -1.0, -1.0, np.nan, 1.0])
    beside = np.array([True, True, False, False, False, False])
    away = np.array([True, True, True, True, True, False])
    result = OrbitComparison(verdicts, growth, growth, np.zeros((6, 7)), away, beside)
    assert result.agree.tolist() == [True, False, False, False, False, True]
    assert result.share() == pytest.approx(1.0 / 3.0)
    assert result.share(beside=True) == pytest.approx(2.0 / 4.0)


def test_a_run_whose_numbers_break_down_is_named(monkeypatch: pytest.MonkeyPatch, store: Path) -> None:
    from helimag.orbits.beside_runs import against

    nodes = nodes_of(hm.load_sweep(store))
    advance = against.advance
    broken = End.NOT_FINITE
    monkeypatch.setattr(
        against, "advance", lambda *args, **given: [replace(h, status=broken) for h in advance(*args, **given)]
    )
    one = hm.load("nose-first/fig3c").replaced({"run.duration": 5.0})
    result = compare_with_orbits(lambda _: one, np.array(["bounded"]))
    (case,) = result.cases
    assert case.later is None
    assert "broken down" in case.text
    assert nodes.verdicts.size


def test_walls_end_no_straight_run_beside_its_orbit() -> None:
    """A tank's end says nothing about the orbit, wherever it is; a wall that a device goes round into does."""
    base = hm.load("nose-first/fig3c").replaced({"workspace.walls.x": ["-9 mm", "9 mm"], "workspace.floor": "-1 m"})
    along = base.replaced({"drive.yaw_rate": 0.0, "drive.velocity": (1e-3, 0.0, 0.0)})
    rising = base.replaced({"drive.velocity": (0.0, 0.0, 1e-6)})
    assert open_water(base) == base
    assert open_water(along).workspace == hm.Scenario.model_validate(base).workspace.model_copy(
        update={"walls": type(base.workspace.walls)()}
    )
    assert open_water(rising).workspace.floor is None
    assert open_water(rising).workspace.walls.x == (-0.009, 0.009)
